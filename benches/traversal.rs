//! Benchmark of the traversal kernels: rays per second on procedural meshes, for primary, diffuse-bounce and shadow rays,
//! one by one and together, on one thread, in CPU time.
//!
//! `cargo bench --bench traversal` prints a table with ratios between kernels; `-- --quick` is the smoke run of CI;
//! `-- --dump DIR [FILE.glb …]` writes meshes and rays, including those of glTF files, and `-- --rays DIR` times the
//! fastest kernel on them, one pass for every line `MESH KIND` that it reads: `tools/embree_compare.py` uses both to
//! compare with Embree on the same rays, alternately.

use dapple_geometry::Rays;
use dapple_geometry::bvh::{Kernel, Opaque, Tree};
use dapple_geometry::surface::{geometric_normal, interpolate};
use dapple_integrator::Dimension;
use dapple_math::offset::offset_origin;
use dapple_math::{Frame, Ray};
use dapple_sampling::{Key, Pattern, point_2d, warp};
use dapple_scene::gltf;
use glam::{Vec2, Vec3};
use std::collections::HashMap;
use std::io::Write;
use std::path::{Path, PathBuf};

type Triangle = [Vec3; 3];

/// A mesh, a camera inside it, and a light above it.
struct Setup {
    name: String,
    triangles: Vec<Triangle>,
    eye: Vec3,
    at: Vec3,
    light: [Vec3; 3],
}

const KINDS: [&str; 3] = ["primary", "diffuse", "shadow"];

fn unit(key: Key, s: u32) -> Vec2 {
    point_2d(Pattern::Random, s, 1, key)
}

