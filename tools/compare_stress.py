#!/usr/bin/env python3
"""Renders cases of `dapple stress`, whose exact values are known, with Mitsuba 3 and Cycles.

    python3 -m pip install --target PACKAGES mitsuba bpy      # as published in the Python package index
    PYTHONPATH=PACKAGES python3 tools/compare_stress.py [path to dapple]

Prints a table as Markdown. Renderers that are not installed are skipped. The tool is not needed to build or test
dapple.
"""

import json
import math
import os
import subprocess
import sys
import tempfile

SPP = 256


def mean(values):
    values = list(values)
    return sum(values) / len(values)


def error(values):
    """Returns the mean and its standard error."""
    m = mean(values)
    var = sum((v - m) ** 2 for v in values) / (len(values) - 1)
    return m, math.sqrt(var / len(values))


class Mitsuba:
    """Renders the cases with Mitsuba. Every case returns the values of the pixels of its image."""

    name = "Mitsuba 3"

    def __init__(self):
        import mitsuba as mi
        import numpy as np

        mi.set_variant("scalar_rgb")
        self.mi, self.np = mi, np
        self.version = mi.__version__

    def render(self, scene, eye, at, fov, side=16, spp=SPP, depth=60, rr=1000, up=(0, 0.96, 0.28), seed=0):
        mi, np = self.mi, self.np
        film = {"type": "hdrfilm", "width": side, "height": side, "rfilter": {"type": "box"}}
        distance = math.dist(eye, at)
        sensor = {
            "type": "perspective",
            "fov": fov,
            "near_clip": distance * 1e-3,
            "far_clip": distance * 1e3,
            "to_world": mi.ScalarTransform4f().look_at(list(eye), list(at), list(up)),
            "film": film,
            "sampler": {"type": "independent", "sample_count": spp},
        }
        integrator = {"type": "path", "max_depth": depth, "rr_depth": rr}
        loaded = mi.load_dict({"type": "scene", "integrator": integrator, "sensor": sensor, **scene})
        image = np.array(mi.render(loaded, spp=spp, seed=seed))
        return [float(v) for v in image[:, :, 0].ravel()]

    def diffuse(self, albedo):
        return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": albedo}}}

    def furnace(self, scale=1.0, shift=0.0, albedo=0.5, shape="cube", **how):
        t = self.mi.ScalarTransform4f()
        place = t.translate([shift] * 3) @ t.scale(scale)
        wall = {
            "type": shape,
            "to_world": place,
            "flip_normals": True,
            "bsdf": self.diffuse(albedo),
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 1.0}},
        }
        eye = [shift + scale * x for x in (0.3125, -0.21875, 0.40625)]
        at = [shift + scale * x for x in (-0.3125, 0.09375, -0.28125)]
        return self.render({"wall": wall}, eye, at, 90, **how)

    def flat(self, depth):
        t = self.mi.ScalarTransform4f()
        scene = {
            "body": {"type": "cube", "to_world": t.scale([1, 1, depth]), "bsdf": self.diffuse(0.5)},
            "sky": {"type": "constant", "radiance": {"type": "rgb", "value": 1.0}},
        }
        return self.render(scene, (0, 0, 5), (0, 0, 0), 10)

    def tiny_sphere(self, radius):
        t = self.mi.ScalarTransform4f()
        radiance = {"type": "rgb", "value": 1 / radius**2}
        scene = {
            "floor": {"type": "rectangle", "to_world": t.scale(0.1), "bsdf": self.diffuse(1.0)},
            "light": {
                "type": "sphere",
                "center": [0, 0, 1],
                "radius": radius,
                "emitter": {"type": "area", "radiance": radiance},
            },
        }
        return self.render(scene, (0.3, 0.2, 0.8), (0, 0, 0), 0.01, depth=2)

    def texel(self, value):
        np, mi = self.np, self.mi
        sky = np.full((16, 32, 3), 0.5, dtype=np.float32)
        sky[5, 9, 1] = value
        t = mi.ScalarTransform4f()
        scene = {
            "floor": {"type": "rectangle", "to_world": t.scale(0.1), "bsdf": self.diffuse(0.5)},
            "sky": {"type": "envmap", "bitmap": mi.Bitmap(sky)},
        }
        return self.render(scene, (0.3, 0.2, 0.8), (0, 0, 0), 0.01, depth=2)

    def directions(self):
        mi = self.mi
        sensor = mi.load_dict(
            {
                "type": "perspective",
                "fov": 0.001,
                "film": {"type": "hdrfilm", "width": 1000, "height": 1000},
                "to_world": mi.ScalarTransform4f().look_at([3, 2, 5], [-1, 0.4, 0.2], [0, 1, 0]),
            }
        )
        rays = [sensor.sample_ray(0, 0, [(x + 0.5) / 1000, 0.5], [0.5, 0.5])[0].d for x in range(1000)]
        return len({(float(d[0]), float(d[1]), float(d[2])) for d in rays})


