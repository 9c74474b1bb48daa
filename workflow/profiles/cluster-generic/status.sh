#!/bin/sh
# Print the state of a cluster job for Snakemake: running, success or failed.
#   status.sh COMMAND JOB      COMMAND prints the names of the user's jobs that have not ended
# A job that ends has written its exit status (jobscript.sh). A job that was cancelled, killed or lost
# with its node has not: if COMMAND does not list it any more, it has failed.
exit_status=.snakemake/cluster/$2.exit

if [ ! -s "$exit_status" ]; then
    # If the scheduler does not answer, the state is unknown: check again later.
    jobs=$(sh -c "$1" 2>/dev/null) || {
        echo running
        exit
    }
    if printf '%s\n' "$jobs" | grep -qxF -e "$2"; then
        echo running
        exit
    fi
    # The job may have just ended, with its file not yet visible over the network.
    for _ in 1 2 3 4 5 6 7 8 9 10; do
        [ -s "$exit_status" ] && break
        sleep 1
        ls .snakemake/cluster >/dev/null # makes a network file system refresh
    done
fi
if [ "$(cat "$exit_status" 2>/dev/null)" = 0 ]; then echo success; else echo failed; fi
