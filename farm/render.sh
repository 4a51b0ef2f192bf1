#!/usr/bin/env bash
# Renders one slice of an image as a part: the work of one task, whatever the scheduler.
#
#   farm/render.sh SCENE OUT SLICE SLICES [options of dapple render]
#
# writes OUT/SLICE.part, for SLICE from 0 to SLICES - 1. It can be killed and repeated at any time: it continues from
# OUT/SLICE.checkpoint, and does nothing if the part exists. DAPPLE names the program; CPUs limits its threads.
set -euo pipefail
[ $# -ge 4 ] || { sed -n '2,9s/^# \{0,1\}//p' "$0" >&2; exit 2; }
scene=$1 out=$2 slice=$3 slices=$4
shift 4
dapple=${DAPPLE:-dapple}
mkdir -p "$out"
part=$out/$slice.part
[ -e "$part" ] && exit 0
range=$("$dapple" plan "$scene" --slices "$slices" "$@" | sed -n "$((slice + 1))p")
[ -n "$range" ] || { echo "there is no slice $slice of $slices" >&2; exit 2; }
threads=${CPUS:-${SLURM_CPUS_PER_TASK:-}}
# The render replaces this shell, so that a signal reaches it: it then writes the checkpoint and ends with code 3.
# shellcheck disable=SC2086
exec "$dapple" render "$scene" "$@" $range ${threads:+--threads $threads} --progress "${PROGRESS:-auto}" \
  --checkpoint "$out/$slice.checkpoint" --resume "$out/$slice.checkpoint" -o "$part"
