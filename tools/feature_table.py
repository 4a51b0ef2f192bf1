#!/usr/bin/env python3
"""What does a choice of features take? Other people's crates, processor seconds of a release build from nothing, and bytes of
the program without debug information, as the table in README.md. From the root, on Linux:

    python3 tools/feature_table.py [FEATURES ...]        # such as "" gltf,parallel; without arguments the table's rows
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
    """How many crates that are not ours."""
    command = ["cargo", "tree", "--locked", "-e", "normal", "--prefix", "none", "-p", "dapple"]
    command += ["--no-default-features", "--features", features]
    lines = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
    return len({line.split()[0] for line in lines if line and not line.startswith("dapple")})


def build(features):
    """Processor seconds and bytes."""
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
