//! Atomic writing of files: a temporary file in the folder of the target is renamed to the target.
//!
//! A process that is killed while writing leaves its temporary file `.dapple-HOST-RANDOM.part` behind. A writer holds a
//! lock on its file as long as it is alive, so that a later process can identify abandoned files and remove them.

use crate::ImageError;
use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use tempfile::NamedTempFile;

/// Replaces the file at `path` by `bytes`; on failure the old file remains unchanged.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<(), ImageError> {
    let target = target(path)?;
    let failed = |source| ImageError::Write { path: path.to_path_buf(), source: anonymous(source) };
    permitted(&target).map_err(failed)?;
    let mut file = create_temporary(&target).map_err(failed)?;
    file.write_all(bytes).map_err(failed)?;
    // Without this, a crash of the machine may keep the new name and lose the bytes.
    file.as_file().sync_all().map_err(failed)?;
    file.persist(&target).map(drop).map_err(|e| failed(e.error))
}

/// Saves a file that could not be written to `path`: in the same folder under an unused name, or otherwise in a new
/// folder within the system's temporary folder, which is the same for all files that this process saves there. Returns
/// the path of the saved file.
pub fn elsewhere(
    path: &Path,
    write: impl Fn(&Path) -> Result<(), ImageError>,
) -> Result<PathBuf, ImageError> {
    let free = (1..=MOST_NAMES).map(|i| numbered(path, i)).find(is_free);
    if let Some(at) = free.filter(|at| write(at).is_ok()) {
        return Ok(at);
    }
    static FOLDER: Mutex<Option<PathBuf>> = Mutex::new(None);
    let mut known = FOLDER.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = match known.take().filter(|folder| folder.is_dir()) {
        Some(folder) => folder,
        None => {
            let failed = |source| ImageError::Write { path: std::env::temp_dir(), source: anonymous(source) };
            tempfile::Builder::new().prefix("dapple-").tempdir().map_err(failed)?.keep()
        }
    };
    let named = folder.join(path.file_name().unwrap_or("picture".as_ref()));
    let mut names = std::iter::once(named.clone()).chain((1..=MOST_NAMES).map(|i| numbered(&named, i)));
    let at = names.find(is_free).unwrap_or(named);
    let written = write(&at);
    // An empty folder is removed.
    if written.is_ok() || fs::remove_dir(&folder).is_err() {
        *known = Some(folder);
    }
    written.map(|()| at)
}

fn is_free(at: &PathBuf) -> bool {
    fs::symlink_metadata(at).is_err_and(|e| e.kind() == ErrorKind::NotFound)
}

/// The number of names to be tried in a folder.
const MOST_NAMES: u32 = 99;

/// `folder/NAME-1.exr` for `folder/NAME.exr`.
fn numbered(path: &Path, i: u32) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_os_string();
    name.push(format!("-{i}"));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

/// Creates and removes a temporary file in the folder of `path`, and removes the files that killed writers have left
/// there.
pub fn probe(path: &Path) -> Result<(), ImageError> {
    let target = target(path)?;
    remove_abandoned(folder(&target));
    let failed = |source| ImageError::Write { path: path.to_path_buf(), source: anonymous(source) };
    // The temporary file has another name: this detects a name that is too long or not valid.
    match fs::symlink_metadata(&target) {
        Err(e) if !matches!(e.kind(), ErrorKind::NotFound | ErrorKind::PermissionDenied) => {
            return Err(failed(e));
        }
        _ => {}
    }
    permitted(&target).map_err(failed)?;
    create_temporary(&target).and_then(NamedTempFile::close).map_err(failed)
}

/// The error without the path of the temporary file, which tempfile adds to it; the user requested another path.
fn anonymous(error: io::Error) -> io::Error {
    match error.to_string().split_once(" at path \"") {
        Some((said, _)) => io::Error::new(error.kind(), said),
        None => error,
    }
}

/// Checks that an existing file may be written. Renaming another file over it would need no such permission.
fn permitted(target: &Path) -> io::Result<()> {
    let Ok(found) = fs::metadata(target) else { return Ok(()) };
    if found.permissions().readonly() {
        return Err(io::Error::new(ErrorKind::PermissionDenied, "the existing file is read-only"));
    }
    match OpenOptions::new().write(true).open(target) {
        Err(e) if e.kind() == ErrorKind::PermissionDenied => Err(e),
        _ => Ok(()),
    }
}

