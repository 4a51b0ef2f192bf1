#!/usr/bin/env python3
"""Checks that kernels over lanes are compiled to instructions: lists the calls inside them and fails on unexpected ones.

    python3 tools/kernel_calls.py [--package dapple-math] [--example NAME ... | --lib]

A function or closure over lanes that is not inlined is compiled without the instruction set, and the compiler then turns
each of its operations into a call, without a warning. This script compiles examples, or with
--lib the package itself, to assembly (cargo rustc --release,
without link-time optimisation, which would hide it) and reads every instance of the entry functions run_avx2 and
run_avx512. Allowed are calls of the functions for arguments outside of a formula's domain, and of panics. It also fails
if an entry has no instruction on the registers of its instruction set. It needs Python 3 and Rust, on x86-64.
"""
import argparse
import collections
import glob
import os
import re
import subprocess
import sys

# Parts of the names that a kernel may refer to: functions that it may call, and the table by which AVX2 packs lanes.
ALLOWED = ["by_lane13replace_lanes", "4core9panicking", "slice_index_fail", "slice5index", "memset", "memcpy", "packed6PACKED",
           # Rare lanes of lights, which are computed in f64, and lights of which none reaches the receiver.
           "flat12sample_lanes", "flat9pdf_lanes", "sphere12sample_lanes", "sphere9pdf_lanes", "disk12sample_lanes",
           "disk9pdf_lanes", "point13falloff_lanes", "point11share_lanes", "others12sample_lanes", "others9pdf_lanes", "by_intensity",
           "far_importance", "sample_far"]
# Tables of directional albedos.
ALLOWED += ["albedo5NODES", "albedo5MEANS"]
# The same of sampling and camera.
ALLOWED += ["integer13replace_lanes", "sobol8PRODUCTS", "10exact_rays"]
# Rays of a packet that are traced alone, and triangles that f64 decides.
ALLOWED += ["8triangle12barycentrics", "3bvh4simd"]
# Rays that packets leave for later, in a list that grows.
ALLOWED += ["alloc7raw_vec"]
# Rows of the path tracer's batches that are computed one by one, and their textures.
ALLOWED += ["shade9note_cuts", "shade9note_rows", "lights7look_up", "textured6Looked2up", "escapes7Escapes3add"]
ENTRIES = {"run_avx2": "%ymm", "run_avx512": "%zmm"}
CALL = re.compile(r"^\s+(?:callq?|jmpq?)\s+\*?(\S+)")
MOVES = re.compile(r"^\s+v?mov")


def assembly(package, example):
    """Compiles one example, or the library if it is None, and returns the lines of its assembly."""
    # In a folder of its own: cargo writes the assembly only when it compiles, and it keeps that of the last time there.
    target = os.path.join(os.environ.get("CARGO_TARGET_DIR", "target"), "kernel_calls")
    environment = dict(os.environ, CARGO_TARGET_DIR=target, CARGO_PROFILE_RELEASE_LTO="off")
    environment["CARGO_PROFILE_RELEASE_CODEGEN_UNITS"] = "1"
    command = ["cargo", "rustc", "--quiet", "--release", "-p", package]
    command += ["--example", example] if example else ["--lib"]
    subprocess.run(command + ["--", "--emit", "asm", "-C", "debuginfo=0"], check=True, env=environment)
    folder, name = ("examples", example) if example else ("deps", package)
    pattern = os.path.join(target, "release", folder, f"{name.replace('-', '_')}-*.s")
    found = sorted(glob.glob(pattern), key=os.path.getmtime, reverse=True)
    if not found:
        sys.exit(f"{example}: no assembly at {pattern}; remove {target} and try again")
    with open(found[0], encoding="utf-8") as file:
        return file.read().splitlines()


def functions(lines):
    """Yields (name, lines) of every function."""
    name, body = None, []
    for line in lines:
        label = re.match(r"^(_[A-Za-z0-9_.$]+):", line)
        if label:
            name, body = label.group(1), []
        elif line.startswith(".Lfunc_end") and name:
            yield name, body
            name = None
        elif name:
            body.append(line)


def called(line):
    """Returns the function that a line calls or jumps to, if it is not a label of the same function."""
    match = CALL.match(line)
    if match and not match.group(1).startswith(".L"):
        return match.group(1).split("@")[0]
    return None


def check(name, entry, body):
    """Returns the faults of one kernel."""
    register = ENTRIES[entry]
    wide = sum(register in line and not MOVES.match(line) for line in body)
    calls = collections.Counter(filter(None, map(called, body)))
    # A call through a register is one of an address that was loaded from a name before.
    named = [n for n in calls if not n.startswith("%")]
    loaded = [m.group(1) for line in body if (m := re.search(r"(_ZN\S+|_R\S+)@GOTPCREL", line))]
    wrong = [n for n in named + loaded if not any(part in n for part in ALLOWED) and not is_argument(n)]
    print(f"{entry:10} {wide:5} instructions on {register}, {sum(calls.values())} calls  {name[-21:]}")
    faults = [f"{name} calls {n}" for n in sorted(set(wrong))]
    return faults + ([] if wide else [f"{name} has no instructions on {register}"])


def is_argument(name):
    """Whether a name is that of a scalar function that is passed to `replace_lanes`."""
    return re.search(r"trigonometric\d+libm_|4libm", name) is not None


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--package", default="dapple-math")
    parser.add_argument("--example", nargs="+", default=["lanes", "lane_functions"])
    parser.add_argument("--lib", action="store_true")
    options = parser.parse_args()
    faults = []
    for example in [None] if options.lib else options.example:
        kernels = collections.Counter()
        for name, body in functions(assembly(options.package, example)):
            for entry in ENTRIES:
                if re.search(rf"dispatch\d+{entry}\d", name):
                    kernels[entry] += 1
                    faults += check(name, entry, body)
        faults += [f"{example or options.package} has no instance of {entry}" for entry in ENTRIES if not kernels[entry]]
    if faults:
        sys.exit("unexpected calls:\n" + "\n".join(faults))
    print("no unexpected calls")


if __name__ == "__main__":
    main()
