#!/usr/bin/env bash
# Merges the parts of all slices to an image, and removes the checkpoints.
#
#   farm/merge.sh OUT SLICES IMAGE...
#
# reads OUT/0.part to OUT/(SLICES - 1).part.
set -euo pipefail
[ $# -ge 3 ] || { sed -n '2,6s/^# \{0,1\}//p' "$0" >&2; exit 2; }
out=$1 slices=$2
shift 2
parts=() outputs=()
for ((slice = 0; slice < slices; slice++)); do parts+=("$out/$slice.part"); done
for image; do outputs+=(-o "$image"); done
"${DAPPLE:-dapple}" merge "${parts[@]}" "${outputs[@]}"
rm -f "$out"/*.checkpoint