/// The file to be replaced: the target of a symbolic link, whether it exists or not, so that the link itself is
/// preserved. Only regular files are replaced, because renaming over a device such as /dev/null would remove it.
fn target(path: &Path) -> Result<PathBuf, ImageError> {
    let target = match fs::canonicalize(path) {
        Ok(target) => target,
        Err(_) => followed(path)?,
    };
    match fs::metadata(&target) {
        Ok(at) if !at.is_file() => Err(ImageError::NotAFile { name: path.display().to_string() }),
        _ if folder(&target).is_dir() => Ok(target),
        _ => Err(ImageError::NoFolder { path: path.to_path_buf(), folder: folder(&target).to_path_buf() }),
    }
}

/// The path, in an existing folder without symbolic links, of the file that writing to `path` creates or replaces: the
/// same for all paths that lead to the same file.
pub fn destination(path: &Path) -> Result<PathBuf, ImageError> {
    let target = target(path)?;
    let folder = fs::canonicalize(folder(&target)).unwrap_or_else(|_| folder(&target).to_path_buf());
    Ok(target.file_name().map_or_else(|| target.clone(), |name| folder.join(name)))
}

/// The missing file that a chain of symbolic links leads to.
fn followed(path: &Path) -> Result<PathBuf, ImageError> {
    const MOST_LINKS: u32 = 40;
    let mut at = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        let Ok(next) = fs::read_link(&at) else { return Ok(at) };
        at = folder(&at).join(next);
    }
    let source = io::Error::other("its symbolic links have no end");
    Err(ImageError::Write { path: path.to_path_buf(), source })
}

fn folder(target: &Path) -> &Path {
    target.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Number of random characters in the name of a temporary file.
const RANDOM: usize = 6;

/// Prefix and suffix of the names of this machine's temporary files. The host is included because locks held by other
/// machines may not be visible.
fn affixes() -> (String, &'static str) {
    let host = gethostname::gethostname();
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '.' { c } else { '_' };
    let host: String = host.to_string_lossy().chars().take(64).map(plain).collect();
    (format!(".dapple-{host}-"), ".part")
}

fn create_temporary(target: &Path) -> io::Result<NamedTempFile> {
    let (prefix, suffix) = affixes();
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(suffix).rand_bytes(RANDOM);
    // tempfile's default mode is 0600; images are not secret, so the user's umask applies.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    loop {
        let file = builder.tempfile_in(folder(target))?;
        // If locks are not supported, no file can be locked, and none is considered abandoned.
        let locked = file.as_file().lock();
        // A process that considered it abandoned before it was locked has removed it by now.
        if locked.is_err() || file.path().exists() {
            return Ok(file);
        }
    }
}

/// Removes temporary files of this machine that no writer has locked. Files that cannot be removed are skipped.
fn remove_abandoned(folder: &Path) {
    for path in fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()) {
        if !is_temporary(&path) || !fs::symlink_metadata(&path).is_ok_and(|at| at.is_file()) {
            continue;
        }
        // The lock is held until the file is removed, so that a writer cannot acquire it in between.
        if let Ok(file) = File::open(&path)
            && file.try_lock().is_ok()
        {
            let _ = fs::remove_file(&path);
        }
    }
}

