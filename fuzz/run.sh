#!/usr/bin/env bash
# Fuzzes one reader with libFuzzer, on stable Rust: fuzz/run.sh TARGET [seconds] [folder of seeds]
#
# TARGET is checkpoint, part, gltf, glb, hdr, exr or settings. Inputs that crash, hang or take too much memory are
# written to fuzz/found/TARGET-*; the corpus grows in fuzz/corpus/TARGET. A C++ compiler is required.
set -euo pipefail
cd "$(dirname "$0")"
target=${1:?target} seconds=${2:-600} seeds=${3:-}
mkdir -p "corpus/$target" found
flags='--cfg fuzzing -Cpasses=sancov-module -Ccodegen-units=1'
for option in level=4 inline-8bit-counters pc-table trace-compares; do
  flags+=" -Cllvm-args=-sanitizer-coverage-$option"
done
# With --target the flags do not apply to build scripts and procedural macros.
host=$(rustc -vV | sed -n 's/^host: //p')
RUSTFLAGS=$flags cargo build --target "$host" --locked
# shellcheck disable=SC2086
FUZZ=$target exec "target/$host/debug/fuzz" "corpus/$target" $seeds -max_total_time="$seconds" -timeout=30 \
  -rss_limit_mb=3000 -max_len=200000 -artifact_prefix="found/$target-" -print_final_stats=1
