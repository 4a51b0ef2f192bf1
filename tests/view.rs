//! Camera placement: cameras given by options, automatic framing, and all commands that take a view.

mod dapple;

use dapple::{files, run, triangle, well};
use dapple_imaging::{Image, read, write};
use std::fs;
use std::path::Path;

/// A folder with a single-sided triangle about the origin, seen by a camera at z = 4.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("t.gltf"), triangle(|_, _| ())).unwrap();
    folder
}

/// Returns the object ids of a render of 32 × 16 pixels, unless another size is requested.
fn objects(folder: &Path, more: &[&str]) -> Vec<f32> {
    let size: &[&str] = if more.contains(&"--size") { &[] } else { &["--size", "32x16"] };
    let fixed = ["render", "t.gltf", "--spp", "1", "--pattern", "grid", "--aov", "object", "-o", "o.exr"];
    well(folder, &[&fixed[..], size, more].concat());
    let layers = read::layers(&folder.join("o.exr")).unwrap();
    layers.layers.iter().find(|l| l.name == "object").unwrap().channels[0].1.clone()
}

fn picture(folder: &Path, more: &[&str]) -> Image {
    well(folder, &[&["render", "t.gltf", "--spp", "4", "-o", "p.exr"], more].concat());
    read::picture(&folder.join("p.exr")).unwrap()
}

fn seen(objects: &[f32]) -> usize {
    objects.iter().filter(|id| **id > 0.0).count()
}

#[test]
fn a_view_of_one_s_own_is_a_camera_in_that_place() {
    let folder = folder();
    let file = objects(folder.path(), &[]);
    assert!(seen(&file) > 20 && seen(&file) < 200, "{}", seen(&file));
    let fov = format!("{}", 0.8f64.to_degrees());
    for own in [
        &["--look-from", "0,0,4", "--look-at", "0,0,0", "--fov", &fov][..],
        &["--look-from", "0,0,4", "--fov", &fov, "--up", "0,2,0"],
        &["--orbit", "0,0,4", "--fov", &fov],
        &["--orbit=360,0,4", "--look-at=0,0,0", "--fov", &fov],
        &["--camera", "eye", "--look-at", "0,0,0"],
        &["--camera", "0", "--fov", &fov],
        &["--up", "0,1,0"],
    ] {
        assert_eq!(objects(folder.path(), own), file, "{own:?}");
    }
    let mut upside_down = objects(folder.path(), &["--up", "0,-1,0"]);
    upside_down.reverse();
    assert_eq!(upside_down, file);
    assert!(seen(&objects(folder.path(), &["--fov", "20"])) > 2 * seen(&file));
}

#[test]
fn an_orbit_shows_everything_and_backs_as_asked() {
    let folder = folder();
    let all = |yaw: &str, more: &[&str]| seen(&objects(folder.path(), &[&["--orbit", yaw], more].concat()));
    let front = all("0,0", &[]);
    assert!(front > 30, "{front}");
    for (size, width) in [("32x16", 32), ("32x64", 32), ("16x32", 16)] {
        let shown = objects(folder.path(), &["--orbit", "20,-30", "--size", size]);
        let (rows, last) = (shown.chunks(width), shown.len() / width - 1);
        for (y, row) in rows.enumerate() {
            let edge = if y == 0 || y == last { row.to_vec() } else { vec![row[0], row[width - 1]] };
            assert_eq!(seen(&edge), 0, "{size}: row {y}");
        }
        assert!(seen(&shown) > 10, "{size}");
    }
    assert_eq!(all("180,0", &[]), 0, "only the back face, which is not shown");
    assert_eq!(all("180,0", &["--backfaces", "culled"]), 0);
    assert_eq!(all("180,0", &["--cull-backfaces"]), 0);
    assert_eq!(all("180,0", &["--backfaces", "shown"]), front);
    assert_eq!(all("180,0", &["--cull-backfaces=false"]), front);
}

/// The triangle spans 0.3 of the frame, which is twice as wide as high, at every size.
#[test]
fn sizes_show_the_whole_frame_and_more() {
    let folder = folder();
    for (width, height) in [(64, 32), (32, 32), (16, 64), (128, 16)] {
        let objects = objects(folder.path(), &["--size", &format!("{width}x{height}")]);
        let base = (0..width).filter(|x| (0..height).any(|y| objects[y * width + x] > 0.0)).count();
        // Half its width over half the frame's: 1/(4·2·tan 0.4), or less for a wider image.
        let frame = 1.0 / (8.0 * 0.4f64.tan());
        let expected = frame * (width as f64).min(2.0 * height as f64);
        assert!((base as f64 - expected).abs() <= 2.0, "{width}x{height}: {base}, not {expected}");
    }
}

