//! Prints the image of a point far behind the plane in focus, seen through a lens with five blades, in characters.
//! `cargo run --release --example aperture -p dapple-camera`

use dapple_camera::{Aperture, Camera, Lens, Projection};
use glam::{Vec2, Vec3};

fn main() {
    let aperture = Aperture::Blades { n: 5, rotation: 0.0 };
    let lens = Lens { radius: 0.1, aperture, focus_distance: 2.0 };
    let camera = Camera {
        origin: Vec3::ZERO,
        right: Vec3::X,
        up: Vec3::Y,
        backward: Vec3::Z,
        projection: Projection::Perspective { tan_half: 0.5 },
        lens: Some(lens),
        motion: None,
        aspect: None,
        clip: None,
    };
    let mut rows = vec![vec![b' '; 60]; 30];
    for i in 0..64 * 64 {
        let u = (Vec2::new((i % 64) as f32, (i / 64) as f32) + 0.5) / 64.0;
        let ray = camera.ray((0, 0), Vec2::splat(0.5), (1, 1), u);
        let p = ray.at(-6.0 / ray.d.z) / 0.5;
        let (x, y) = (30.0 + 28.0 * p.x, 15.0 - 14.0 * p.y);
        rows[y as usize][x as usize] = b'#';
    }
    rows.iter().for_each(|row| println!("{}", String::from_utf8_lossy(row)));
}
