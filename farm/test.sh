#!/usr/bin/env bash
# Tries the scripts of this folder on one host: a Slurm array of 8 slices, of which one is killed and requeued, and the
# same with Open Job Description. Both images must have the bytes of one render.
#
#   farm/test.sh [program]
#
# The default program is target/release/dapple. It installs what is missing, for which it has to run as root on Debian:
# slurm-wlm and munge by apt-get, and openjd-cli from PyPI into a folder of its own.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
root=$(dirname "$here")
DAPPLE=$(realpath "${1:-$root/target/release/dapple}")
export DAPPLE
[ -x "$DAPPLE" ] || { echo "$DAPPLE: no program; build it with cargo build --release" >&2; exit 2; }
work=$(mktemp -d)
scene=$root/scenes/cornell_spheres.gltf
options=(--size 96x72 --spp 512 --seed 3)
slices=8
daemons=()
finish() {
  code=$?
  for file in "${daemons[@]:-}"; do [ -f "$file" ] && kill "$(cat "$file")" 2>/dev/null; done
  [ $code -eq 0 ] && rm -rf "$work" || echo "kept: $work" >&2
  exit $code
}
trap finish EXIT
seconds() { date +%s.%N; }
since() { awk -v a="$1" -v b="$(seconds)" 'BEGIN { printf "%.1f", b - a }'; }

start=$(seconds)
"$DAPPLE" render "$scene" "${options[@]}" -o "$work/single.exr" --quiet
echo "one render: $(since "$start") s"

# Slurm: the daemons of one host, without systemd.
command -v sbatch slurmd munged >/dev/null || {
  apt-get update -qq
  DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends slurm-wlm munge >/dev/null
}
if ! pgrep -x munged >/dev/null; then
  install -d -o munge -g munge /run/munge
  su -s /bin/sh munge -c /usr/sbin/munged
fi
mkdir -p "$work"/slurm/{state,spool,log}
host=$(hostname -s)
cpus=$(nproc)
cat >"$work/slurm/slurm.conf" <<CONF
ClusterName=onebox
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
CredType=cred/munge
SlurmctldPidFile=$work/slurm/slurmctld.pid
SlurmdPidFile=$work/slurm/slurmd.pid
StateSaveLocation=$work/slurm/state
SlurmdSpoolDir=$work/slurm/spool
SlurmctldLogFile=$work/slurm/log/slurmctld.log
SlurmdLogFile=$work/slurm/log/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerType=sched/backfill
SchedulerParameters=sched_min_interval=0,batch_sched_delay=0,bf_interval=1
ReturnToService=2
KillWait=5
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/none
NodeName=$host NodeAddr=127.0.0.1 CPUs=$cpus Boards=1 SocketsPerBoard=1 CoresPerSocket=$cpus ThreadsPerCore=1 RealMemory=1000
PartitionName=render Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$work/slurm/slurm.conf
daemons=("$work/slurm/slurmd.pid" "$work/slurm/slurmctld.pid")
slurmctld -f "$SLURM_CONF"
sleep 2
slurmd -f "$SLURM_CONF"
for _ in $(seq 30); do sinfo -h -t idle | grep -q . && break; sleep 1; done
sinfo -h -t idle | grep -q . || { echo "Slurm does not start; see $work/slurm/log" >&2; exit 1; }

start=$(seconds)
read -r array merge < <("$here/slurm.sh" "$scene" "$work/slurm.out" $slices "$work/slurm.exr" "${options[@]}" --checkpoint-every 0.2s)
# The task is killed while it renders, and queued again.
killed=
for _ in $(seq 6000); do
  [ -e "$work/slurm.out/3.part" ] && break
  squeue -h -j "$array" 2>/dev/null | grep -q . || break
  if [ -e "$work/slurm.out/3.checkpoint" ]; then
    scontrol requeue "${array}_3" && killed=yes
    break
  fi
  sleep 0.05
done
[ -n "$killed" ] || { cat "$work"/slurm.out/*.log >&2; echo "no task was killed" >&2; exit 1; }
for _ in $(seq 3600); do
  state=$(squeue -h -j "$merge" -o %T 2>/dev/null || true)
  # A requeued task waits for two minutes, unless it is told to start.
  scontrol update "JobId=${array}_3" StartTime=now 2>/dev/null || true
  [ -z "$state" ] && break
  sleep 0.5
done
grep -h -i "checkpoint\|error" "$work"/slurm.out/*.log || true
cmp "$work/single.exr" "$work/slurm.exr"
echo "Slurm: $slices tasks, one requeued, and the merge: $(since "$start") s, the same bytes"

# Open Job Description.
openjd=$(command -v openjd || true)
if [ -z "$openjd" ]; then
  python3 -m venv "$work/venv"
  "$work/venv/bin/pip" install -q openjd-cli
  openjd=$work/venv/bin/openjd
fi
"$openjd" check "$here/openjd.yaml"
start=$(seconds)
"$openjd" run "$here/openjd.yaml" --step Merge --run-dependencies \
  -p "Dapple=$DAPPLE" -p "Scene=$scene" -p "OutDir=$work/openjd.out" -p "Slices=$slices" \
  -p "LastSlice=$((slices - 1))" -p "Options=${options[*]} --fixed-seed" >"$work/openjd.log" || {
  tail -40 "$work/openjd.log" >&2
  exit 1
}
grep -q "openjd_progress: 100" "$work/openjd.log"
"$DAPPLE" render "$scene" "${options[@]}" --frames 0:1 --fixed-seed -o "$work/frame.exr" --quiet
cmp "$work/frame.exr" "$work/openjd.out/frame.0000.exr"
echo "Open Job Description: $slices tasks and the merge: $(since "$start") s, the same bytes"

# The manifests: syntax only.
python3 - "$here" <<'PY' || { echo "the manifests are not YAML" >&2; exit 1; }
import sys
try:
    import yaml
except ImportError:
    print("kubernetes.yaml: not checked, because PyYAML is missing")
    sys.exit()
for job in yaml.safe_load_all(open(sys.argv[1] + "/kubernetes.yaml")):
    assert job["apiVersion"] == "batch/v1" and job["kind"] == "Job", job
PY
echo "all is well"
