#!/usr/bin/env python3
"""Measures the cost of features for a scene that does not use them.

Builds the example `plain` of dapple-integrator unchanged, and once for each feature with the code of that feature
compiled out (`--cfg without="NAME"`, for the crates of the workspace only), counts the instructions of each with
callgrind, and prints a table. The outputs must be identical. Run it from the root, with valgrind installed:

    python3 tools/feature_tax.py [FEATURE ...]
"""

import os
import pathlib
import re
import subprocess
import sys

FEATURES = ["lens", "time", "second_level", "medium", "environment", "textures", "clamp", "alpha", "layers", "coincident", "view"]
METHODS = ["path", "distribution"]
TARGET = pathlib.Path("target/feature_tax").resolve()


def build(without):
    """Builds the example without a feature (or with all features) and returns a copy of the binary."""
    env = dict(os.environ, CARGO_TARGET_DIR=str(TARGET))
    # Every feature has a separate compiler wrapper, so that cargo rebuilds the crates of the workspace and no others.
    wrapper = TARGET / f"rustc_without_{without}"
    flags = f"--cfg 'without=\"{without}\"'" if without else ""
    TARGET.mkdir(parents=True, exist_ok=True)
    wrapper.write_text(f'#!/bin/sh\nexec "$@" {flags}\n')
    wrapper.chmod(0o755)
    env["RUSTC_WORKSPACE_WRAPPER"] = str(wrapper)
    # Debug information does not change the instructions.
    env["CARGO_PROFILE_RELEASE_DEBUG"] = "0"
    command = ["cargo", "build", "--release", "--locked", "-p", "dapple-integrator", "--no-default-features"]
    subprocess.run([*command, "--example", "plain"], env=env, check=True)
    binary = TARGET / f"plain_{without}"
    binary.write_bytes((TARGET / "release/examples/plain").read_bytes())
    binary.chmod(0o755)
    return binary


def count(binary, method):
    """Returns the number of instructions and the output of a run."""
    out = f"--callgrind-out-file={TARGET / 'counts'}"
    run = subprocess.run(
        ["valgrind", "--tool=callgrind", out, str(binary), method], capture_output=True, text=True, check=True
    )
    return int(re.search(r"Collected : (\d+)", run.stderr).group(1)), run.stdout


def main():
    whole = build("")
    base = {method: count(whole, method) for method in METHODS}
    print("| feature | method | instructions | without it | tax |\n|---|---|---|---|---|", flush=True)
    for feature in sys.argv[1:] or FEATURES:
        binary = build(feature)
        for method, (all_in, expected) in base.items():
            left, output = count(binary, method)
            assert output == expected, f"the output without {feature} is different"
            tax = 100 * (all_in / left - 1)
            print(f"| {feature} | {method} | {all_in / 1e6:.2f} M | {left / 1e6:.2f} M | {tax:+.2f} % |", flush=True)


if __name__ == "__main__":
    main()
