//! Checks of the `--log` file before rendering begins: it must be writable and must not be one of the images.

use crate::error::Failure;
use crate::options::RenderOptions;
use crate::output::Outputs;
use std::fs::{self, OpenOptions};
use std::path::Path;

/// Fails if the log cannot be written or would be overwritten by an image. An existing file stays unchanged until
/// rendering begins.
pub fn check(options: &RenderOptions, outputs: &Outputs) -> Result<(), Failure> {
    let Some(path) = &options.log else { return Ok(()) };
    // A link may lead to a missing file.
    let is_new = !path.exists();
    let opened = OpenOptions::new().append(true).create(true).open(path);
    // While the file exists, all its names lead to it, whatever names the file system treats as equal.
    let picture = outputs.paths().find(|output| is_same(path, output));
    if is_new && opened.is_ok() {
        let _ = fs::remove_file(path.canonicalize().as_deref().unwrap_or(path));
    }
    opened.map_err(|e| Failure::Arguments(format!("--log {}: cannot be written: {e}", path.display())))?;
    match picture {
        Some(picture) => Err(Failure::Arguments(format!(
            "--log {}: is the same file as the image {}; choose another name for one of them",
            path.display(),
            picture.display()
        ))),
        None => Ok(()),
    }
}

/// Whether both paths lead to the same regular file. Devices such as `/dev/null` accept any number of writers.
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
        assert_eq!(names(), 1, "the check leaves no file behind");
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