/// Unit icosphere by subdivision, with bumps.
fn lump(level: u32, seed: u64) -> Vec<Triangle> {
    let mut triangles: Vec<Triangle> = (0..8)
        .map(|i| {
            let s = |bit: u32| if i >> bit & 1 == 0 { 1.0 } else { -1.0 };
            let (x, y, z) = (Vec3::X * s(0), Vec3::Y * s(1), Vec3::Z * s(2));
            if s(0) * s(1) * s(2) > 0.0 { [x, y, z] } else { [y, x, z] }
        })
        .collect();
    for _ in 0..level {
        let split = |t: &Triangle| {
            let [a, b, c] = *t;
            let [ab, bc, ca] = [(a + b).normalize(), (b + c).normalize(), (c + a).normalize()];
            [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
        };
        triangles = triangles.iter().flat_map(split).collect();
    }
    let f = unit(Key::pixel(seed, 1, 1), 0) * 9.0 + 3.0;
    let bump = |p: Vec3| p * (1.0 + 0.15 * libm::sinf(p.x * f.x + p.z * 3.0) * libm::sinf(p.y * f.y));
    triangles.into_iter().map(|t| t.map(bump)).collect()
}

fn quad(a: Vec3, u: Vec3, v: Vec3) -> [Triangle; 2] {
    [[a, a + u, a + u + v], [a, a + u + v, a + v]]
}

/// A closed room of size 2·half with `n` lumps of the given subdivision level in it.
fn room(name: &str, half: Vec3, n: u32, level: u32, size: f32) -> Setup {
    let (lo, hi) = (-half, half);
    let d = hi - lo;
    let (x, y, z) = (Vec3::X * d.x, Vec3::Y * d.y, Vec3::Z * d.z);
    let mut triangles: Vec<Triangle> = [
        quad(lo, x, z),
        quad(hi, -x, -z),
        quad(lo, y, x),
        quad(hi, -y, -x),
        quad(lo, z, y),
        quad(hi, -z, -y),
    ]
    .concat();
    for i in 0..n {
        let key = Key::pixel(11, i, 0);
        let (a, b) = (unit(key, 0), unit(key, 1));
        let centre = lo + d * Vec3::new(a.x, b.x * b.x * 0.9, a.y);
        let scale = size * (0.3 + b.y);
        triangles.extend(lump(level, u64::from(i)).into_iter().map(|t| t.map(|p| centre + p * scale)));
    }
    let light = [
        Vec3::new(-half.x * 0.3, half.y * 0.98, -half.z * 0.3),
        Vec3::X * half.x * 0.6,
        Vec3::Z * half.z * 0.6,
    ];
    Setup {
        name: name.to_owned(),
        triangles,
        eye: half * Vec3::new(0.9, 0.3, 0.9),
        at: -half * Vec3::new(0.5, 0.3, 0.6),
        light,
    }
}

fn terrain(n: usize) -> Setup {
    let height = |i: usize, j: usize| {
        let (x, z) = (i as f32 / n as f32 * 20.0, j as f32 / n as f32 * 20.0);
        let y = libm::sinf(x) * libm::cosf(z * 1.3)
            + 0.4 * libm::sinf(3.1 * x + z)
            + 0.1 * libm::sinf(11.0 * x - 7.0 * z);
        Vec3::new(x - 10.0, y, z - 10.0)
    };
    let cells = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
    let triangles = cells
        .flat_map(|(i, j)| {
            let (a, b, c, d) = (height(i, j), height(i + 1, j), height(i + 1, j + 1), height(i, j + 1));
            [[a, c, b], [a, d, c]]
        })
        .collect();
    let light = [Vec3::new(-3.0, 9.0, -3.0), Vec3::X * 6.0, Vec3::Z * 6.0];
    Setup {
        name: "terrain".to_owned(),
        triangles,
        eye: Vec3::new(9.0, 5.0, 9.0),
        at: Vec3::new(-2.0, -1.0, -2.0),
        light,
    }
}

fn setups(quick: bool) -> Vec<Setup> {
    if quick {
        return vec![room("room", Vec3::new(4.0, 2.0, 4.0), 8, 2, 0.4)];
    }
    let small = Vec3::new(4.0, 2.0, 4.0);
    vec![
        room("box", small, 3, 0, 0.8),
        room("boxes", small, 14, 0, 0.6),
        room("crowd", small, 30, 0, 0.6),
        room("room", small, 30, 4, 0.4),
        terrain(180),
        room("interior", Vec3::new(12.0, 5.0, 12.0), 400, 4, 0.5),
    ]
}

/// All triangles of a glTF file, seen from outside, under a lamp as large as the scene.
fn file(path: &Path) -> std::io::Result<Setup> {
    let builder = gltf::read(path, &gltf::Options::default()).map_err(std::io::Error::other)?;
    let accel = builder.build().map_err(std::io::Error::other)?.accel;
    let mut triangles = Vec::new();
    for object in 0..accel.object_count() as u32 {
        let corners = (0..).map(|i| accel.corners(object, i));
        triangles.extend(corners.take_while(|c| *c != [Vec3::ZERO; 3]));
    }
    let (lo, hi) = accel.bounds().unwrap_or_default();
    let (at, size) = (0.5 * (lo + hi), (hi - lo).length());
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let corner = at + size * Vec3::new(-0.5, 1.0, -0.5);
    let light = [corner, Vec3::X * size, Vec3::Z * size];
    Ok(Setup { name, triangles, eye: at + size * Vec3::new(0.45, 0.25, 0.6), at, light })
}

/// Primary rays in 4×4 blocks, one cosine-distributed bounce from each hit, and rays from each hit to the light (t_max
/// = 1).
fn rays(setup: &Setup, tree: &Tree, side: u32) -> [Vec<Ray>; 3] {
    let view =
        Frame::from_z_tangent((setup.eye - setup.at).normalize(), Vec3::Y.cross(setup.eye - setup.at), 1.0);
    let (mut primary, mut diffuse, mut shadow) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..side * side {
        let block = i / 16;
        let (bx, by) = (block % (side / 4) * 4, block / (side / 4) * 4);
        let (x, y) = (bx + i % 4, by + i / 4 % 4);
        let film = (Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / side as f32 - 0.5) * 1.2;
        let ray = Ray::new(setup.eye, view.to_world(Vec3::new(film.x, -film.y, -1.0)).normalize());
        primary.push(ray);
        let Some(hit) = tree.intersect(&ray, &Opaque) else { continue };
        let corners = setup.triangles[hit.triangle as usize];
        let (p, error) = interpolate(&corners, hit.u, hit.v);
        let ng = geometric_normal(&corners);
        let facing = if ng.dot(ray.d) < 0.0 { ng } else { -ng };
        let key = Key::pixel(5, x, y).at(0, Dimension::Direction);
        let d = Frame::from_z(facing).to_world(warp::hemisphere_cosine(unit(key, 0)));
        diffuse.push(Ray::new(offset_origin(p, error, ng, d), d));
        let u = unit(key, 1);
        let target = setup.light[0] + setup.light[1] * u.x + setup.light[2] * u.y;
        let o = offset_origin(p, error, ng, target - p);
        shadow.push(Ray { o, d: target - o, t_max: 1.0 });
    }
    [primary, diffuse, shadow]
}

/// CPU time of this thread in nanoseconds.
#[cfg(unix)]
fn cpu_ns() -> i64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as i64 * 1_000_000_000 + time.tv_nsec as i64
}

