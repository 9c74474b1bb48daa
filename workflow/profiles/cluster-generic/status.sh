#!/bin/sh
# Say for Snakemake what became of a cluster job: running, success or failed.
#   status.sh COMMAND JOB      COMMAND prints the names of the user's jobs that have not ended
# A job that ends leaves its exit status behind (jobscript.sh). One that was cancelled, or killed,
# or lost with its node, leaves nothing, and would be waited for for ever.
exit_status=.snakemake/cluster/$2.exit

if [ ! -s "$exit_status" ]; then
    # A scheduler that does not answer says nothing about the job: ask again later.
    jobs=$(sh -c "$1" 2>/dev/null) || {
        echo running
        exit
    }
    if printf '%s\n' "$jobs" | grep -qxF -e "$2"; then
        echo running
        exit
    fi
    # It may have ended just now, and its file be on its way here over the network.
    for _ in 1 2 3 4 5 6 7 8 9 10; do
        [ -s "$exit_status" ] && break
        sleep 1
        ls .snakemake/cluster >/dev/null # has a network file system look again
    done
fi
if [ "$(cat "$exit_status" 2>/dev/null)" = 0 ]; then echo success; else echo failed; fi
