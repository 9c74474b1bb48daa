#!/usr/bin/env bash
# End the SLURM that up.sh started with the same folder: its jobs, its daemons and nothing else.
#
#   tests/slurm/down.sh FOLDER
#
# The folder stays, with the logs. Does nothing where there is nothing to end.
set -uo pipefail

if [ $# -ne 1 ]; then
    echo "usage: tests/slurm/down.sh FOLDER" >&2
    exit 2
fi
folder=$(realpath -m "$1")

# Processes of the cluster, found by what they inherited from up.sh: a pid in a file may meanwhile
# be somebody else's, and the processes of a lost node have no parent left.
members() {
    local file pid
    for file in $(grep -lzxF "VIBRISSA_SLURM=$folder" /proc/[0-9]*/environ 2>/dev/null); do
        pid=${file#/proc/}
        echo "${pid%/environ}"
    done
    # These write their title over their environment, but stay in the folder of the logs.
    for pid in $(pgrep -f '^slurmstepd: '); do
        [[ $(readlink "/proc/$pid/cwd") != "$folder"/* ]] || echo "$pid"
    done
}

end() { # SIGNAL SECONDS
    local end=$((SECONDS + $2)) pids
    while pids=$(members) && [ -n "$pids" ]; do
        # shellcheck disable=SC2086 # one word for each
        kill -s "$1" $pids 2>/dev/null
        [ $SECONDS -lt $end ] || return 1
        sleep 0.3
    done
}

if [ "$(readlink /etc/slurm/slurm.conf)" = "$folder/vibrissa-slurm.conf" ] && scontrol ping |
    grep -q UP; then
    timeout 10 scancel --user=root
    for _ in $(seq 20); do
        [ -n "$(timeout 10 squeue -h)" ] || break
        sleep 0.3
    done
fi
end TERM 5 || end KILL 5 || echo "still there: $(members | tr '\n' ' ')" >&2
for name in slurm slurmdbd; do
    case $(readlink /etc/slurm/$name.conf) in
    "$folder"/*) rm /etc/slurm/$name.conf ;;
    esac
done
[ -z "$(members)" ]
