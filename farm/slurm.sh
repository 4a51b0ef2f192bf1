#!/usr/bin/env bash
# Renders an image as a Slurm job array, and merges it in a second job that depends on the array.
#
#   farm/slurm.sh SCENE OUT SLICES IMAGE [options of dapple render]
#
# prints the ids of both jobs. SBATCH holds further options of sbatch, such as '--partition=render --cpus-per-task=16'.
set -euo pipefail
[ $# -ge 4 ] || { sed -n '2,6s/^# \{0,1\}//p' "$0" >&2; exit 2; }
here=$(cd "$(dirname "$0")" && pwd)
scene=$(realpath "$1") out=$(realpath -m "$2") slices=$3 image=$(realpath -m "$4")
shift 4
mkdir -p "$out"
export DAPPLE=${DAPPLE:-dapple}
words() { printf '%q ' "$@"; }
# A task that is requeued, after a failure of its node or by the scheduler, continues from its checkpoint. SIGTERM comes
# 30 s before the end of the time limit; the task then ends with code 3 and asks to be queued again.
# shellcheck disable=SC2086
array=$(sbatch --parsable --array="0-$((slices - 1))" --job-name=dapple --requeue --open-mode=append \
  --signal=B:TERM@30 --output="$out/%a.log" ${SBATCH:-} <<JOB
#!/usr/bin/env bash
$(words "$here/render.sh" "$scene" "$out") \$SLURM_ARRAY_TASK_ID $(words "$slices" "$@") &
trap 'kill -TERM \$!' TERM
wait \$!
code=\$?
# A trapped signal ends the first wait before the render has ended.
if [ \$code -gt 128 ]; then wait \$!; code=\$?; fi
if [ \$code -eq 3 ]; then
  scontrol requeue "\${SLURM_ARRAY_JOB_ID}_\$SLURM_ARRAY_TASK_ID"
  sleep 60
fi
exit \$code
JOB
)
# shellcheck disable=SC2086
merge=$(sbatch --parsable --dependency="afterok:$array" --kill-on-invalid-dep=yes --job-name=dapple-merge \
  --output="$out/merge.log" ${SBATCH:-} --wrap "$(words "$here/merge.sh" "$out" "$slices" "$image")")
echo "$array $merge"
