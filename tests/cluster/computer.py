#!/usr/bin/env python3
"""The first process of each computer of a cluster. Only cluster.py starts it.

usage: computer.py CONTROL OPTIONS    CONTROL is the number of an open socket, OPTIONS are JSON
"""
import collections
import fcntl
import json
import os
import pathlib
import secrets
import select
import shutil
import signal
import socket
import struct
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import configuration as conf  # noqa: E402
import kernel  # noqa: E402
from configuration import CLUSTER, HOST_KEY, LOGIN, MACHINE_ETC, Options, SSH  # noqa: E402

LIMIT_S = 30
DEVICES = {"null": (1, 3), "zero": (1, 5), "full": (1, 7), "random": (1, 8), "urandom": (1, 9),
           "tty": (5, 0), "net/tun": (10, 200)}
LOG = CLUSTER / "log"
TUNSETIFF, IFF_TAP, IFF_NO_PI, IFF_VNET_HDR = 0x400454ca, 0x0002, 0x1000, 0x4000
Key = collections.namedtuple("Key", "private public")


def run(argv, **more):
    """Runs a short command. Its output is in the error."""
    done = subprocess.run(argv, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          timeout=LIMIT_S, check=False, **more)
    if done.returncode:
        raise RuntimeError(f"{' '.join(map(str, argv))} ended with code {done.returncode}: "
                           f"{done.stdout.strip()}")


def ip(*commands):
    run(["ip", "-batch", "-"], input="\n".join(commands) + "\n")


def own_folder(path, mode=0o755, size_mb=0):
    size = f",size={size_mb}m" if size_mb else ""
    kernel.mount("cluster", path, "tmpfs", kernel.MS_NOSUID, f"mode={mode:o}{size}")


def keep(paths, places):
    """Descriptors of those paths that `places` will cover, to uncover() them."""
    return {path: os.open(path, os.O_PATH) for path in map(pathlib.Path, paths)
            if any(place in [path, *path.parents] for place in map(pathlib.Path, places))}


def uncover(kept):
    for path, descriptor in kept.items():
        path.mkdir(parents=True, exist_ok=True)
        kernel.bind(f"/proc/self/fd/{descriptor}", path)
        os.close(descriptor)


