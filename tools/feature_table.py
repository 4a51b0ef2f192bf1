#!/usr/bin/env python3
"""Measures the cost of sets of Cargo features, for the table in README.md: the number of third-party crates, the CPU
seconds of a release build from scratch, and the size of the program without debug information. Run it from the root, on
Linux:

    python3 tools/feature_table.py [FEATURES ...]        # such as "" gltf,parallel; default: the rows of the table
"""

import os
import pathlib
import resource
import shutil
import subprocess
import sys

ROWS = ["", "parallel", "huge-pages", "report", "png", "exr", "gltf", "gltf,exr,png,parallel", "manual", "gltf,exr,png,parallel,huge-pages,report,manual"]
TARGET = pathlib.Path("target/feature_table").resolve()


def crates(features):
    """Returns the number of third-party crates."""
    command = ["cargo", "tree", "--locked", "-e", "normal", "--prefix", "none", "-p", "dapple"]
    command += ["--no-default-features", "--features", features]
    lines = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
    return len({line.split()[0] for line in lines if line and not line.startswith("dapple")})


def build(features):
    """Returns the CPU seconds of the build and the size of the program in bytes."""
    shutil.rmtree(TARGET, ignore_errors=True)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = ["cargo", "build", "--release", "--locked", "--bin", "dapple", "--no-default-features"]
    env = dict(os.environ, CARGO_TARGET_DIR=str(TARGET))
    subprocess.run([*command, "--features", features], env=env, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    program = TARGET / "release/dapple"
    subprocess.run(["strip", str(program)], check=True)
    return seconds, program.stat().st_size


def main():
    print("| features | crates | build, CPU s | program, MB |\n|---|---|---|---|", flush=True)
    for features in sys.argv[1:] or ROWS:
        seconds, size = build(features)
        name = ", ".join(f"`{f}`" for f in features.split(",")) if features else "none"
        print(f"| {name} | {crates(features)} | {seconds:.0f} | {size / 1e6:.1f} |", flush=True)
    shutil.rmtree(TARGET, ignore_errors=True)


if __name__ == "__main__":
    main()