class Cycles:
    name = "Cycles"

    def __init__(self):
        import bpy

        self.bpy = bpy
        self.version = bpy.app.version_string

    def begin(self, side=16, spp=SPP, depth=60):
        bpy = self.bpy
        bpy.ops.wm.read_factory_settings(use_empty=True)
        scene = bpy.context.scene
        scene.render.engine = "CYCLES"
        scene.render.resolution_x = scene.render.resolution_y = side
        scene.render.resolution_percentage = 100
        c = scene.cycles
        c.device, c.samples, c.use_adaptive_sampling, c.use_denoising = "CPU", spp, False, False
        c.max_bounces = c.diffuse_bounces = c.glossy_bounces = depth
        c.sample_clamp_indirect = c.sample_clamp_direct = 0
        c.pixel_filter_type = "BOX"
        c.min_light_bounces = depth
        scene.render.image_settings.file_format = "OPEN_EXR"
        scene.render.image_settings.color_depth = "32"
        world = bpy.data.worlds.new("w")
        scene.world = world
        world.use_nodes = True
        world.node_tree.nodes["Background"].inputs[1].default_value = 0.0
        return scene

    def material(self, albedo, emission=0.0):
        m = self.bpy.data.materials.new("m")
        m.use_nodes = True
        tree = m.node_tree
        tree.nodes.clear()
        out, add = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new("ShaderNodeAddShader")
        diffuse, glow = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeEmission")
        diffuse.inputs[0].default_value = (albedo, albedo, albedo, 1)
        glow.inputs[1].default_value = emission
        tree.links.new(diffuse.outputs[0], add.inputs[0])
        tree.links.new(glow.outputs[0], add.inputs[1])
        tree.links.new(add.outputs[0], out.inputs[0])
        return m

    def render(self, scene, eye, at, fov):
        from mathutils import Vector

        bpy = self.bpy
        data = bpy.data.cameras.new("c")
        camera = bpy.data.objects.new("c", data)
        scene.collection.objects.link(camera)
        camera.location = eye
        camera.rotation_euler = (Vector(at) - Vector(eye)).to_track_quat("-Z", "Y").to_euler()
        data.angle = math.radians(fov)
        distance = math.dist(eye, at)
        data.clip_start, data.clip_end = distance * 1e-3, distance * 1e3
        scene.camera = camera
        with tempfile.TemporaryDirectory() as folder:
            scene.render.filepath = os.path.join(folder, "a.exr")
            quiet, saved = os.open(os.devnull, os.O_WRONLY), os.dup(1)
            os.dup2(quiet, 1)
            try:
                bpy.ops.render.render(write_still=True)
            finally:
                os.dup2(saved, 1)
            image = bpy.data.images.load(scene.render.filepath)
            image.colorspace_settings.name = "Non-Color"
            return list(image.pixels)[0::4]

    def add(self, scene, primitive, material, **how):
        getattr(self.bpy.ops.mesh, primitive)(**how)
        body = self.bpy.context.object
        body.data.materials.append(material)
        return body

    def furnace(self, scale=1.0, shift=0.0, albedo=0.5, shape="cube", **how):
        scene = self.begin(**{k: v for k, v in how.items() if k in ("side", "spp", "depth")})
        body = self.add(scene, "primitive_cube_add", self.material(albedo, 1.0), size=2)
        body.scale, body.location = [scale] * 3, [shift] * 3
        eye = [shift + scale * x for x in (0.3125, -0.21875, 0.40625)]
        at = [shift + scale * x for x in (-0.3125, 0.09375, -0.28125)]
        return self.render(scene, eye, at, 90)

    def flat(self, depth):
        scene = self.begin()
        scene.world.node_tree.nodes["Background"].inputs[0].default_value = (1, 1, 1, 1)
        scene.world.node_tree.nodes["Background"].inputs[1].default_value = 1.0
        body = self.add(scene, "primitive_cube_add", self.material(0.5), size=2)
        body.scale = (1, 1, depth)
        return self.render(scene, (0, 0, 5), (0, 0, 0), 10)

    def tiny_sphere(self, radius):
        scene = self.begin(depth=1)
        self.add(scene, "primitive_plane_add", self.material(1.0), size=0.2)
        # The power of a spherical lamp is 4π²R² times its radiance.
        lamp = self.bpy.data.lights.new("l", "POINT")
        lamp.shadow_soft_size, lamp.energy = radius, 4 * math.pi**2
        body = self.bpy.data.objects.new("l", lamp)
        body.location = (0, 0, 1)
        scene.collection.objects.link(body)
        return self.render(scene, (0.3, 0.2, 0.8), (0, 0, 0), 1.0)


