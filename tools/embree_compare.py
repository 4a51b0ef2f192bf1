#!/usr/bin/env python3
"""Rays per second of dapple's traversal against Embree 4 on the same rays, one thread, CPU time, rounds interleaved.

Development only. Needs a C compiler and the Python package `embreex` (4.4), of which only the Embree library is used:

    python3 -m pip download --no-deps -d wheels embreex==4.4.0.post1
    python3 tools/embree_compare.py wheels [FILE.glb ...]

Beside the meshes of the bench, those of the files are timed.
"""
import ctypes
import glob
import json
import math
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import zipfile

KINDS, ROUNDS = ["primary", "diffuse", "shadow"], 3


def embree(wheels, work):
    """The Embree library out of the wheel, behind the small C timer."""
    with zipfile.ZipFile(glob.glob(os.path.join(wheels, "embreex*.whl"))[0]) as wheel:
        wheel.extractall(work)
    libraries = glob.glob(os.path.join(work, "embreex.libs", "*.so*"))
    # Dependencies of the library first.
    for path in sorted(libraries, key=lambda p: "embree" in os.path.basename(p)):
        ctypes.CDLL(path, mode=ctypes.RTLD_GLOBAL)
    timer = os.path.join(work, "timer.so")
    source = os.path.join(os.path.dirname(os.path.abspath(__file__)), "embree_time.c")
    subprocess.run(["cc", "-O3", "-march=native", "-shared", "-fPIC", source, "-o", timer], check=True)
    library = ctypes.CDLL(timer)
    library.build.restype = ctypes.c_void_p
    library.build.argtypes = [ctypes.c_void_p, ctypes.c_size_t]
    library.pass_ = getattr(library, "pass")
    library.pass_.restype = ctypes.c_double
    library.pass_.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int, ctypes.POINTER(ctypes.c_size_t)]
    return library


def read(path):
    data = open(path, "rb").read()
    return ctypes.create_string_buffer(data, len(data)), len(data) // 4


def main():
    wheels = sys.argv[1] if len(sys.argv) > 1 else "wheels"
    files = [os.path.abspath(name) for name in sys.argv[2:]]
    with tempfile.TemporaryDirectory() as work:
        bench = ["cargo", "bench", "-q", "--bench", "traversal", "--"]
        subprocess.run(bench + ["--dump", work] + files, check=True)
        library = embree(wheels, os.path.join(work, "embree"))
        scenes, rays = {}, {}
        for mesh in sorted(path.stem for path in pathlib.Path(work).glob("*.tri")):
            corners, n = read(os.path.join(work, mesh + ".tri"))
            scenes[mesh] = (library.build(corners, n // 9), n // 9)
            for kind in KINDS:
                rays[mesh, kind] = read(os.path.join(work, f"{mesh}.{kind}"))
        ours = {key: [] for key in rays}
        theirs = {key: [] for key in rays}
        hits = {}
        for _ in range(ROUNDS):
            line = subprocess.run(bench + ["--rays", work], check=True, capture_output=True, text=True).stdout
            for (mesh, kind), samples in ours.items():
                mrays, hit = json.loads(line)[f"{mesh}.{kind}"]
                samples.append(mrays)
                hits[mesh, kind] = [hit, 0]
            for (mesh, kind), samples in theirs.items():
                buffer, n = rays[mesh, kind]
                count = ctypes.c_size_t()
                passes = [library.pass_(scenes[mesh][0], buffer, n // 7, kind == "shadow", ctypes.byref(count)) for _ in range(3)]
                samples.append(n / 7e6 / statistics.median(passes))
                hits[mesh, kind][1] = count.value
    ratios = []
    print("| mesh | triangles | rays | dapple Mrays/s | Embree Mrays/s | ratio | hits dapple / Embree |")
    print("|---|---|---|---|---|---|---|")
    for mesh, kind in ours:
        a, b = statistics.median(ours[mesh, kind]), statistics.median(theirs[mesh, kind])
        ratios.append(a / b)
        h = hits[mesh, kind]
        print(f"| {mesh} | {scenes[mesh][1]} | {kind} | {a:.2f} | {b:.2f} | {a / b:.2f} | {h[0]} / {h[1]} |")
    print(f"geometric mean of the ratios: {math.exp(statistics.mean(map(math.log, ratios))):.3f}")


main()