#[test]
fn every_command_has_the_view() {
    let folder = folder();
    let behind = ["--orbit", "180,0", "--size", "8x8", "--env-color", "1,1,1"];
    let replay = |more: &[&str]| {
        well(
            folder.path(),
            &[&["replay", "t.gltf", "--pixel", "4,4", "--sample", "0"], &behind[..], more].concat(),
        )
        .out
    };
    assert!(!replay(&[]).contains("triangle") && replay(&["--backfaces", "shown"]).contains("triangle"));
    for command in ["plan", "rays"] {
        well(folder.path(), &[&[command, "t.gltf"], &behind[..]].concat());
        let refused = run(folder.path(), &[command, "t.gltf", "--look-from", "0,0,0", "--look-at", "0,0,0"]);
        assert_eq!(refused.code, 2, "{command}: {}", refused.err);
    }
    // Without bounces a visible triangle is black.
    let sheet =
        ["sheet", "t.gltf", "--vary", "pixel", "--counts", "1", "--estimators", "grid", "--max-bounces", "0"];
    let page = |name: &str, more: &[&str]| {
        well(folder.path(), &[&sheet[..], &["-o", name], &behind[..], more].concat());
        fs::read(folder.path().join(name)).unwrap()
    };
    assert!(page("a.png", &[]) != page("b.png", &["--backfaces", "shown"]));
}

#[test]
fn wrong_views_are_refused_in_one_line() {
    let folder = folder();
    for (wrong, said) in [
        (&["--look-from", "1,2"][..], "X,Y,Z"),
        (&["--look-from", "0,0,1", "--look-at", "0,0,1"], "--look-from"),
        (&["--look-from", "0,0,1", "--orbit", "1,2"], "--orbit"),
        (&["--look-from", "0,0,1", "--camera", "eye"], "--camera"),
        (&["--orbit", "0,100"], "pitch"),
        (&["--orbit", "0,0,-1"], "distance"),
        (&["--up", "0,0,0"], "direction"),
        (&["--fov", "180"], "180"),
        (&["--backfaces", "none"], "camera, shown or culled"),
        (&["--backfaces", "shown", "--cull-backfaces"], "--backfaces"),
        (&["--env-nearest", "--env-smooth"], "--env-smooth"),
        (&["--look-from", "1e300,0,0"], "--look-from"),
    ] {
        let refused = run(folder.path(), &[&["render", "t.gltf", "--size", "4x4"], wrong].concat());
        assert_eq!(refused.code, 2, "{wrong:?}: {}", refused.err);
        assert!(refused.err.contains(said), "{wrong:?}: {}", refused.err);
    }
    assert_eq!(files(folder.path()), ["t.gltf"]);
    let parallel = triangle(|root, _| {
        root["cameras"] = serde_json::json!([{
            "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 1, "znear": 0, "zfar": 9 }
        }]);
    });
    fs::write(folder.path().join("o.gltf"), parallel).unwrap();
    let refused = run(folder.path(), &["render", "o.gltf", "--fov", "20"]);
    assert!(refused.code == 2 && refused.err.contains("--orbit"), "{}", refused.err);
}

/// View options of a sidecar are replaced as a whole by those on the command line.
#[test]
fn settings_files_place_cameras_too() {
    let folder = folder();
    let file = objects(folder.path(), &[]);
    let side = "orbit = [180, 0, 4]\nfov = 10\nup = '1,0,0'\nbackfaces = 'shown'\nenv-nearest = true\n";
    fs::write(folder.path().join("t.toml"), side).unwrap();
    assert!(objects(folder.path(), &[]) != file);
    assert_eq!(objects(folder.path(), &["--camera", "eye"]), file);
    assert_eq!(objects(folder.path(), &["--orbit", "0,0,4", "--fov", "45.83662361046586"]), file);
    fs::write(folder.path().join("t.toml"), "env-smooth = true\ncull-backfaces = true\n").unwrap();
    assert_eq!(objects(folder.path(), &["--backfaces", "shown", "--env-nearest"]), file);
}

/// A sky of two texels: interpolated, it has no edge; with nearest texels it does.
#[test]
fn environment_pictures_are_interpolated_unless_told() {
    let folder = folder();
    let pixels = (0..8).map(|i| glam::Vec3::splat(if i % 4 < 2 { 0.0 } else { 1.0 })).collect();
    write::hdr(&folder.path().join("sky.hdr"), &Image { width: 4, height: 2, pixels }).unwrap();
    let edges = |more: &[&str]| {
        let shown = [
            "--env",
            "sky.hdr",
            "--look-from",
            "0,0,9",
            "--look-at",
            "0,0,10",
            "--size",
            "64x32",
            "--fov",
            "60",
        ];
        let row = picture(folder.path(), &[&shown[..], more].concat());
        let steps = row.pixels[16 * 64..17 * 64].windows(2).map(|p| (p[0].x - p[1].x).abs());
        steps.fold(0.0, f32::max)
    };
    for smooth in [&[][..], &["--env-smooth"], &["--env-nearest=false"]] {
        assert!(edges(smooth) < 0.2, "{smooth:?}: {}", edges(smooth));
    }
    for nearest in [&["--env-nearest"][..], &["--env-smooth=false"]] {
        assert!(edges(nearest) > 0.9, "{nearest:?}: {}", edges(nearest));
    }
}
