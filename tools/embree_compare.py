#!/usr/bin/env python3
"""Compares the rays per second of dapple and Embree 4 on the same rays, in CPU time of one thread. The two programs
alternate on the same CPU.

This is a development tool. It needs a C compiler and the Python package `embreex` (4.4), of which only the Embree
library is used:

    python3 -m pip download --no-deps -d wheels embreex==4.4.0.post1
    python3 tools/embree_compare.py wheels [FILE.glb ...]

The meshes of the files are timed in addition to those of the benchmark.
"""
import ctypes
import glob
import math
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import zipfile

KINDS, ROUNDS = ["primary", "diffuse", "shadow"], 9


def embree(wheels, work):
    """Loads the Embree library from the wheel and returns the C timer, which calls it."""
    with zipfile.ZipFile(glob.glob(os.path.join(wheels, "embreex*.whl"))[0]) as wheel:
        wheel.extractall(work)
    libraries = glob.glob(os.path.join(work, "embreex.libs", "*.so*"))
    # The dependencies of the library are loaded first.
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
        if hasattr(os, "sched_setaffinity"):
            os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
        library = embree(wheels, os.path.join(work, "embree"))
        scenes, rays = {}, {}
        for mesh in sorted(path.stem for path in pathlib.Path(work).glob("*.tri")):
            corners, n = read(os.path.join(work, mesh + ".tri"))
            scenes[mesh] = (library.build(corners, n // 9), n // 9)
            for kind in KINDS:
                rays[mesh, kind] = read(os.path.join(work, f"{mesh}.{kind}"))
        with subprocess.Popen(bench + ["--rays", work], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
            results = compare(process, library, scenes, rays)
            process.stdin.close()
    report(scenes, results)


def compare(process, library, scenes, rays):
    """Returns, for every set of rays, the rounds of ((Mrays/s, hits) of dapple, (Mrays/s, hits) of Embree)."""

    def ours(mesh, kind):
        print(mesh, kind, file=process.stdin, flush=True)
        mrays, hits = process.stdout.readline().split()
        return float(mrays), int(hits)

    def theirs(mesh, kind):
        buffer, n = rays[mesh, kind]
        hits = ctypes.c_size_t()
        seconds = library.pass_(scenes[mesh][0], buffer, n // 7, kind == "shadow", ctypes.byref(hits))
        return n / 7e6 / seconds, hits.value

    # The first round is for warming up and is not counted.
    return {key: [in_turns(ours, theirs, key, turn) for turn in range(ROUNDS + 1)][1:] for key in rays}


def in_turns(a, b, key, turn):
    """Returns the results of a and b for `key`. In every second turn, b is measured first."""
    if turn % 2:
        second = b(*key)
        return a(*key), second
    return a(*key), b(*key)


def report(scenes, results):
    """Prints the table of medians over rounds. A ratio is the median of the ratios within the rounds."""
    ratios = []
    print("| mesh | triangles | rays | dapple Mrays/s | Embree Mrays/s | ratio | hits dapple / Embree |")
    print("|---|---|---|---|---|---|---|")
    for (mesh, kind), rounds in results.items():
        a, b = (statistics.median(r[who][0] for r in rounds) for who in (0, 1))
        ratios.append(statistics.median(r[0][0] / r[1][0] for r in rounds))
        hits = f"{rounds[0][0][1]} / {rounds[0][1][1]}"
        print(f"| {mesh} | {scenes[mesh][1]} | {kind} | {a:.2f} | {b:.2f} | {ratios[-1]:.2f} | {hits} |")
    print(f"geometric mean of the ratios: {math.exp(statistics.mean(map(math.log, ratios))):.3f}")


main()
