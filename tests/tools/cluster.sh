#!/usr/bin/env bash
# A Slurm cluster of two nodes on this machine, loopback only, with a munge key, ports and folders of its own.
#   cluster.sh start DIR    DIR is made; its processes' numbers are in DIR/*.pid
#   cluster.sh stop DIR     ends what start has started, and no other process
#   cluster.sh node DIR N   starts node N (1, 2) alone, after its end
#   cluster.sh kill DIR N   node N loses its power: its daemon and all that runs on it end at once
# With SLURM_CONF=DIR/slurm.conf the commands sbatch, squeue, scontrol and scancel talk to it.
set -euo pipefail
PATH=$PATH:/usr/sbin
verb=$1 dir=$2
[ ! -d "$dir" ] || dir=$(cd "$dir" && pwd -P)
cores=${CLUSTER_CORES:-2}

start_node() {
    slurmd -N "node$1" -f "$dir/slurm.conf" >>"$dir/node$1.out" 2>&1
}

wait_for() { # seconds, command...
    local tries=$(($1 * 20))
    shift
    for ((i = 0; i < tries; ++i)); do
        "$@" >/dev/null 2>&1 && return
        sleep 0.05
    done
    echo "cluster.sh: not in time: $*" >&2
    tail -n 5 "$dir"/*.log "$dir"/*.out >&2 || true
    exit 1
}

both_idle() {
    [ "$(SLURM_CONF=$dir/slurm.conf sinfo -h -N -o %T | grep -c '^idle')" = 2 ]
}

free_port() { # the first from $1 on that nobody listens on
    local port=$1
    while (exec 3<>/dev/tcp/127.0.0.1/"$port") 2>/dev/null; do port=$((port + 1)); done
    echo "$port"
}

case $verb in
start)
    mkdir -p "$dir"/{state,node1,node2}
    dir=$(cd "$dir" && pwd -P)
    chmod 0700 "$dir/state"
    # munge asks for folders and a key that nobody else may write.
    head -c 128 /dev/urandom >"$dir/munge.key"
    chmod 0400 "$dir/munge.key"
    munged --force --key-file="$dir/munge.key" --socket="$dir/munge.socket" --pid-file="$dir/munge.pid" \
        --log-file="$dir/munge.log" --seed-file="$dir/munge.seed" --num-threads=2 2>"$dir/munge.out"
    # Tests that run at once have other process numbers; what connects somewhere gets ports from 32768 on.
    base=$((12000 + $$ * 40 % 20000))
    controller=$(free_port $base) first=$(free_port $((controller + 1))) second=$(free_port $((controller + 20)))
    cat >"$dir/slurm.conf" <<CONF
ClusterName=tumble
SlurmctldHost=localhost(127.0.0.1)
SlurmctldPort=$controller
AuthType=auth/munge
AuthInfo=socket=$dir/munge.socket,cred_expire=5
CredType=cred/munge
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/%n
SlurmctldPidFile=$dir/controller.pid
SlurmdPidFile=$dir/%n.pid
SlurmctldLogFile=$dir/controller.log
SlurmdLogFile=$dir/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=sched_interval=1,batch_sched_delay=1,sched_min_interval=200000
ReturnToService=2
SlurmdTimeout=${CLUSTER_NODE_TIMEOUT:-5}
MessageTimeout=4
KillWait=2
OverTimeLimit=0
MinJobAge=300
NodeName=node1 NodeHostname=localhost NodeAddr=127.0.0.1 Port=$first CPUs=$cores State=UNKNOWN
NodeName=node2 NodeHostname=localhost NodeAddr=127.0.0.1 Port=$second CPUs=$cores State=UNKNOWN
PartitionName=all Nodes=node1,node2 Default=YES MaxTime=INFINITE State=UP
CONF
    slurmctld -f "$dir/slurm.conf" >"$dir/controller.out" 2>&1
    start_node 1
    start_node 2
    wait_for 60 both_idle # a tenth of a second, where the machine has nothing else to do
    ;;
node)
    start_node "$3"
    ;;
kill)
    kill -9 "$(cat "$dir/node$3.pid")"
    # Its tasks know the node's name and this cluster; what started them is Slurm's own. At once: none is to end by itself.
    for environ in $(grep -lzx "SLURMD_NODENAME=node$3" /proc/[0-9]*/environ 2>/dev/null); do
        grep -zqx "SLURM_CONF=$dir/slurm.conf" "$environ" || continue
        process=${environ%/environ}
        parent=$(sed 's/.*) . //; s/ .*//' "$process/stat")
        [ "$(cat "/proc/$parent/comm")" != slurmstepd ] || kill -9 "$parent" || true
        kill -9 "${process#/proc/}" || true
    done 2>/dev/null
    ;;
stop)
    for name in node1 node2 controller munge; do
        [ -s "$dir/$name.pid" ] || continue
        process=$(cat "$dir/$name.pid")
        kill "$process" 2>/dev/null || continue
        for ((i = 0; i < 100; ++i)); do
            kill -0 "$process" 2>/dev/null || break
            sleep 0.05
        done
    done
    ;;
*)
    echo "usage: cluster.sh start|stop DIR, cluster.sh node DIR N" >&2
    exit 2
    ;;
esac
