//! A failed output does not lose the others, and gives a separate exit code.
#![cfg(unix)]

mod dapple;

use dapple::{files, run, triangle, well};
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

fn dapple(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_dapple"));
    command.current_dir(folder).env_remove("RUST_LOG").env("TMPDIR", folder.join("tmp"));
    fs::create_dir_all(folder.join("tmp")).unwrap();
    command
}

const RENDER: [&str; 6] = ["render", "builtin:cornell", "--size", "16x12", "--exposure", "0"];

/// The folder of one output disappears during the render.
#[test]
fn what_cannot_be_written_is_saved_elsewhere() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::create_dir(at.join("sub")).unwrap();
    let mut child = dapple(at)
        .args(RENDER)
        .args(["--time-limit", "2s", "--json", "--log", "log.jsonl"])
        .args(["-o", "sub/a.exr", "-o", "b.hdr", "-o", "sub/c.hdr"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Rendering has begun once the log has content.
    while !fs::read(at.join("log.jsonl")).is_ok_and(|log| !log.is_empty()) {
        assert!(child.try_wait().unwrap().is_none(), "the process ended before rendering began");
        std::thread::sleep(Duration::from_millis(5));
    }
    fs::remove_dir_all(at.join("sub")).unwrap();
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(4), "{said}");
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["not_written"], serde_json::json!(["sub/a.exr", "sub/c.hdr"]));
    assert_eq!(json["outputs"].as_array().unwrap().len(), 3);
    for path in json["outputs"].as_array().unwrap().iter().map(|path| path.as_str().unwrap()) {
        assert!(at.join(path).is_file(), "{path}");
        assert!(
            path == "b.hdr" || (path.starts_with(at.join("tmp").to_str().unwrap()) && said.contains(path))
        );
    }
    assert!(said.contains("sub/a.exr") && said.contains("sub/c.hdr"), "{said}");
}

/// With a file size limit, the large image is lost and reported as lost; the small one is written.
#[test]
fn what_is_lost_is_told_and_the_rest_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let script = format!(
        "ulimit -f 32; exec '{}' render builtin:cornell --size 64x64 --spp 1 --quiet -o a.exr -o b.png -o c.exr --aov beauty,variance,albedo",
        env!("CARGO_BIN_EXE_dapple")
    );
    let mut command = Command::new("sh");
    fs::create_dir(folder.path().join("tmp")).unwrap();
    command.args(["-c", &script]).current_dir(folder.path()).env("TMPDIR", folder.path().join("tmp"));
    let output = command.output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), output.stdout), (Some(4), b"b.png\n".to_vec()), "{said}");
    assert!(said.contains("a.exr") && said.contains("c.exr") && said.contains("lost"), "{said}");
    assert!(!said.contains(".dapple-") && !said.contains(".part"), "{said}");
    assert_eq!(
        (files(folder.path()), files(&folder.path().join("tmp"))),
        (vec!["b.png".into(), "tmp".into()], vec![])
    );
}

/// An existing file without write permission is refused before rendering, as an output in such a folder is.
#[test]
fn a_read_only_output_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let path = at.join("a.png");
    fs::write(&path, "mine").unwrap();
    let mut permissions = path.metadata().unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&path, permissions).unwrap();
    let refused = run(at, &[&RENDER[..], &["--spp", "1", "-o", "b.hdr", "-o", "a.png"]].concat());
    assert!(refused.code == 2 && refused.err.contains("a.png: cannot be written"), "{}", refused.err);
    assert_eq!((files(at), fs::read(&path).unwrap()), (vec!["a.png".into()], b"mine".to_vec()));
}

/// A link is followed whether its target exists or not.
#[test]
fn a_dangling_link_is_followed() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::os::unix::fs::symlink("new.hdr", at.join("link.hdr")).unwrap();
    for _ in 0..2 {
        well(at, &[&RENDER[..], &["--spp", "1", "-o", "link.hdr"]].concat());
        assert!(at.join("link.hdr").is_symlink() && !at.join("new.hdr").is_symlink());
        assert!(at.join("new.hdr").is_file());
    }
}

#[test]
fn an_output_has_one_path() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::os::unix::fs::symlink(".", at.join("self")).unwrap();
    std::os::unix::fs::symlink("a.hdr", at.join("link.hdr")).unwrap();
    for again in ["a.hdr", "./a.hdr", "self/a.hdr", "link.hdr", "self/link.hdr"] {
        let refused = run(at, &[&RENDER[..], &["--spp", "1", "-o", "a.hdr", "-o", again]].concat());
        assert!(
            refused.code == 2 && refused.err.contains("same file as the output a.hdr"),
            "{}",
            refused.err
        );
        assert_eq!(files(at), ["link.hdr", "self"]);
    }
    well(at, &[&RENDER[..], &["--spp", "1", "-o", "a.hdr", "-o", "self/b.hdr"]].concat());
}

#[test]
fn a_log_that_takes_nothing_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let run = |log: &str| {
        let output = dapple(folder.path())
            .args(RENDER)
            .args(["--spp", "2", "--log", log, "-o", "a.hdr"])
            .output()
            .unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let (code, said) = run("missing/log.jsonl");
    assert!(code == Some(2) && said.contains("missing/log.jsonl") && !folder.path().join("a.hdr").exists());
    if Path::new("/dev/full").exists() {
        let (code, said) = run("/dev/full");
        assert!(code == Some(4) && said.contains("--log /dev/full"), "{code:?}: {said}");
        assert!(folder.path().join("a.hdr").exists());
    }
}

