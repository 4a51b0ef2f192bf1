#!/usr/bin/env python3
"""Prints the sizes of source files and functions as a table, with one row per crate and one for all crates.

    python3 tools/sizes.py [ROOT ...] [--rustfmt-defaults] [--longest N]

Several roots (checkouts) give one table each, for comparisons between commits. The lines of a file do not include its
tests. The lines of a function are those from its signature to its closing brace. With --rustfmt-defaults, a copy is
formatted with rustfmt's default settings first. It needs only Python 3 (and rustfmt for that option).
"""
import argparse
import os
import re
import shutil
import statistics
import subprocess
import sys
import tempfile

FUNCTION = re.compile(r"^\s*(?:pub(?:\([^)]*\))? )?(?:default )?(?:const )?(?:async )?(?:unsafe )?(?:extern \"C\" )?fn (\w+)")


def blanked(line):
    """Returns the line without strings, characters and comments, so that its braces can be counted."""
    line = re.sub(r'"(?:\\.|[^"\\])*"', '""', line)
    line = re.sub(r"'(?:\\.|[^'\\])'", "' '", line)
    return line.split("//")[0]


def without_tests(lines):
    for i, line in enumerate(lines):
        if line.startswith("#[cfg(test)]") and i + 1 < len(lines) and "mod " in lines[i + 1]:
            return lines[:i]
    return lines


def functions(lines):
    """Returns (name, lines) of every function with a body, including nested functions."""
    found = []
    for start, line in enumerate(lines):
        match = FUNCTION.match(line)
        if not match:
            continue
        depth, opened = 0, False
        for end in range(start, len(lines)):
            code = blanked(lines[end])
            if not opened and "{" not in code and code.rstrip().endswith(";"):
                break
            depth += code.count("{") - code.count("}")
            opened = opened or "{" in code
            if opened and depth <= 0:
                found.append((match.group(1), end - start + 1))
                break
    return found


def sources(root):
    crates = os.path.join(root, "crates")
    for crate in sorted(os.listdir(crates)):
        folder = os.path.join(crates, crate)
        inner = os.path.join(folder, "src")
        if os.path.isdir(folder):
            yield crate, inner if os.path.isdir(inner) else folder


def measure(folder):
    files, all_functions, comment, code = [], [], 0, 0
    for path, _, names in os.walk(folder):
        for name in sorted(names):
            if not name.endswith(".rs"):
                continue
            place = os.path.join(path, name)
            with open(place, encoding="utf-8") as file:
                lines = without_tests(file.read().split("\n"))
            files.append((len(lines), place))
            all_functions += [(size, function, place) for function, size in functions(lines)]
            stripped = [line.strip() for line in lines]
            comment += sum(line.startswith("//") for line in stripped)
            code += sum(bool(line) and not line.startswith("//") for line in stripped)
    return files, all_functions, comment, code


def row(name, measured):
    files, all_functions, comment, code = measured
    sizes = sorted(size for size, _ in files)
    lengths = sorted(size for size, _, _ in all_functions) or [0]
    at = lambda share: lengths[min(len(lengths) - 1, int(share * len(lengths)))]
    return (f"| {name} | {sum(sizes)} | {statistics.median(sizes):.0f} / {sizes[-1]} | "
            f"{at(0.5)} / {at(0.99)} / {lengths[-1]} | {sum(n > 60 for n in lengths)} | {comment / max(code, 1):.2f} |")


def table(root, longest):
    print("| crate | lines | file median / max | function p50 / p99 / max | over 60 | comment per code line |")
    print("|---|---|---|---|---|---|")
    total = ([], [], 0, 0)
    for crate, folder in sources(root):
        measured = measure(folder)
        if measured[0]:
            print(row(crate, measured))
            total = tuple(a + b for a, b in zip(total, measured))
    print(row("all", total))
    for size, function, place in sorted(total[1], reverse=True)[:longest]:
        print(f"  {size} {function} {os.path.relpath(place, root)}")


def formatted(root):
    copy = tempfile.mkdtemp()
    shutil.copytree(os.path.join(root, "crates"), os.path.join(copy, "crates"))
    files = [os.path.join(p, n) for p, _, names in os.walk(copy) for n in names if n.endswith(".rs")]
    for file in files:
        with open(file, encoding="utf-8") as source:
            text = source.read()
        plain = ["rustfmt", "--edition", "2024", "--config", "max_width=100,use_small_heuristics=Default"]
        done = subprocess.run(plain, input=text, capture_output=True, text=True, check=False, cwd=copy)
        if done.returncode == 0:
            with open(file, "w", encoding="utf-8") as target:
                target.write(done.stdout)
    return copy


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("roots", nargs="*", default=["."])
    parser.add_argument("--rustfmt-defaults", action="store_true")
    parser.add_argument("--longest", type=int, default=0, metavar="N")
    arguments = parser.parse_args()
    for root in arguments.roots:
        print(f"\n{root}" + (", with rustfmt's default settings" if arguments.rustfmt_defaults else "") + "\n")
        place = formatted(root) if arguments.rustfmt_defaults else root
        table(place, arguments.longest)
        if place != root:
            shutil.rmtree(place)


if __name__ == "__main__":
    sys.exit(main())