fn is_temporary(path: &Path) -> bool {
    let (prefix, suffix) = affixes();
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let random = name.strip_prefix(&prefix).and_then(|rest| rest.strip_suffix(suffix));
    random.is_some_and(|r| r.len() == RANDOM && r.bytes().all(|b| b.is_ascii_alphanumeric()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Creates a file named like a temporary file.
    fn part(folder: &Path, random: &str) -> PathBuf {
        let (prefix, suffix) = affixes();
        let path = folder.join(format!("{prefix}{random}{suffix}"));
        fs::write(&path, "half a picture").unwrap();
        path
    }

    #[test]
    fn what_a_killed_writer_left_is_removed_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        let abandoned = part(at, "aB3xYz");
        let held = part(at, "held00");
        let writer = File::open(&held).unwrap();
        writer.lock().unwrap();
        let (prefix, suffix) = affixes();
        let strange = [
            format!(".dapple-another.host-aB3xYz{suffix}"),
            format!("{prefix}aB3xYz"),
            format!("{prefix}aB3xYzz{suffix}"),
            format!("{prefix}aB-xYz{suffix}"),
            "aB3xYz.part".into(),
        ];
        strange.iter().for_each(|name| fs::write(at.join(name), "").unwrap());
        let named = at.join(format!("{prefix}folder{suffix}"));
        fs::create_dir(&named).unwrap();
        #[cfg(unix)]
        let link = {
            fs::write(at.join("kept.txt"), "kept").unwrap();
            let link = at.join(format!("{prefix}links0{suffix}"));
            std::os::unix::fs::symlink(at.join("kept.txt"), &link).unwrap();
            link
        };
        probe(&at.join("a.exr")).unwrap();
        assert!(!abandoned.exists());
        assert!(held.exists() && named.is_dir() && strange.iter().all(|name| at.join(name).exists()));
        #[cfg(unix)]
        assert!(link.is_symlink() && at.join("kept.txt").exists());
        drop(writer);
        probe(&at.join("a.exr")).unwrap();
        assert!(!held.exists());
    }

    /// Concurrent writers and probes in one folder: no writer loses its file.
    #[test]
    fn writers_are_not_taken_for_dead() {
        let folder = tempfile::tempdir().unwrap();
        std::thread::scope(|scope| {
            for i in 0..4 {
                let path = folder.path().join(format!("{i}.txt"));
                scope.spawn(move || {
                    for n in 0..40 {
                        probe(&path).unwrap();
                        replace(&path, format!("{n}").as_bytes()).unwrap();
                    }
                });
            }
        });
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 4);
    }

    #[test]
    fn a_read_only_file_is_kept() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        fs::write(&path, "mine").unwrap();
        let mut permissions = path.metadata().unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&path, permissions).unwrap();
        for refused in [probe(&path), replace(&path, b"picture")] {
            assert!(refused.unwrap_err().to_string().contains("a.exr: cannot be written"));
        }
        assert_eq!(fs::read_to_string(&path).unwrap(), "mine");
        let beside = elsewhere(&path, |at: &Path| replace(at, b"picture")).unwrap();
        assert_eq!(beside, folder.path().join("a-1.exr"));
    }

    #[cfg(unix)]
    #[test]
    fn links_lead_to_their_targets_even_if_these_are_missing() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("sub")).unwrap();
        symlink("sub/second.png", at("first.png")).unwrap();
        symlink("new.png", at("sub/second.png")).unwrap();
        for bytes in [&b"one"[..], b"two"] {
            probe(&at("first.png")).unwrap();
            replace(&at("first.png"), bytes).unwrap();
            assert_eq!(fs::read(at("sub/new.png")).unwrap(), bytes);
            assert!(at("first.png").is_symlink() && at("sub/second.png").is_symlink());
        }
        symlink("gone/a.png", at("lost.png")).unwrap();
        assert!(matches!(replace(&at("lost.png"), b"three"), Err(ImageError::NoFolder { .. })));
        symlink("loop.png", at("loop.png")).unwrap();
        assert!(probe(&at("loop.png")).is_err() && replace(&at("loop.png"), b"four").is_err());
        assert!(at("lost.png").is_symlink() && at("loop.png").is_symlink());
    }

    #[test]
    fn a_picture_goes_beside_or_into_a_folder_of_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.b.exr");
        fs::write(folder.path().join("a.b-1.exr"), "not ours").unwrap();
        let write = |at: &Path| replace(at, b"picture");
        assert_eq!(elsewhere(&path, write).unwrap(), folder.path().join("a.b-2.exr"));
        assert_eq!(fs::read_to_string(folder.path().join("a.b-1.exr")).unwrap(), "not ours");
        let gone = folder.path().join("gone").join("a.exr");
        let at = elsewhere(&gone, write).unwrap();
        assert!(at.starts_with(std::env::temp_dir()) && at.ends_with("a.exr"), "{}", at.display());
        assert_eq!(fs::read_to_string(&at).unwrap(), "picture");
        // Another file of the same name gets a different name in the same folder.
        let second = elsewhere(&gone, write).unwrap();
        assert_eq!(second, at.with_file_name("a-1.exr"));
        fs::remove_dir_all(at.parent().unwrap()).unwrap();
        let full = |at: &Path| {
            Err(ImageError::Write { path: at.to_path_buf(), source: ErrorKind::StorageFull.into() })
        };
        assert!(matches!(elsewhere(&path, full), Err(ImageError::Write { .. })));
    }
}
