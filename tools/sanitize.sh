#!/usr/bin/env bash
# Runs the tests of a crate with AddressSanitizer: tools/sanitize.sh [crate] [arguments of cargo test]
#
# The default is dapple-geometry, whose traversal has the unsafe code of the workspace beside the lanes of dapple-math.
# The option is unstable, so that the compiler is told to accept it; the run-time library comes with stable Rust.
set -euo pipefail
cd "$(dirname "$0")/.."
crate=${1:-dapple-geometry}
shift || true
host=$(rustc -vV | sed -n 's/^host: //p')
export RUSTC_BOOTSTRAP=1 RUSTFLAGS=-Zsanitizer=address ASAN_OPTIONS=detect_stack_use_after_return=1
exec cargo test --locked --target "$host" --target-dir target/sanitize -p "$crate" --lib --tests "$@"
