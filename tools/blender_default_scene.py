#!/usr/bin/env python3
"""Exports Blender's default scene, renders it with Cycles and with dapple, and compares the faces of the cube.

This is a development tool. It needs the Python packages bpy (Blender as a module), numpy and OpenEXR.

    python3 tools/blender_default_scene.py target/release/dapple FOLDER

The world is black, and the lamp and the camera are those of the start-up file. No exposure is applied: the compared
images are linear EXR files. The exporter writes candela, which dapple divides by 683 lm/W because the file names its
generator.
"""
import math
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import OpenEXR

SIZE = (480, 270)
SAMPLES = 256
# The number of bounces has no effect, because the cube is convex and the only object.
NORMALS = "x y z".split()


def start_up_scene():
    bpy.ops.wm.read_factory_settings()
    scene = bpy.context.scene
    for node in scene.world.node_tree.nodes:
        if node.type == "BACKGROUND":
            node.inputs["Strength"].default_value = 0.0
    return scene


def by_cycles(scene, path):
    scene.render.engine = "CYCLES"
    scene.cycles.samples = SAMPLES
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.cycles.pixel_filter_type = "BOX"
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def green(path):
    channels = OpenEXR.File(str(path)).channels()
    for name in ("RGB", "RGBA"):
        if name in channels:
            return channels[name].pixels[..., 1].astype(float)
    return next(c.pixels for name, c in channels.items() if name.split(".")[-1] == "G").astype(float)


def faces(scene):
    """Returns the face of the cube from -1 to 1 that covers each pixel: 0, 1 or 2 for the one perpendicular to x, y or
    z, or -1 if no face covers the whole pixel."""
    camera = scene.camera
    turn = np.array(camera.matrix_world.to_3x3())
    origin = np.array(camera.matrix_world.translation)
    half = math.tan(camera.data.angle_x / 2)
    seen = []
    for dx, dy in [(x, y) for x in (0.02, 0.5, 0.98) for y in (0.02, 0.5, 0.98)]:
        x = ((np.arange(SIZE[0]) + dx) / SIZE[0] * 2 - 1) * half
        y = (1 - (np.arange(SIZE[1]) + dy) / SIZE[1] * 2) * half * SIZE[1] / SIZE[0]
        x, y = np.meshgrid(x, y)
        direction = np.stack([x, y, -np.ones_like(x)], -1) @ turn.T
        ends = np.stack([(-1 - origin) / direction, (1 - origin) / direction])
        near, far = ends.min(0), ends.max(0)
        seen.append(np.where(near.max(-1) < far.min(-1), near.argmax(-1), -1))
    seen = np.stack(seen)
    return np.where((seen == seen[0]).all(0), seen[0], -1)


def main(dapple, folder):
    folder.mkdir(parents=True, exist_ok=True)
    scene = start_up_scene()
    model, theirs, ours = (folder / name for name in ("default.glb", "cycles.exr", "dapple.exr"))
    bpy.ops.export_scene.gltf(filepath=str(model), export_lights=True, export_cameras=True)
    by_cycles(scene, theirs)
    size = f"{SIZE[0]}x{SIZE[1]}"
    subprocess.run([dapple, "render", model, "--env", "none", "--size", size, "--spp", str(SAMPLES), "-o", ours], check=True)
    which, a, b = faces(scene), green(theirs), green(ours)
    rows = [("cube", which >= 0)] + [(f"face normal {n}", which == i) for i, n in enumerate(NORMALS)]
    for name, mask in rows:
        x, y = a[mask].mean(), b[mask].mean()
        ratio = f"{y / x:.4f}" if x > 0 else "-"
        print(f"{name:14} Cycles {x:.5f}  dapple {y:.5f}  ratio {ratio}  ({mask.sum()} pixels)")


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