class Computer:
    """A computer in namespaces of its own: its places, its network and its daemons."""

    def __init__(self, name, options, control, keys):
        self.name, self.options, self.control, self.keys = name, options, control, keys
        self.daemons = {}  # By process id.
        self.started = []  # subprocess itself would wait for those that are forgotten.

    def report(self, **event):
        self.control.send(json.dumps({"computer": self.name, **event}).encode())

    def mount_own_places(self, own):
        options = self.options
        kept = keep([CLUSTER, MACHINE_ETC, *options.shared], own)
        for place in own:
            is_shared_by_users = place in ("/tmp", "/var/tmp", "/dev/shm")
            own_folder(place, 0o1777 if is_shared_by_users else 0o755,
                       options.tmp_mb if place == "/tmp" else 0)
            if place == "/dev":
                self.make_devices()
        uncover(kept)
        kernel.mount("proc", "/proc", "proc", kernel.MS_NOSUID | kernel.MS_NODEV)
        kernel.mount("sysfs", "/sys", "sysfs", kernel.MS_RDONLY)  # Of this network.
        self.fill_etc()
        for path in ("/run/sshd", "/run/lock", "/var/spool/slurmctld", "/var/spool/slurmd"):
            os.makedirs(path)
        for path in ("/run/munge", "/var/log/munge"):
            os.makedirs(path)
            shutil.chown(path, "munge", "munge")

    def make_devices(self):
        for folder in ("net", "pts", "shm"):
            os.mkdir(f"/dev/{folder}")
        old = os.umask(0)
        for name, numbers in DEVICES.items():
            os.mknod(f"/dev/{name}", 0o666 | 0o020000, os.makedev(*numbers))
        os.umask(old)
        kernel.mount("devpts", "/dev/pts", "devpts", kernel.MS_NOSUID,
                     "newinstance,ptmxmode=0666,mode=0620")
        for name, target in {"ptmx": "pts/ptmx", "fd": "/proc/self/fd", "stdin": "fd/0",
                             "stdout": "fd/1", "stderr": "fd/2"}.items():
            os.symlink(target, f"/dev/{name}")

    def fill_etc(self):
        """Own files, and links to the machine's for the rest."""
        files = conf.etc(self.options, self.name, *self.keys)
        own = {path.split("/")[0] for path in files}
        for entry in os.scandir(MACHINE_ETC):
            if entry.is_symlink() and entry.name not in own:
                os.symlink(os.readlink(entry.path), f"/etc/{entry.name}")
            elif entry.name not in own:
                os.symlink(entry.path, f"/etc/{entry.name}")
        for name, (mode, owner, data) in files.items():
            path = pathlib.Path("/etc") / name
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(data)
            path.chmod(mode)
        for name, (_, owner, _) in files.items():  # Now that there is a passwd file.
            shutil.chown(pathlib.Path("/etc") / name, owner)

    def log(self, daemon):
        return open(LOG / f"{self.name}.{daemon}.log", "ab")  # noqa: SIM115: a child's

    def start(self, daemon, argv, **more):
        with self.log(daemon) as log:
            process = subprocess.Popen(argv, stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                                       **more)
        self.daemons[process.pid] = daemon
        self.started.append(process)
        return process

    def connect_to_wire(self):
        """Makes eth0, and hands its other end to the switch."""
        tap = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
        fcntl.ioctl(tap, TUNSETIFF,
                    struct.pack("16sH22x", b"eth0", IFF_TAP | IFF_NO_PI | IFF_VNET_HDR))
        with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as wire:
            wire.settimeout(LIMIT_S)
            wire.connect(str(conf.WIRE))
            socket.send_fds(wire, [f"add {self.name}".encode()], [tap])
            if wire.recv(256) != b"ok":
                raise RuntimeError(f"{self.options.wire} did not connect the computer")
        os.close(tap)

    def start_munge(self):
        """The command ends when the daemon answers."""
        with self.log("munged") as log:
            shutil.chown(log.name, "munge", "munge")
            os.chmod(log.name, 0o640)
        run(["/usr/sbin/munged", f"--log-file={log.name}", "--seed-file=/run/munge/munged.seed",
             "--num-threads=2"], user="munge", group="munge", extra_groups=[])
        pid = int(pathlib.Path("/run/munge/munged.pid").read_text())
        self.daemons[pid] = "munged"

    def start_sshd(self):
        """Debian's sshd notifies systemd, or this, when it listens."""
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as notified:
            notified.bind("/run/notify")
            daemon = self.start("sshd", ["/usr/sbin/sshd", "-D", "-e"],
                                env={**os.environ, "NOTIFY_SOCKET": "/run/notify"})
            end = os.pidfd_open(daemon.pid)
            ready, _, _ = select.select([notified, end], [], [], LIMIT_S)
            os.close(end)
            os.unlink("/run/notify")
            if notified not in ready:
                raise RuntimeError("sshd has ended" if ready else
                                   f"sshd did not listen within {LIMIT_S} s")

    def start_daemons(self):
        self.start_munge()
        self.start("slurmd", ["/usr/sbin/slurmd", "-D", "-N", self.name])
        self.start_sshd()

    def reap(self, flags=0):
        """Waits for a child. Reports a daemon that has ended. False if no child has ended."""
        try:
            pid, status = os.waitpid(-1, flags)
        except ChildProcessError:
            return False
        if pid in self.daemons:
            code = os.waitstatus_to_exitcode(status)
            self.report(ended=self.daemons.pop(pid), code=code)
        return pid != 0

    def serve(self):
        """As the first process does: waits for those that have lost their parent."""
        while self.reap():
            pass
        signal.pause()  # All daemons have ended.

    def live(self, plug_in):
        """What this computer does from power on. plug_in() returns when the cable is there."""
        try:
            socket.sethostname(self.name)
            self.mount_own_places(own_places(self.options))
            plug_in()
            ip("link set lo up", f"addr add {conf.address(self.name)}/24 dev eth0",
               "link set eth0 up", f"route add default via {conf.address(LOGIN)}")
            self.start_daemons()
            self.report(up=True)
        except (OSError, RuntimeError, subprocess.SubprocessError) as error:
            self.report(failed=str(error))
        try:
            self.serve()
        finally:
            os._exit(0)  # Not back to what has forked this process.


def own_places(options):
    """The folders that each computer has for itself."""
    return ["/dev", "/dev/shm", "/run", "/etc", "/var/log", "/var/spool", "/var/tmp",
            *(["/tmp"] if options.private_tmp else [])]