/// Commands that print results of any kind.
fn commands_that_print<'a>(render: &'a [&'a str]) -> Vec<&'a [&'a str]> {
    let mut all: Vec<&[&str]> = vec![render, &["plan", "builtin:cornell"], &["--help"], &["--version"], &[]];
    all.extend([&["info", "builtin:cornell"][..], &["info", "builtin:cornell", "--json"]]);
    all.extend([&["rays", "builtin:cornell"][..], &["render", "-h"], &["help", "info"]]);
    if cfg!(feature = "manual") {
        all.extend([&["completions", "bash"][..], &["man"], &["man", "render"]]);
    }
    if cfg!(feature = "report") {
        let budget =
            &["budget", "builtin:cornell", "--error-limit", "0.5", "--size", "4x4", "--time-limit", "1ms"];
        all.push(budget);
    }
    all
}

/// A process may be started without a standard output, by `>&-`.
#[cfg(any(target_os = "linux", target_os = "macos"))]
#[test]
fn a_standard_output_that_is_not_there_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let small = [&RENDER[..], &["--spp", "1", "--quiet", "-o", "a.hdr"]].concat();
    for arguments in commands_that_print(&small) {
        let run = |out: &str| {
            let mut shell = Command::new("sh");
            let script = format!("exec \"$@\" {out}");
            shell.args(["-c", &script, "sh", env!("CARGO_BIN_EXE_dapple")]).args(arguments);
            let output = shell.current_dir(folder.path()).output().unwrap();
            (output.status.code(), String::from_utf8(output.stderr).unwrap())
        };
        let (code, said) = run(">&-");
        assert_eq!(code, Some(4), "{arguments:?}: {said}");
        assert_eq!(said.matches("error: standard output").count(), 1, "{arguments:?}: {said}");
        // Output is discarded deliberately; the descriptor may be open for reading as well.
        for nobody in [">/dev/null", "1<>/dev/null", "2>&- >/dev/null", "<&- >/dev/null"] {
            assert_eq!(run(nobody).0, Some(0), "{arguments:?} {nobody}");
        }
    }
    assert!(folder.path().join("a.hdr").is_file());
}

/// A full or closed standard output is an error of its own; the image is written nevertheless.
#[test]
fn standard_output_that_takes_nothing_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let small = [&RENDER[..], &["--spp", "1", "--quiet", "-o", "a.hdr"]].concat();
    for arguments in commands_that_print(&small) {
        for full in [true, false] {
            if full && !Path::new("/dev/full").exists() {
                continue;
            }
            let out: Stdio = match full {
                true => File::options().write(true).open("/dev/full").unwrap().into(),
                // The reading end is closed before anything is written.
                false => std::io::pipe().unwrap().1.into(),
            };
            let mut command = dapple(folder.path());
            let mut child = command.args(arguments).stdout(out).stderr(Stdio::piped()).spawn().unwrap();
            let mut said = String::new();
            child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
            assert_eq!(child.wait().unwrap().code(), Some(4), "{arguments:?}: {said}");
            assert_eq!(said.matches("standard output").count(), 1, "{arguments:?}: {said}");
        }
    }
    assert!(folder.path().join("a.hdr").is_file());
}

/// A render that is killed while writing leaves a partial file; the next render removes it.
#[test]
fn the_next_run_tidies_up() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let host = File::open("/proc/sys/kernel/hostname").map(|mut file| {
        let mut name = String::new();
        file.read_to_string(&mut name).map(|_| name.trim().to_string())
    });
    let Ok(Ok(host)) = host else { return };
    let host: String =
        host.chars().take(64).map(|c| if c.is_ascii_alphanumeric() || c == '.' { c } else { '_' }).collect();
    let [part, other] =
        [format!(".dapple-{host}-AbCd12.part"), ".dapple-elsewhere.example-AbCd12.part".into()];
    for name in [&part, &other] {
        fs::write(at.join(name), "half").unwrap();
    }
    well(at, &[&RENDER[..], &["--spp", "1", "-o", "a.hdr"]].concat());
    assert_eq!(files(at), [other.as_str(), "a.hdr"]);
}

/// A folder of another user may contain links under the default names of a render.
#[test]
#[cfg(unix)]
fn links_are_followed_only_where_they_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::create_dir(at.join("package")).unwrap();
    fs::write(at.join("keys"), "mine").unwrap();
    fs::write(at.join("package/q.gltf"), triangle(|_, _| ())).unwrap();
    let inside = at.join("package");
    for (link, command) in [
        ("q.png", &["render", "q.gltf"][..]),
        ("q.exr", &["render", "q.gltf"]),
        ("sheet.png", &["sheet", "q.gltf", "--vary", "pixel", "--counts", "1"]),
    ] {
        std::os::unix::fs::symlink("../keys", inside.join(link)).unwrap();
        let small = ["--size", "8x8", "--env-color", "1,1,1"];
        let found = run(&inside, &[command, &small].concat());
        assert!(
            found.code == 2 && found.err.contains(link) && found.err.contains("symbolic link"),
            "{}",
            found.err
        );
        assert_eq!(fs::read_to_string(at.join("keys")).unwrap(), "mine");
        fs::remove_file(inside.join(link)).unwrap();
    }
    std::os::unix::fs::symlink("../mine.png", inside.join("named.png")).unwrap();
    fs::write(at.join("mine.png"), "old").unwrap();
    well(&inside, &["render", "q.gltf", "--size", "8x8", "--spp", "1", "-o", "named.png"]);
    assert_ne!(fs::read(at.join("mine.png")).unwrap(), b"old");
}