/// Nanoseconds since the first call, where the CPU time of threads is not available.
#[cfg(not(unix))]
fn cpu_ns() -> i64 {
    static START: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    START.get_or_init(std::time::Instant::now).elapsed().as_nanos() as i64
}

/// Returns millions of rays per second in one pass, and the number of hits.
fn pass(tree: &Tree, rays: &[Ray], shadow: bool) -> (f64, usize) {
    let before = cpu_ns();
    let hits = if shadow {
        rays.iter().filter(|r| tree.occluded(r, &Opaque)).count()
    } else {
        rays.iter().filter(|r| tree.intersect(r, &Opaque).is_some()).count()
    };
    (rays.len() as f64 * 1e3 / (cpu_ns() - before).max(1) as f64, hits)
}

/// The number of rays in one query of many.
const TOGETHER: usize = 1024;

/// Rays in columns: origins, directions and ends.
type Columns = [Vec<f32>; 7];

fn columns(rays: &[Ray]) -> Columns {
    let numbers = |r: &Ray| [r.o.x, r.o.y, r.o.z, r.d.x, r.d.y, r.d.z, r.t_max];
    std::array::from_fn(|k| rays.iter().map(|r| numbers(r)[k]).collect())
}

/// As [`pass`], with many rays in one query.
fn pass_together(tree: &Tree, [x, y, z, dx, dy, dz, t_max]: &Columns, shadow: bool) -> (f64, usize) {
    let (before, mut hits) = (cpu_ns(), 0);
    for from in (0..x.len()).step_by(TOGETHER) {
        let ends = shadow.then_some(&t_max[from..]);
        let (o, d) = ([&x[from..], &y[from..], &z[from..]], [&dx[from..], &dy[from..], &dz[from..]]);
        let rays = Rays::new(TOGETHER, o, d, ends);
        if shadow {
            tree.occluded_each(&rays, |_, is_occluded| hits += usize::from(is_occluded));
        } else {
            tree.intersect_each(&rays, |_, hit| hits += usize::from(hit.is_some()));
        }
    }
    (x.len() as f64 * 1e3 / (cpu_ns() - before).max(1) as f64, hits)
}

/// Returns the median of three passes.
fn time(mut pass: impl FnMut() -> (f64, usize)) -> f64 {
    let mut passes = [0; 3].map(|_| pass().0);
    passes.sort_unstable_by(f64::total_cmp);
    passes[1]
}

fn floats(path: &Path, values: impl Iterator<Item = f32>) -> std::io::Result<()> {
    let mut file = std::io::BufWriter::new(std::fs::File::create(path)?);
    for value in values {
        file.write_all(&value.to_le_bytes())?;
    }
    file.flush()
}

fn dump(dir: &Path, files: &[String]) -> std::io::Result<()> {
    std::fs::create_dir_all(dir)?;
    let files = files.iter().map(|name| file(Path::new(name))).collect::<Result<Vec<_>, _>>()?;
    for setup in setups(false).into_iter().chain(files) {
        let tree = Tree::build(&setup.triangles);
        floats(
            &dir.join(format!("{}.tri", setup.name)),
            setup.triangles.iter().flatten().flat_map(|p| p.to_array()),
        )?;
        for (kind, rays) in KINDS.iter().zip(rays(&setup, &tree, 640)) {
            let numbers = rays.iter().flat_map(|r| [r.o.x, r.o.y, r.o.z, r.d.x, r.d.y, r.d.z, r.t_max]);
            floats(&dir.join(format!("{}.{kind}", setup.name)), numbers)?;
        }
    }
    Ok(())
}

