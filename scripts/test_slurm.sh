#!/usr/bin/env bash
# Run the job of docs/howto/restart.md in a SLURM of its own on this machine: it is stopped by the
# signal before its time limit, requeues itself and goes on, until its history equals that of a run
# that nobody stopped. Needs root and Debian's slurmctld, slurmd, slurm-client and munge; the daemons
# end with the script. Takes some five minutes, because SLURM waits before it starts a job again.
# Exit code 3: not tested, because something of that is missing.
set -euo pipefail
cd "$(dirname "$0")/.."
checkout=$PWD
for program in slurmctld slurmd sbatch munged; do
    PATH=$PATH:/usr/sbin command -v $program >/dev/null || {
        echo "== slurm: not tested, there is no $program"
        exit 3
    }
done
[ "$(id -u)" -eq 0 ] || {
    echo "== slurm: not tested, that needs root"
    exit 3
}

work=$(mktemp -d)
chmod 755 "$work"
export SLURM_CONF=$work/slurm.conf PATH=$checkout/.venv/bin:$PATH:/usr/sbin
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMP_NUM_THREADS=1
end() {
    scancel --user=root 2>/dev/null || true
    for name in slurmctld slurmd munged; do
        [ ! -e "$work/$name.pid" ] || kill "$(cat "$work/$name.pid")" 2>/dev/null || true
    done
    sleep 3
    rm -rf "$work"
}
trap end EXIT

mkdir -m 755 "$work/munge" "$work/state" "$work/spool"
dd if=/dev/urandom of="$work/munge/key" bs=128 count=1 status=none
chmod 600 "$work/munge/key"
munged --force --key-file="$work/munge/key" --socket="$work/munge/socket" \
    --pid-file="$work/munged.pid" --log-file="$work/munge/log" --seed-file="$work/munge/seed"
cat >"$SLURM_CONF" <<EOF
ClusterName=here
SlurmctldHost=$(hostname)(127.0.0.1)
SlurmctldPort=26817
SlurmdPort=26818
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$work/munge/socket
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=pmix
MpiParams=ports=26820-26850
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
ReturnToService=2
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
NodeName=$(hostname) NodeAddr=127.0.0.1 CPUs=$(env -u OMP_NUM_THREADS nproc) State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
EOF
slurmctld
slurmd
sinfo

# A block of the page by its caption.
block() {
    awk -v caption=":caption: $1" '/^```$/ { inside = 0 } inside { print } $0 == caption { inside = 1 }' \
        "$checkout/docs/howto/restart.md"
}
cd "$work"
block job.sh >job.sh
block big.toml | sed "s/^end = .*/end = 250/" >big.toml
echo "== the run that nobody stops"
srun --immediate=60 --ntasks=2 turbine-fenicsx run big.toml -o whole --quiet
echo "== the job, at most two minutes at a time" # SLURM may send signals a minute early
job=$(sbatch --parsable --ntasks=2 --time=2 --signal=USR1@30 --output=job.out job.sh)
while state=$(squeue --noheader --job "$job" --format '%T %r' 2>/dev/null) && [ -n "$state" ]; do
    echo "$(date +%T) $state $(tail -qn 1 out/big/history.csv 2>/dev/null | cut -d , -f 1)"
    sleep 10
done
grep -v 'INFO step' job.out
grep -q 'error: interrupted' job.out || {
    echo "== slurm: the job came to its end before the signal, nothing is shown"
    exit 1
}
echo "== compare"
python - whole/history.csv out/big/history.csv <<'EOF'
import csv, sys

whole, parts = (list(csv.DictReader(open(name))) for name in sys.argv[1:])
different = [
    (row["time_[s]"], key)
    for row, other in zip(whole, parts)
    for key in row
    if key != "wall_time_[s]" and row[key] != other[key]
]
print(len(whole), "rows,", len(parts), "in parts,", len(different), "different")
sys.exit(len(whole) != len(parts) or bool(different))
EOF
echo "== a load set: srun starts its runs"
mkdir set
cp "$checkout/demos/load_set/turbine.toml" set
cat >set/local.toml <<EOF
case = "turbine.toml"
situations = ["1.2"]
situation."1.2" = {winds = ["12 m/s"], seeds = 4, duration = "2 s", transient = "1 s"}
EOF
{ echo 'launcher = "srun --ntasks=1 --exact"'; cat set/local.toml; } >set/nodes.toml
turbine-fenicsx dlc set/local.toml -o local --quiet
sbatch --wait --ntasks=2 --output=set.out --wrap "turbine-fenicsx dlc set/nodes.toml -o nodes --progress log"
cat set.out
for table in runs.csv set.csv winds.csv fatigue.csv markov.csv set.nc; do
    cmp "local/$table" "nodes/$table"
done
