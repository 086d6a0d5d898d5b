#!/usr/bin/env python3
"""The harness of tests on a cluster: three computers, what works on them, and what ends them.

usage: test_cluster.py WIRE [unittest's arguments]    WIRE is the program of wire.cpp

SKIPPED without root, without the packages of `host/setup.sh cluster`, or without namespaces.
"""
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import contents  # noqa: E402
from cluster import Cluster, ClusterError, OTHER_USER, USER, missing  # noqa: E402

NAMES = ["n1", "n2", "n3"]
LIMIT_S = 60
NAMESPACES = ("mnt", "net", "pid", "uts", "ipc")
# Connects to a port, and says whether that worked within a second.
CONNECT = """
import socket, sys
try:
    socket.create_connection((sys.argv[1], int(sys.argv[2])), 1).close()
    print("connected")
except OSError as error:
    print(error)
"""
# Prints a line, then waits until the connection or the standard input ends.
LISTEN = """
import socket
with socket.create_server(("", 7000)) as server:
    print("listening", flush=True)
    peer, _ = server.accept()
    print("accepted", flush=True)
    print(len(peer.makefile("rb").read()), flush=True)
"""
SEND = """
import socket, sys
with socket.create_connection((sys.argv[1], 7000)) as peer:
    peer.sendall(bytes(int(sys.argv[2])))
"""


def python(text, *arguments):
    return ["/usr/bin/python3", "-c", text, *map(str, arguments)]


def namespaces():
    """All namespaces of running processes."""
    found = set()
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            found |= {os.readlink(f"/proc/{pid}/ns/{kind}") for kind in NAMESPACES}
        except OSError:
            pass  # It has ended meanwhile.
    return found


def traces():
    """What a cluster could leave on this machine."""
    return {"mounts": pathlib.Path("/proc/self/mountinfo").read_text(),
            "networks": sorted(os.listdir("/sys/class/net")),
            "descriptors": sorted(os.listdir("/proc/self/fd")),
            "files": sorted(name for place in ("/tmp", "/var/tmp", "/dev/shm", "/run", "/etc",
                                               "/var/spool", "/var/log", "/home", "/root")
                            for name in os.listdir(place)
                            if any(word in name for word in ("cluster", "slurm", "munge", "ssh")))}


class Network:
    """Tests that share a cluster, and leave it as they found it."""
    cluster = None

    def tearDown(self):
        try:
            self.cluster.wait_until_idle(10)
        finally:
            for one in self.cluster.processes():
                os.kill(one.pid, signal.SIGKILL)

    def can_connect(self, computer, other):
        return self.cluster.on(computer, python(CONNECT, other, 22)).stdout.strip()

    def test_a_cut_cable_is_silent_both_ways(self):
        self.assertEqual(self.can_connect("login", "n2"), "connected")
        listener = self.cluster.popen("n2", python(LISTEN), stdout=subprocess.PIPE, text=True)
        self.assertEqual(listener.stdout.readline(), "listening\n")
        sender = self.cluster.popen("n1", python(
            "import socket; peer = socket.create_connection(('n2', 7000)); input(); "
            "peer.sendall(b'12345')"), stdin=subprocess.PIPE, text=True)
        self.assertEqual(listener.stdout.readline(), "accepted\n")
        self.cluster.cut("n2")
        self.assertNotEqual(self.can_connect("login", "n2"), "connected")
        self.assertNotEqual(self.can_connect("n2", "n1"), "connected")
        self.assertEqual(self.can_connect("n1", "n3"), "connected")
        sender.communicate("now\n", LIMIT_S)  # Neither end sees an error; the packets wait.
        self.assertEqual(sender.returncode, 0)
        self.assertIsNone(listener.poll())
        self.cluster.join("n2")
        self.assertEqual(listener.communicate(timeout=LIMIT_S)[0], "5\n")
        self.assertEqual(self.can_connect("n2", "n1"), "connected")

    def test_a_computer_without_power_is_seen_and_comes_back(self):
        sleeper = self.cluster.popen("n3", ["sleep", "1000"])
        listener = self.cluster.popen("n2", python(LISTEN), stdout=subprocess.PIPE, text=True)
        self.assertEqual(listener.stdout.readline(), "listening\n")
        sender = self.cluster.popen("n3", python(
            "import socket; peer = socket.create_connection(('n2', 7000)); input()"),
            stdin=subprocess.PIPE)
        self.assertEqual(listener.stdout.readline(), "accepted\n")
        self.cluster.off("n3")
        for program in (sleeper, sender):
            self.assertEqual(program.wait(LIMIT_S), -signal.SIGKILL)
            program.end()
        self.assertNotEqual(self.can_connect("login", "n3"), "connected")
        with self.assertRaisesRegex(ClusterError, "n3 is not on"):
            self.cluster.on("n3", ["true"])
        self.assertIn("slurmd", self.cluster.log("n3", "slurmd"))
        self.assertIsNone(listener.poll(), "a computer without power ends no connection")
        listener.end()
        self.cluster.boot("n3")
        done = self.cluster.login(["srun", "-N3", "-n3", "hostname"])
        self.assertEqual(sorted(done.stdout.split()), NAMES)

    def test_a_slow_cable_limits_the_rate(self):
        megabytes, mbit = 1, 8
        self.cluster.link("n2", rate_mbit=mbit)
        listener = self.cluster.popen("n2", python(LISTEN), stdout=subprocess.PIPE, text=True)
        self.assertEqual(listener.stdout.readline(), "listening\n")
        begin = time.monotonic()
        self.cluster.on("n1", python(SEND, "n2", megabytes << 20))
        self.assertEqual(listener.communicate(timeout=LIMIT_S)[0].split()[-1],
                         str(megabytes << 20))
        # Never faster than the cable, but for what a queue of 256 KiB takes at once.
        self.assertGreater(time.monotonic() - begin, megabytes * 8 / mbit * 0.7)
        self.cluster.link("n2", rate_mbit=0)