def cases():
    """Yields the id, description, exact value and render function of every case."""
    yield "A01", "furnace, cube of size 1e-3", 2.0, lambda r: r.furnace(1e-3)
    yield "A01", "furnace, cube of size 1e-6", 2.0, lambda r: r.furnace(1e-6)
    yield "A01", "furnace, sphere of size 1", 2.0, lambda r: r.furnace(1.0, shape="sphere")
    for shift in (1e4, 1e5, 1e6):
        yield "A02", f"furnace, cube translated by {shift:.0e}", 2.0, lambda r, shift=shift: r.furnace(1.0, shift)
    yield "A19", "cube flattened to a plane in a white environment", 0.5, lambda r: r.flat(0.0)
    yield "A19", "cube flattened to 1e-20", 0.5, lambda r: r.flat(1e-20)
    for radius in (1e-2, 1e-3, 2e-4, 1e-4):
        yield "B01", f"irradiance/π of a sphere light, R/d = {radius:.0e}", 1.0, lambda r, q=radius: r.tiny_sphere(q)
    yield "D10", "floor in an environment of 0.5 with one NaN texel", None, lambda r: r.texel(float("nan"))
    yield "D10", "floor in an environment of 0.5 with one infinite texel", None, lambda r: r.texel(float("inf"))
    for seed in (0, 1, 2):
        yield "D02", f"furnace of albedo 0.99 with roulette, seed {seed}", 100.0, lambda r, seed=seed: r.furnace(
            albedo=0.99, side=64, spp=16, depth=2000, rr=5, seed=seed
        )


def cell(renderer, case, exact, how):
    if case == "D10" and renderer.name == "Cycles":
        return "–", True
    # The near plane of Blender's cameras is at least 1e-6, and `Cycles.furnace` is always a cube.
    unfit = ("sphere of size", "size 1e-6")
    if (case == "D02" or any(what in how[0] for what in unfit)) and renderer.name == "Cycles":
        return "–", True
    try:
        values = how[1](renderer)
    except Exception as e:  # a renderer may refuse the scene
        return f"refused: {str(e).splitlines()[0][:60]}", True
    bad = sum(not math.isfinite(v) for v in values)
    if bad:
        return f"**{bad} of {len(values)} pixels not finite**", False
    m, se = error(values)
    right = exact is not None and abs(m - exact) <= 4 * se + 1e-3 * exact
    return (f"{m:.4f} ± {se:.4f}" if right or exact is None else f"**{m:.4f} ± {se:.4f}**"), right


def main():
    renderers = []
    for kind in (Mitsuba, Cycles):
        try:
            renderers.append(kind())
        except ImportError as e:
            print(f"{kind.name} is skipped: {e}", file=sys.stderr)
    print("| case | scene | exact | " + " | ".join(f"{r.name} {r.version}" for r in renderers) + " |")
    print("|---|---|---|" + "---|" * len(renderers))
    for case, what, exact, how in cases():
        cells = [cell(r, case, exact, (what, how))[0] for r in renderers]
        print(f"| {case} | {what} | {'refusal' if exact is None else exact} | " + " | ".join(cells) + " |", flush=True)
    for r in renderers:
        if isinstance(r, Mitsuba):
            print(f"| A22 | distinct directions of 1000 pixels, 0.001°, rotated | 1000 | **{r.directions()}** | – |")
    if len(sys.argv) > 1:
        ids = "A01,A02,A19,A22,B01,D02,D10"
        run = subprocess.run([sys.argv[1], "stress", "--case", ids, "--json"], capture_output=True, text=True)
        for row in json.loads(run.stdout)["cases"]:
            print(f"dapple {row['id']}: {'pass' if row['passed'] else 'FAIL'}: {row['note']}")


if __name__ == "__main__":
    main()