fn load(path: PathBuf) -> std::io::Result<Vec<f32>> {
    let bytes = std::fs::read(path)?;
    Ok(bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
}

/// Loads a dumped mesh, and its rays by kind.
fn dumped(dir: &Path, name: &str) -> std::io::Result<(Tree, [Vec<Ray>; 3])> {
    let numbers = load(dir.join(format!("{name}.tri")))?;
    let triangles: Vec<Triangle> = numbers
        .chunks_exact(9)
        .map(|c| [Vec3::from_slice(c), Vec3::from_slice(&c[3..]), Vec3::from_slice(&c[6..])])
        .collect();
    let ray = |c: &[f32]| Ray { o: Vec3::from_slice(c), d: Vec3::from_slice(&c[3..]), t_max: c[6] };
    let mut rays = [const { Vec::new() }; 3];
    for (rays, kind) in rays.iter_mut().zip(KINDS) {
        *rays = load(dir.join(format!("{name}.{kind}")))?.chunks_exact(7).map(ray).collect();
    }
    Ok((Tree::build(&triangles), rays))
}

/// Runs one pass for every line `MESH KIND`; prints Mrays/s and the number of hits.
fn time_dumped(dir: &Path) -> std::io::Result<()> {
    let mut meshes = HashMap::new();
    for line in std::io::stdin().lines() {
        let line = line?;
        let (name, kind) = line.rsplit_once(' ').unwrap_or((&line, KINDS[0]));
        if !meshes.contains_key(name) {
            meshes.insert(name.to_owned(), dumped(dir, name)?);
        }
        let (tree, rays) = &meshes[name];
        let k = KINDS.iter().position(|k| *k == kind).unwrap_or_default();
        let (mrays, hits) = pass(tree, &rays[k], kind == "shadow");
        println!("{mrays} {hits}");
    }
    Ok(())
}

fn table(quick: bool) {
    let kernels = Kernel::available();
    println!("Mrays/s on one thread; in brackets the ratio to {}, one by one", kernels[0].name());
    for setup in setups(quick) {
        let start = std::time::Instant::now();
        let tree = Tree::build(&setup.triangles);
        let build = start.elapsed().as_secs_f64();
        let bytes = tree.memory_bytes() as f64 / setup.triangles.len() as f64;
        println!(
            "{}: {} triangles, built in {build:.3} s, {bytes:.0} bytes per triangle",
            setup.name,
            setup.triangles.len()
        );
        let rays = rays(&setup, &tree, if quick { 64 } else { 512 });
        let mut tree = tree;
        let columns = rays.each_ref().map(|rays| columns(rays));
        let mut base = [0.0; 3];
        for (i, &kernel) in kernels.iter().enumerate() {
            tree = tree.with_kernel(kernel);
            for together in [false, true] {
                let cells = [0, 1, 2].map(|k| {
                    let mrays = if together {
                        time(|| pass_together(&tree, &columns[k], k == 2))
                    } else {
                        time(|| pass(&tree, &rays[k], k == 2))
                    };
                    if i == 0 && !together {
                        base[k] = mrays;
                    }
                    format!("{} {mrays:6.2} ({:.2})", KINDS[k], mrays / base[k])
                });
                let name = if together { "together" } else { kernel.name() };
                println!("  {name:9} {}", cells.join("   "));
            }
        }
    }
}

fn main() -> std::io::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let folder = || PathBuf::from(arguments.get(1).map_or("rays", String::as_str));
    match arguments.first().map(String::as_str) {
        Some("--dump") => dump(&folder(), arguments.get(2..).unwrap_or(&[])),
        Some("--rays") => time_dumped(&folder()),
        Some("--quick") => {
            table(true);
            Ok(())
        }
        _ => {
            table(false);
            Ok(())
        }
    }
}
