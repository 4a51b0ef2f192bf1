#!/usr/bin/env python3
"""Compares an image with block means of other renderers.

This is a development tool. It needs the Python packages numpy and OpenEXR.

    dapple render SCENE.glb --size WxH --max-bounces 15 --spp 256 --aov variance -o ours.exr
    python3 tools/compare_blocks.py ours.exr SCENE.blocks.json

A block agrees if the difference is at most 1 % or 4 standard errors (of both images combined), whichever is larger.
"""
import json
import sys

import numpy as np
import OpenEXR


def load(path):
    """Returns the mean and the variance of the mean, each height × width × 3."""
    part = OpenEXR.File(path, separate_channels=True).parts[0]
    stack = lambda prefix: np.stack([part.channels[prefix + c].pixels for c in "RGB"], axis=-1).astype(np.float64)
    return stack(""), stack("variance.")


def blocks(image, size):
    rows = range(0, image.shape[0], size)
    columns = range(0, image.shape[1], size)
    return np.array([[image[y:y + size, x:x + size].mean(axis=(0, 1)) for x in columns] for y in rows])


def main():
    mean, variance = load(sys.argv[1])
    reference = json.load(open(sys.argv[2]))
    size = reference["block"]
    ours = blocks(mean, size)
    counts = blocks(np.ones_like(mean), size) * size * size
    error = np.sqrt(blocks(variance, size) / counts)
    worst = 0
    for name in ("mitsuba", "cycles"):
        theirs = np.array(reference[name]["mean"])
        their_error = np.array(reference[name]["se"])
        tolerance = np.maximum(0.01 * np.abs(theirs), 4 * np.sqrt(error**2 + their_error**2))
        outside = int((np.abs(ours - theirs) > tolerance).sum())
        relative = np.abs(ours - theirs).sum(axis=-1) / np.maximum(theirs.sum(axis=-1), 1e-9)
        print(f"| {name} | mean {mean.mean():.5f} / {theirs.mean():.5f} ({100 * (mean.mean() / theirs.mean() - 1):+.2f} %) "
              f"| block difference median {100 * np.median(relative):.2f} %, largest {100 * relative.max():.2f} % "
              f"| outside {outside} of {theirs.size} |")
        worst = max(worst, outside)
    sys.exit(1 if worst else 0)


main()
