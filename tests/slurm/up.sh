#!/usr/bin/env bash
# A real SLURM on this one machine, from Debian's packages: one controller, two nodes, n1 and n2, of
# two CPUs each (they share the real ones), and a database that knows one account. No systemd,
# cgroups or network is needed.
#
#   tests/slurm/up.sh FOLDER      state, logs and configuration go to FOLDER
#   tests/slurm/down.sh FOLDER    ends what this started; the packages stay installed
#
# Exits with 77 where this cannot be tried (not root, not Debian, or a machine that belongs to a
# SLURM already), and 1 where it was tried and failed; in both cases the last line says why.
set -euo pipefail

if [ $# -ne 1 ]; then
    echo "usage: tests/slurm/up.sh FOLDER" >&2
    exit 2
fi
unable() {
    echo "$*" >&2
    exit 77
}
failed() {
    echo "$*" >&2
    env -u VIBRISSA_SLURM "$down" "$folder" # not half a cluster
    exit 1
}

[ "$(id -u)" = 0 ] || unable "bringing up SLURM needs root"
command -v apt-get >/dev/null || unable "bringing up SLURM needs Debian's apt-get"

down=$(realpath "$(dirname "${BASH_SOURCE[0]}")/down.sh")
folder=$(realpath -m "$1")
host=$(hostname -s)
getent hosts "$host" >/dev/null || unable "this machine's name, $host, is not in /etc/hosts"

# Snakemake's job steps forget SLURM_CONF, so the configuration has to be where SLURM looks first.
# A link there whose cluster has gone is what a killed test leaves behind.
conf=/etc/slurm/slurm.conf
dbd=/etc/slurm/slurmdbd.conf
if [ -e $conf ] || [ -L $conf ]; then
    [ -L $conf ] && [[ $(readlink $conf) == */vibrissa-slurm.conf ]] ||
        unable "$conf is there: this machine belongs to a SLURM already"
    old=$(dirname "$(readlink $conf)")
    if [ -n "$(grep -lzxF "VIBRISSA_SLURM=$old" /proc/[0-9]*/environ 2>/dev/null)" ]; then
        echo "another test cluster is up; if nobody uses it: $down $old" >&2
        exit 1
    fi
    rm -f $conf $dbd
fi
[ ! -e $dbd ] || unable "$dbd is there: this machine keeps the accounts of a SLURM already"

mkdir -p "$folder"/{state,log,n1,n2}
chmod 755 "$folder"
packages=(mariadb-server munge procps slurm-client slurmctld slurmd slurmdbd)
if ! dpkg-query -W -f '${Status}\n' "${packages[@]}" 2>/dev/null |
    awk '/^install ok installed$/ { n++ } END { exit n != '${#packages[@]}' }'; then
    echo "installing ${packages[*]} ..."
    policy=/usr/sbin/policy-rc.d # asked by Debian's packages before they start their services
    if [ ! -e $policy ]; then
        printf '#!/bin/sh\nexit 101\n' >$policy
        chmod +x $policy
        trap 'rm -f $policy' EXIT
    fi
    export DEBIAN_FRONTEND=noninteractive
    apt=(apt-get -qq -o DPkg::Lock::Timeout=120)
    { "${apt[@]}" update && "${apt[@]}" install -y --no-install-recommends "${packages[@]}"; } \
        >"$folder/log/apt.log" 2>&1 || {
        tail -n 5 "$folder/log/apt.log" >&2
        echo "SLURM's packages could not be installed" >&2
        exit 1
    }
fi

# down.sh knows by this what belongs to the cluster: children inherit it.
export VIBRISSA_SLURM=$folder

memory=$(awk '/^MemTotal/ { print int($2 / 1024 / 3) }' /proc/meminfo) # of each node
cat >"$folder/vibrissa-slurm.conf" <<CONF
ClusterName=vibrissa
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=26817
SlurmUser=root
AuthType=auth/munge
# A job of a lost node is started again after cred_expire.
AuthInfo=socket=$folder/munge.socket,cred_expire=5
CredType=cred/munge
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/%n
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/%n/slurmd.pid
SlurmctldLogFile=$folder/log/slurmctld.log
SlurmdLogFile=$folder/log/%n.log
MpiDefault=none
MailProg=/bin/true
# What needs no cgroups and no rights over the machine.
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
TaskProlog=$folder/mark
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
SlurmdParameters=config_overrides
# A test should not wait for a scheduler that is tuned for thousands of users.
SchedulerParameters=batch_sched_delay=0,sched_min_interval=200000,bf_interval=1
KillWait=2
AccountingStorageType=accounting_storage/slurmdbd
AccountingStorageHost=localhost
AccountingStoragePort=26819
AccountingStoragePass=$folder/munge.socket
# Without an account that the database knows, no job is taken.
AccountingStorageEnforce=associations
NodeName=n1 NodeHostname=$host NodeAddr=127.0.0.1 Port=26821 CPUs=2 RealMemory=$memory
NodeName=n2 NodeHostname=$host NodeAddr=127.0.0.1 Port=26822 CPUs=2 RealMemory=$memory
PartitionName=main Nodes=n1,n2 Default=YES State=UP
# The one refuses long jobs, the other starts none.
PartitionName=short Nodes=n1,n2 MaxTime=1 State=UP
PartitionName=closed Nodes=n1,n2 State=DOWN
CONF
# A job's environment is the submitter's: without this, down.sh would not know it. A test that has to
# meet jobs at work holds them with a file.
cat >"$folder/mark" <<MARK
#!/bin/sh
echo export VIBRISSA_SLURM=$folder
while [ -e $folder/hold ]; do sleep 0.2; done
MARK
chmod +x "$folder/mark"
mkdir -p /etc/slurm
ln -s "$folder/vibrissa-slurm.conf" $conf

wait_until() { # SECONDS COMMAND...
    local end=$((SECONDS + $1))
    shift
    until "$@" >/dev/null 2>&1; do
        [ $SECONDS -lt $end ] || return 1
        sleep 0.1
    done
}

# A munge of its own: the machine's key and daemon are left alone.
(umask 077 && head -c 1024 /dev/urandom >"$folder/munge.key")
munged --key-file="$folder/munge.key" --socket="$folder/munge.socket" \
    --pid-file="$folder/munged.pid" --log-file="$folder/log/munged.log" \
    --seed-file="$folder/munge.seed" || failed "munged did not start"

mkdir -p "$folder/mysql"
chown mysql: "$folder/mysql"
export MYSQL_UNIX_PORT=$folder/mysql/socket # where slurmdbd looks, too
mariadb-install-db --no-defaults --user=mysql --datadir="$folder/mysql" \
    >"$folder/log/mariadb.log" 2>&1 || failed "no database; see $folder/log/mariadb.log"
setsid mariadbd --no-defaults --user=mysql --datadir="$folder/mysql" --skip-networking \
    --socket="$MYSQL_UNIX_PORT" </dev/null >>"$folder/log/mariadb.log" 2>&1 &
wait_until 30 mariadb --no-defaults -e "select 1" ||
    failed "no database; see $folder/log/mariadb.log"
cat >"$folder/slurmdbd.conf" <<CONF
DbdHost=localhost
DbdPort=26819
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$folder/munge.socket
StorageType=accounting_storage/mysql
StorageUser=root
StorageLoc=vibrissa
PidFile=$folder/slurmdbd.pid
LogFile=$folder/log/slurmdbd.log
CONF
chmod 600 "$folder/slurmdbd.conf"
ln -sf "$folder/slurmdbd.conf" $dbd
slurmdbd || failed "slurmdbd did not start; see $folder/log/slurmdbd.log"
wait_until 30 sacctmgr -n list cluster || failed "no slurmdbd; see $folder/log/slurmdbd.log"
sacctmgr -i -Q add cluster vibrissa >/dev/null 2>&1 || true # the controller may have been faster
sacctmgr -i -Q add account whiskers >/dev/null || failed "no account in slurmdbd"
sacctmgr -i -Q add user root account=whiskers >/dev/null || failed "no user in slurmdbd"

slurmctld || failed "slurmctld did not start; see $folder/log/slurmctld.log"
for node in n1 n2; do
    slurmd -N $node || failed "slurmd did not start; see $folder/log/$node.log"
done
both_idle() { [ "$(sinfo -h -N -p main -t idle -o %N | wc -l)" = 2 ]; }
wait_until 30 both_idle || failed "the nodes do not come up; see $folder/log"
[ "$(srun -n1 -t1 echo works)" = works ] || failed "no job runs; see $folder/log"
echo "SLURM is up: two nodes of two CPUs, in $folder"
