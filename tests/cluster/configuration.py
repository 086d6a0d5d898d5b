"""The files of a cluster's computers: names, users, Slurm, ssh, shells."""
import dataclasses
import pathlib

LOGIN = "login"
CLUSTER = pathlib.Path("/run/cluster")  # All computers share this folder, and /home.
WIRE = CLUSTER / "wire"  # The socket of the switch, if it is wire.cpp.
MACHINE_ETC = pathlib.Path("/run/machine/etc")  # The machine's own /etc, on each computer.
SSH = pathlib.Path("/etc/ssh")
HOST_KEY = "ssh_host_ed25519_key"
USER, OTHER_USER = "ada", "eve"
MOST_COMPUTERS = 200


@dataclasses.dataclass
class Options:
    """What cluster.Cluster() takes; its documentation has the meaning of each field."""
    computers: int = 3
    slots: int = 64
    private_tmp: bool = True
    tmp_mb: int = 0
    hosts_as_debian: bool = False
    noisy_bashrc: bool = False
    slurm_conf: str = ""
    user_id: int = 0
    shared: tuple = ()
    writable: tuple = ()
    wire: str = ""
    seed: int = 1

    def names(self):
        return [f"n{number}" for number in range(1, self.computers + 1)]


def address(name):
    return "10.77.0." + ("1" if name == LOGIN else str(10 + int(name[1:])))


def home(user):
    return pathlib.Path("/home") / user


def users(options):
    """User ids by name: who works on the cluster. Root's home is on the cluster, too."""
    return {"root": 0, USER: options.user_id, OTHER_USER: options.user_id + 1}


def hosts(options, name):
    """/etc/hosts. Debian's installer gives a computer's own name the address 127.0.1.1."""
    lines = ["127.0.0.1 localhost", "::1 localhost ip6-localhost ip6-loopback"]
    for other in [LOGIN, *options.names()]:
        is_own = other == name and options.hosts_as_debian
        lines.append(f"{'127.0.1.1' if is_own else address(other)} {other}")
    return "\n".join(lines) + "\n"


def _accounts(options, machine, people):
    """A passwd or group file: the machine's accounts of daemons, and the cluster's own."""
    numbers = users(options).values()
    kept = [line for line in machine.splitlines()
            if line.count(":") >= 3 and int(line.split(":")[2]) not in [*numbers, 0]
            and int(line.split(":")[2]) < 1000]
    return "\n".join([*kept, *people]) + "\n"


def _passwd(options, machine):
    return _accounts(options, machine, [f"{name}:x:{number}:{number}::{home(name)}:/bin/bash"
                                        for name, number in users(options).items()])


def _group(options, machine):
    return _accounts(options, machine, [f"{name}:x:{number}:"
                                        for name, number in users(options).items()])


def _shadow(options):
    """Passwords are not used, but an account that sshd must not regard as locked needs a line."""
    return "".join(f"{name}:*:19000:0:99999:7:::\n" for name in users(options))


def _slurm(options):
    nodes = "".join(
        f"NodeName={name} NodeAddr={address(name)} CPUs={options.slots} RealMemory=1000\n"
        for name in options.names())
    return f"""ClusterName=cluster
SlurmctldHost={LOGIN}({address(LOGIN)})
SlurmUser=root
AuthType=auth/munge
StateSaveLocation=/var/spool/slurmctld
SlurmdSpoolDir=/var/spool/slurmd
SlurmctldPidFile=/run/slurmctld.pid
SlurmdPidFile=/run/slurmd.pid
SlurmctldDebug=verbose
MailProg=/bin/true
MpiDefault=none
# These three do without control groups, which a container does not let us make.
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
# A computer may have more slots than this machine has processors.
SlurmdParameters=config_overrides
SchedulerParameters=sched_min_interval=0
ReturnToService=2
SlurmdTimeout=30
KillWait=2
TCPTimeout=10
InactiveLimit=0
{nodes}PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP OverSubscribe=YES
{options.slurm_conf}
"""


_SSHD = """UsePAM no
PermitRootLogin yes
PasswordAuthentication no
PrintMotd no
PidFile none
"""


def etc(options, name, munge_key, host_key):
    """The computer's own files below /etc: {path: (mode, owner, bytes)}."""
    public = host_key.public
    known = ",".join([LOGIN, *options.names(), "10.77.0.*"])
    texts = {
        "hostname": name + "\n",
        "hosts": hosts(options, name),
        "nsswitch.conf": "passwd: files\ngroup: files\nshadow: files\nhosts: files\n",
        "passwd": _passwd(options, (MACHINE_ETC / "passwd").read_text()),
        "group": _group(options, (MACHINE_ETC / "group").read_text()),
        "slurm/slurm.conf": _slurm(options),
        # Without a version, slurmd looks for mounted control groups and ends without them.
        "slurm/cgroup.conf": "CgroupPlugin=cgroup/v1\n",
        "ssh/sshd_config": _SSHD,
        "ssh/ssh_config": "Host *\n    SendEnv LANG LC_*\n",
        "ssh/ssh_known_hosts": f"{known} {public}\n",
        f"ssh/{HOST_KEY}.pub": public + "\n",
    }
    files = {path: (0o644, "root", text.encode()) for path, text in texts.items()}
    files["shadow"] = (0o640, "root", _shadow(options).encode())
    files[f"ssh/{HOST_KEY}"] = (0o600, "root", host_key.private)
    files["munge/munge.key"] = (0o400, "munge", munge_key)
    return files


def bashrc(options):
    """bash reads .bashrc for each command that comes by ssh, too."""
    if not options.noisy_bashrc:
        return ""
    return 'echo "Welcome to $HOSTNAME"\necho "conda: no such environment" >&2\n'