class Login(Computer):
    """The computer on which users log in. It has the switch and starts the other computers."""

    def __init__(self, options, control):
        super().__init__(LOGIN, options, control, None)
        signal.signal(signal.SIGCHLD, lambda *_: None)
        self.child_ended, wakeup = socket.socketpair()
        for end in (self.child_ended, wakeup):
            end.setblocking(False)
        self.wakeup = wakeup
        signal.set_wakeup_fd(wakeup.fileno())

    def mount_cluster(self):
        """Makes the machine's files read-only, and lays the cluster's own above them."""
        kernel.mount("none", "/", flags=kernel.MS_REC | kernel.MS_PRIVATE)
        kernel.set_read_only("/", True)
        machine_etc = os.open("/etc", os.O_PATH)
        writable = keep(self.options.writable, ["/"])
        kept = keep(self.options.shared, ["/home", "/tmp", "/run"])
        own_folder("/run")
        own_folder("/home")
        if not self.options.private_tmp:
            own_folder("/tmp", 0o1777, self.options.tmp_mb)
        uncover(kept)
        for path, descriptor in writable.items():
            uncover({path: descriptor})
            kernel.set_read_only(path, False)
        MACHINE_ETC.mkdir(parents=True)
        kernel.bind(f"/proc/self/fd/{machine_etc}", MACHINE_ETC)
        os.close(machine_etc)
        CLUSTER.mkdir()
        own_folder(CLUSTER)
        LOG.mkdir()

    def make_keys(self):
        """The host key, and a home with a key for each user. All computers get them."""
        people = conf.users(self.options)
        files = {user: conf.home(user) / ".ssh/id_ed25519" for user in people}
        for path in files.values():
            path.parent.mkdir(parents=True, mode=0o700)
        files["host"] = CLUSTER / HOST_KEY
        makers = [subprocess.Popen(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-C", name,
                                    "-f", path]) for name, path in files.items()]
        if any(maker.wait(LIMIT_S) for maker in makers):
            raise RuntimeError("ssh-keygen failed")
        for user, number in people.items():
            path = files[user]
            shutil.copy(path.with_suffix(".pub"), path.parent / "authorized_keys")
            (conf.home(user) / ".bashrc").write_text(conf.bashrc(self.options))
            for each in [conf.home(user), *conf.home(user).rglob("*")]:
                os.chown(each, number, number)
        host = files["host"]
        public = " ".join(host.with_suffix(".pub").read_text().split()[:2])
        self.keys = secrets.token_bytes(128), Key(host.read_bytes(), public)

    def start_daemons(self):
        self.start_munge()
        self.start("slurmctld", ["/usr/sbin/slurmctld", "-D"])
        for name in self.options.names():
            self.boot(name)
        self.start_sshd()

    def lay_cable(self):
        if self.options.wire:
            with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as listening:
                listening.bind(str(conf.WIRE))
                listening.listen()
                descriptor = listening.fileno()
                self.start("wire", [self.options.wire, str(descriptor), str(self.options.seed)],
                           pass_fds=[descriptor])
            self.connect_to_wire()
            return
        # The switch answers no question for an address: it would answer beside eth0.
        ip("link add br0 type bridge", "link set br0 arp off up",
           "link add vlogin type veth peer name eth0", "link set vlogin master br0 up")

    def boot(self, name):
        """Starts a computer and plugs its cable in."""
        number_out, number_in = os.pipe()
        go_out, go_in = os.pipe()
        between = os.fork()
        if between == 0:
            os.close(go_in)
            kernel.unshare(kernel.OF_A_COMPUTER)
            first = os.fork()
            if first:
                os.write(number_in, str(first).encode())
                os._exit(0)
            for descriptor in (number_out, number_in):
                os.close(descriptor)
            signal.set_wakeup_fd(-1)
            computer = Computer(name, self.options, self.control, self.keys)
            computer.live(computer.connect_to_wire if self.options.wire else
                          lambda: os.read(go_out, 1))
        os.close(number_in)
        first = int(os.read(number_out, 32))
        if not self.options.wire:
            self.connect_to_bridge(name, first)
        for descriptor in (number_out, go_out, go_in):
            os.close(descriptor)

    def connect_to_bridge(self, name, first):
        cable = f"v{name}"
        if os.path.exists(f"/sys/class/net/{cable}"):
            ip(f"link del {cable}")
        ip(f"link add {cable} type veth peer name eth0 netns {first}",
           f"link set {cable} master br0 up")

    def serve(self):
        """Boots computers on demand, until the socket closes: then the whole cluster ends."""
        while True:
            ready, _, _ = select.select([self.control, self.child_ended], [], [])
            if self.child_ended in ready:
                self.child_ended.recv(4096)
                while self.reap(os.WNOHANG):
                    pass
            if self.control in ready:
                request = self.control.recv(4096)
                if not request:
                    return
                name = json.loads(request)["boot"]
                try:
                    self.boot(name)
                except (OSError, RuntimeError) as error:
                    self.report(failed=f"{name} did not start: {error}")


def main():
    os.umask(0o022)
    control = socket.socket(fileno=int(sys.argv[1]))
    options = Options(**json.loads(sys.argv[2]))
    kernel.unshare(kernel.OF_A_COMPUTER)
    first = os.fork()
    if first == 0:
        login = Login(options, control)
        login.mount_cluster()
        login.make_keys()
        login.live(login.lay_cable)
    control.close()
    sys.exit(os.waitstatus_to_exitcode(os.waitpid(first, 0)[1]))


if __name__ == "__main__":
    main()
