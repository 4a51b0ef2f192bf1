//! The file of `--log`, before rendering begins: it can be written, and it is none of the pictures.

use crate::error::Failure;
use crate::options::RenderOptions;
use crate::output::Outputs;
use std::fs::{self, OpenOptions};
use std::path::Path;

/// Fails early where the log cannot be written or would be written over. What is there stays until rendering begins.
pub fn check(options: &RenderOptions, outputs: &Outputs) -> Result<(), Failure> {
    let Some(path) = &options.log else { return Ok(()) };
    // A link may lead to what is not there yet.
    let is_new = !path.exists();
    let opened = OpenOptions::new().append(true).create(true).open(path);
    // While the file is there, every name of it leads to it, whatever the file system takes for the same name.
    let picture = outputs.paths().find(|output| is_same(path, output));
    if is_new && opened.is_ok() {
        let _ = fs::remove_file(path.canonicalize().as_deref().unwrap_or(path));
    }
    opened.map_err(|e| Failure::Arguments(format!("--log {}: cannot be written: {e}", path.display())))?;
    match picture {
        Some(picture) => Err(Failure::Arguments(format!(
            "--log {}: is the same file as the picture {}; choose another name for one of them",
            path.display(),
            picture.display()
        ))),
        None => Ok(()),
    }
}

/// Whether both lead to one plain file. Devices such as `/dev/null` take any number of writers.
fn is_same(log: &Path, output: &Path) -> bool {
    log.is_file() && same_file::is_same_file(log, output).unwrap_or(false)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_is_no_picture_by_any_name() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let refused = |log: &str, output: &str| {
            let (log, output) = (Some(at(log)), Some(vec![at(output)]));
            let options = RenderOptions { log, output, ..RenderOptions::default() };
            let outputs = Outputs::plan(&options, "a").unwrap();
            check(&options, &outputs).is_err()
        };
        fs::create_dir(at("sub")).unwrap();
        assert!(refused("new.png", "new.png") && refused("new.png", "sub/../new.png"));
        assert!(!refused("new.png", "other.png") && !refused("a.jsonl", "a.png"));
        let names = || fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(names(), 1, "looking leaves nothing behind");
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(at("new.png"), at("soft.jsonl")).unwrap();
            assert!(refused("soft.jsonl", "new.png") && !at("new.png").exists());
            fs::write(at("old.png"), "picture").unwrap();
            fs::hard_link(at("old.png"), at("hard.jsonl")).unwrap();
            assert!(refused("hard.jsonl", "old.png"));
            assert_eq!(fs::read(at("old.png")).unwrap(), b"picture");
        }
    }
}