class OneCluster(Network, unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cluster = cls.enterClassContext(Cluster(computers=3))

    def test_slurm_starts_a_task_on_each_computer(self):
        done = self.cluster.login(["srun", "-N3", "-n3", "hostname"])
        self.assertEqual(sorted(done.stdout.split()), NAMES)

    def test_ssh_reaches_each_computer_without_a_password(self):
        for user in ("root", USER, OTHER_USER):
            for name in NAMES:
                done = self.cluster.login(["ssh", "-o", "BatchMode=yes", name, "hostname; id -un"],
                                          user=user)
                self.assertEqual(done.stdout.split(), [name, user])
                self.assertEqual(done.stderr, "")
        done = self.cluster.on("n1", ["ssh", "-o", "BatchMode=yes", "n3", "hostname"])
        self.assertEqual(done.stdout.split(), ["n3"])

    def test_mpirun_starts_a_process_on_each_computer(self):
        over_ssh = ["mpirun", "-H", "n1,n2,n3", "--map-by", "ppr:1:node", "hostname"]
        in_slurm = ["salloc", "-Q", "-N3", "-n3", "mpirun", "--map-by", "ppr:1:node", "hostname"]
        for command in (over_ssh, in_slurm):
            done = self.cluster.login(command)
            self.assertEqual(sorted(done.stdout.split()), NAMES, done.stderr)

    def test_a_credential_opens_on_another_computer_for_its_user_alone(self):
        credential = self.cluster.on("n1", ["munge", "-s", "secret", "-u", USER]).stdout
        refused = self.cluster.on("n2", ["unmunge"], input=credential, user=OTHER_USER,
                                  check=False)
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("Unauthorized credential", refused.stdout + refused.stderr)
        opened = self.cluster.on("n3", ["unmunge"], input=credential)
        self.assertIn("secret", opened.stdout)

    def test_computers_share_homes_and_nothing_else_that_can_be_written(self):
        before = self.cluster.files()
        for path in ("note", "/tmp/note", "/var/tmp/note", "/dev/shm/note"):
            self.cluster.on("n1", ["touch", path])
            seen = self.cluster.on("n2", ["test", "-e", path], check=False).returncode == 0
            self.assertEqual(seen, path == "note", path)
        new = set(self.cluster.files()) - set(before)
        self.assertEqual(new, {"n1:/tmp/note", "n1:/var/tmp/note", "n1:/dev/shm/note",
                               f"login:/home/{USER}/note"})
        self.cluster.on("n1", ["rm", "note", "/tmp/note", "/var/tmp/note", "/dev/shm/note"])
        self.assertEqual(self.cluster.files(), before)

    def test_the_machine_cannot_be_changed(self):
        here = pathlib.Path(__file__).resolve()
        for path in (here.parent / "new", "/usr/new", "/var/lib/new"):
            done = self.cluster.on("n1", ["touch", path], user="root", check=False)
            self.assertIn("Read-only file system", done.stderr, path)
        self.assertEqual(self.cluster.on("n1", ["cat", here]).stdout, here.read_text())

    def test_processes_are_those_of_the_user(self):
        child = tuple(python("import signal; print(flush=True); signal.pause()"))
        with self.cluster.popen("n2", ["bash", "-c", '"$@" & wait', "bash", *child],
                                stdout=subprocess.PIPE) as program:
            program.stdout.readline()
            found = self.cluster.processes()
            self.assertEqual({one.computer for one in found}, {"n2"})
            self.assertIn(child, [one.argv for one in found])
            program.kill()
            self.assertEqual(program.wait(LIMIT_S), -signal.SIGKILL)
            with self.assertRaisesRegex(ClusterError, "n2: /usr/bin/python3 -c"):
                self.cluster.wait_until_idle(0)
            for one in self.cluster.processes():
                os.kill(one.pid, signal.SIGTERM)
            self.cluster.wait_until_idle()

    def test_signals_reach_the_program(self):
        command = "trap 'echo term; exit 3' TERM; echo ready; read -r line"
        with self.cluster.popen("n1", ["bash", "-c", command], stdin=subprocess.PIPE,
                                stdout=subprocess.PIPE, text=True) as program:
            self.assertEqual(program.stdout.readline(), "ready\n")
            program.terminate()
            self.assertEqual(program.stdout.readline(), "term\n")
            self.assertEqual(program.wait(LIMIT_S), 3)

    def test_errors_have_computer_command_and_output(self):
        with self.assertRaisesRegex(ClusterError, r"(?s)n1: ls /nothing: code 2.*No such file"):
            self.cluster.on("n1", ["ls", "/nothing"])
        with self.assertRaisesRegex(ClusterError, r"(?s)n2: .*: not done after 0.5 s.*begun"):
            self.cluster.on("n2", ["bash", "-c", "echo begun; exec sleep 1000"], timeout=0.5)
        with self.assertRaisesRegex(ClusterError, "n4 is not on; on are login n1 n2 n3"):
            self.cluster.on("n4", ["true"])

    def test_without_a_wire_there_is_no_delay(self):
        with self.assertRaisesRegex(ClusterError, "no delay, jitter and loss; give Cluster"):
            self.cluster.link(delay_ms=1)


class OneClusterOnAWire(Network, unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cluster = cls.enterClassContext(Cluster(computers=3, wire=WIRE))

    def test_a_packet_has_the_delay_of_both_cables(self):
        delay_ms = 20
        self.cluster.link(delay_ms=delay_ms)
        done = self.cluster.on("n1", python(
            "import socket, time; begin = time.monotonic(); "
            "socket.create_connection(('n2', 22)).recv(1); print(time.monotonic() - begin)"))
        self.cluster.link()
        # The connection and its first byte take two ways there and two back.
        self.assertGreater(float(done.stdout), 4 * 2 * delay_ms / 1000)

    def test_where_all_packets_are_lost_nothing_connects(self):
        self.cluster.link("n2", loss_percent=100)
        self.assertNotEqual(self.can_connect("n1", "n2"), "connected")
        self.assertEqual(self.can_connect("n1", "n3"), "connected")
        self.cluster.link("n2")
        self.assertEqual(self.can_connect("n1", "n2"), "connected")


class Variants(unittest.TestCase):
    def test_own_names_a_noisy_shell_and_one_small_tmp(self):
        with Cluster(computers=2, hosts_as_debian=True, noisy_bashrc=True, private_tmp=False,
                     tmp_mb=1, slots=2) as cluster:
            for name, other in (("n1", "n2"), ("n2", "n1")):
                find = python("import socket, sys; print(*map(socket.gethostbyname, sys.argv[1:]))",
                              name, other)
                addresses = cluster.on(name, find).stdout.split()
                self.assertEqual(addresses[0], "127.0.1.1")
                self.assertRegex(addresses[1], r"10\.77\.0\.1[12]")
            done = cluster.login(["srun", "-N2", "-n4", "hostname"])
            self.assertEqual(sorted(done.stdout.split()), ["n1", "n1", "n2", "n2"])
            done = cluster.login(["ssh", "n2", "echo mine"])
            self.assertEqual(done.stdout.splitlines(), ["Welcome to n2", "mine"])
            self.assertEqual(done.stderr.splitlines(), ["conda: no such environment"])
            full = cluster.on("n1", ["dd", "if=/dev/zero", "of=/tmp/full", "bs=1M", "count=2"],
                              check=False)
            self.assertIn("No space left on device", full.stderr)
            cluster.on("n2", ["test", "-e", "/tmp/full"])

    def test_shared_folders_and_those_that_may_be_written(self):
        with tempfile.TemporaryDirectory() as top:
            seen, changed = pathlib.Path(top) / "seen", pathlib.Path(top) / "changed"
            for folder in (pathlib.Path(top), seen, changed):
                folder.mkdir(exist_ok=True)
                folder.chmod(0o777)
            (seen / "program").write_text("found")
            with Cluster(computers=1, shared=[seen], writable=[changed]) as cluster:
                self.assertEqual(cluster.on("n1", ["cat", seen / "program"]).stdout, "found")
                done = cluster.on("n1", ["touch", seen / "new"], check=False)
                self.assertIn("Read-only file system", done.stderr)
                cluster.on("n1", ["cp", seen / "program", changed / "copy"])
            self.assertEqual((changed / "copy").read_text(), "found")
            self.assertEqual(os.listdir(seen), ["program"])


class Ends(unittest.TestCase):
    def test_nothing_is_left(self):
        before, known = traces(), namespaces()
        with Cluster(computers=2) as cluster:
            cluster.popen("n1", ["bash", "-c", "setsid sleep 1000 & sleep 1000"])
            cluster.popen("n2", ["touch", "/tmp/cluster", "/dev/shm/cluster"]).wait(LIMIT_S)
            cluster.login(["srun", "-N2", "-n2", "true"])
            guardian = cluster._guardian.pid
            own = {os.readlink(f"/proc/{pid}/ns/{kind}") for pid in cluster._first.values()
                   for kind in NAMESPACES}
            self.assertEqual(len(own - known), 3 * len(NAMESPACES))
        self.assertFalse(os.path.exists(f"/proc/{guardian}"))
        self.assertEqual(own & namespaces() - known, set())
        self.assertEqual(traces(), before)

    def test_a_cluster_ends_with_the_process_that_made_it(self):
        script = (f"import sys; sys.path.insert(0, {str(pathlib.Path(__file__).parent)!r})\n"
                  "from cluster import Cluster\n"
                  "with Cluster(computers=1) as cluster:\n"
                  "    print(cluster._first['login'], cluster._first['n1'], flush=True)\n"
                  "    input()\n")
        with subprocess.Popen([sys.executable, "-B", "-c", script], stdin=subprocess.PIPE,
                              stdout=subprocess.PIPE, text=True) as maker:
            pids = list(map(int, maker.stdout.readline().split()))
            self.assertEqual(len(pids), 2)
            ends = [os.pidfd_open(pid) for pid in pids]
            maker.kill()
            contents.wait_for_descriptors(ends, LIMIT_S)
            for end in ends:
                self.assertEqual(contents.wait_for_descriptors([end], 0), set())
                os.close(end)

    def test_the_command_ends_with_the_code_of_its_program(self):
        program = pathlib.Path(__file__).with_name("cluster.py")
        done = subprocess.run([sys.executable, "-B", program, "--computers", "1", "--on", "n1",
                               "--user", "root", "bash", "-c", "hostname; id -un; exit 3"],
                              capture_output=True, text=True, timeout=LIMIT_S, check=False)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (3, "n1\nroot\n", ""))

    def test_a_daemon_that_does_not_start_is_named_with_its_log(self):
        before = traces()
        with self.assertRaisesRegex(ClusterError, r"(?s)slurm(ctl)?d has ended with code 1:"
                                                  r".*Nonsense"):
            with Cluster(computers=1, slurm_conf="Nonsense=1"):
                self.fail("a cluster started with a broken slurm.conf")
        self.assertEqual(traces(), before)


if __name__ == "__main__":
    WIRE = sys.argv.pop(1)
    REASON = missing()
    if REASON:
        print(f"SKIPPED: {REASON}")
        sys.exit(0)
    unittest.main()
