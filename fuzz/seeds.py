#!/usr/bin/env python3
"""Writes seeds for the targets checkpoint and part: fuzz/seeds.py PROGRAM FOLDER

Small files of several kinds of renders go into FOLDER/checkpoint and FOLDER/part, each as a file and as the state within
it, because a fuzzer does not guess the checksum of a file.
"""
import json
import os
import struct
import subprocess
import sys

RENDERS = {
    "plain": ["--spp", "4"],
    "layers": ["--spp", "4", "--aov", "all", "--transparent"],
    "adaptive": ["--adaptive", "--spp", "20"],
    "random": ["--spp", "5", "--pattern", "random", "--clamp", "1", "--aov", "removed"],
    "tree": ["--method", "distribution", "--pixel", "2x2", "--max-bounces", "2", "--yes"],
    "crop": ["--spp", "7", "--crop", "1,1,3,3"],
}


def state(path):
    """The encoded state within a file."""
    data = open(path, "rb").read()
    length = struct.unpack("<Q", data[:8])[0]
    begin, end = json.loads(data[8:8 + length])["state"]["data_offsets"]
    return data[8 + length + begin:8 + length + end]


def main():
    program, folder = sys.argv[1:]
    for kind in ("checkpoint", "part"):
        os.makedirs(f"{folder}/{kind}", exist_ok=True)
    for name, options in RENDERS.items():
        files = {kind: f"{folder}/{kind}/{name}" for kind in ("checkpoint", "part")}
        command = [program, "render", "--size", "4x3", "--quiet", *options]
        for kind, path in files.items():
            output = ["-o", path + ".part"] if kind == "part" else ["-o", path + ".exr", "--checkpoint", path]
            subprocess.run(command + output, check=True, stdout=subprocess.DEVNULL)
            if kind == "part":
                os.replace(path + ".part", path)
            else:
                os.remove(path + ".exr")
            open(path + ".state", "wb").write(state(path))


main()
