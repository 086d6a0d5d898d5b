#!/usr/bin/env python3
"""A stranger at the tcp ports of a running machine: nothing changes, and the machine goes on.

The stranger sends text, garbage and orders, has a key of its own, or plays again what it recorded.

usage: test_strangers.py BIN    BIN is the folder of pxpl5
"""
import collections
import ctypes
import ctypes.util
import encodings.idna  # noqa: F401: another user may not be able to read Python's files.
import os
import pathlib
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from processes import children_of  # noqa: E402

SHUTDOWN, SAVE_TRACE = 5, 25    # Kinds of PROTOCOL.md.
STRANGER, HOST, GP = 999, 0, 1  # Node ids.
LIMIT_S = 60
SCENE = "load phantom:sphere; surface s iso=0"


def frame(data, more):
    return struct.pack(">BQ", 2 | int(more), len(data)) + data


def message(kind, source, to):
    body = bytes(64)
    header = struct.pack("<IHHHHHHQQQQQ", 0x35505850, 5, kind, source, to, 0, 0, 0, len(body), 0,
                         2**64 - 1, 2**64 - 1)
    return frame(header, True) + frame(body, False)


def null_peer(*messages):
    """The steps of a ZMTP 3.0 peer without a key, and its messages."""
    greeting = b"\xff" + bytes(8) + b"\x7f\x03\x00" + b"NULL".ljust(20, b"\0") + bytes(32)
    ready = b"\x05READY\x0bSocket-Type" + struct.pack(">I", 4) + b"PUSH"
    return [greeting, b"\x04" + bytes([len(ready)]) + ready, b"".join(messages)]


ATTACKS = {
    "text": [b"hello\n" * 20],
    "HTTP": [b"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n\r\nhello"],
    "part": null_peer(frame(b"junk", False)),
    "orders": null_peer(message(SHUTDOWN, STRANGER, GP), message(SAVE_TRACE, STRANGER, GP),
                        message(SHUTDOWN, STRANGER, HOST)),
}


def ports(pid):
    """The tcp ports at which a process listens."""
    inodes = set()
    for entry in os.listdir(f"/proc/{pid}/fd"):
        try:
            inodes.add(os.readlink(f"/proc/{pid}/fd/{entry}"))
        except OSError:
            pass
    found = []
    for line in pathlib.Path("/proc/net/tcp").read_text().splitlines()[1:]:
        words = line.split()
        if words[3] == "0A" and f"socket:[{words[9]}]" in inodes:
            found.append(int(words[1].split(":")[1], 16))
    return found


def attack(port, steps):
    """Sends `steps`, as another user if this is root, and reads until the port closes."""
    child = os.fork()
    if child == 0:
        code = 1
        try:
            if os.geteuid() == 0:
                os.setgid(65534)
                os.setuid(65534)
            with socket.create_connection(("127.0.0.1", port), LIMIT_S) as stream:
                code = 0
                for step in steps:
                    stream.sendall(step)
                    stream.settimeout(0.2)  # An answer comes at once, or never.
                    try:
                        stream.recv(4096)
                    except TimeoutError:
                        pass
                stream.settimeout(LIMIT_S)
                stream.shutdown(socket.SHUT_WR)
                while stream.recv(4096):
                    pass
        except OSError:
            pass  # The port has closed the connection.
        finally:
            os._exit(code)
    return os.waitpid(child, 0)[1] == 0


class Recorder:
    """Records what is sent to tcp ports on the loopback interface. Needs root.

    streams[port] are the bytes of each connection to a port, from its beginning.
    """
    MOST_BYTES = 1 << 17

    def __init__(self):
        self.sent = collections.defaultdict(dict)  # Bytes by sequence number, by both ports.
        self.packets = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.ntohs(0x0800))
        self.packets.bind(("lo", 0))
        self.packets.settimeout(0.1)
        self.is_done = False
        self.thread = threading.Thread(target=self.record)
        self.thread.start()

    def record(self):
        while not self.is_done:
            try:
                packet = self.packets.recv(1 << 17)
            except TimeoutError:
                continue
            if packet[23] == socket.IPPROTO_TCP:
                tcp = 14 + 4 * (packet[14] & 15)
                source, to, number = struct.unpack_from(">HHI", packet, tcp)
                is_start = packet[tcp + 13] & 2
                data = packet[tcp + 4 * (packet[tcp + 12] >> 4):]
                if is_start:
                    self.sent[source, to]["start"] = (number + 1) % 2**32
                elif data:
                    self.sent[source, to].setdefault(number, data)

    def streams(self):
        self.is_done = True
        self.thread.join()
        self.packets.close()
        found = collections.defaultdict(list)
        for (_, to), parts in self.sent.items():
            number, stream = parts.get("start", 0), b""
            while parts.get(number) and len(stream) < self.MOST_BYTES:
                data = parts[number]
                stream += data
                number = (number + len(data)) % 2**32
            if stream:
                found[to].append(stream)
        return found


def refused_with_own_key(port):
    """Connects with a key pair and a server's key of its own. True if the port ends that."""
    zmq = ctypes.CDLL(ctypes.util.find_library("zmq"))
    for name in ("zmq_ctx_new", "zmq_socket"):
        getattr(zmq, name).restype = ctypes.c_void_p
    zmq.zmq_socket.argtypes = [ctypes.c_void_p, ctypes.c_int]
    pair, push, monitored = 0, 8, 0x0200 | 0x0800 | 0x1000 | 0x2000 | 0x4000
    succeeded = 0x1000
    context = ctypes.c_void_p(zmq.zmq_ctx_new())
    stranger = ctypes.c_void_p(zmq.zmq_socket(context, push))
    keys = [ctypes.create_string_buffer(41) for _ in range(4)]
    zmq.zmq_curve_keypair(keys[0], keys[1])
    zmq.zmq_curve_keypair(keys[2], keys[3])
    for option, key in ((48, keys[0]), (49, keys[1]), (50, keys[2])):  # Public, secret, server's.
        assert zmq.zmq_setsockopt(stranger, option, key, 40) == 0
    zmq.zmq_setsockopt(stranger, 17, ctypes.byref(ctypes.c_int(0)), 4)  # Do not linger.
    zmq.zmq_socket_monitor(stranger, b"inproc://events", monitored)
    events = ctypes.c_void_p(zmq.zmq_socket(context, pair))
    zmq.zmq_setsockopt(events, 27, ctypes.byref(ctypes.c_int(1000 * LIMIT_S)), 4)  # To receive.
    zmq.zmq_connect(events, b"inproc://events")
    zmq.zmq_connect(stranger, f"tcp://127.0.0.1:{port}".encode())
    event = ctypes.create_string_buffer(6)
    size = zmq.zmq_recv(events, event, 6, 0)
    zmq.zmq_close(stranger)
    zmq.zmq_close(events)
    zmq.zmq_ctx_term(context)
    return size == 6 and struct.unpack("=H", event.raw[:2])[0] != succeeded


class Strangers(unittest.TestCase):
    def run_attacked(self, flags, attack_all):
        with tempfile.TemporaryDirectory() as folder:
            command = [BIN / "pxpl5", "run", "--topology", "one-of-each", "--run-folder", folder,
                       *flags, "-"]
            with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE, text=True) as host:
                host.stdin.write(SCENE.replace("; ", "\n") + "\n")
                host.stdin.flush()
                said = [host.stdout.readline()]
                while not said[-1].startswith("s: isovalue"):
                    self.assertTrue(said[-1], "the machine ended early")
                    said.append(host.stdout.readline())
                listening = [port for pid in [host.pid, *children_of(host.pid)]
                             for port in ports(pid)]
                self.assertGreaterEqual(len(listening), 4)
                attack_all(listening)
                out, errors = host.communicate("digest\nquit\n", LIMIT_S)
                self.assertEqual(host.returncode, 0, errors)
                logs = "".join(log.read_text() for log in pathlib.Path(folder).glob("*/*.log"))
                return out, errors, logs

    def quiet_digest(self):
        with tempfile.TemporaryDirectory() as folder:
            command = [BIN / "pxpl5", "run", "--topology", "one-of-each", "--run-folder", folder,
                       "-c", SCENE + "; digest"]
            done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT_S,
                                  check=True)
            return [line for line in done.stdout.splitlines() if line.startswith("frame ")]

    def attack_all(self, listening):
        for steps in ATTACKS.values():
            for port in listening:
                self.assertTrue(attack(port, steps))

    def check(self, flags, named, attack_all=None):
        out, errors, logs = self.run_attacked(["--set", "ring.transport=tcp", *flags],
                                              attack_all or self.attack_all)
        frames = [line for line in out.splitlines() if line.startswith("frame ")]
        self.assertEqual(frames, self.quiet_digest())
        self.assertIn("warning: the ring dropped", errors)
        self.assertIn("without a lawful sender", errors)
        for text in named:
            self.assertIn(text, logs)

    def test_with_keys(self):
        self.check([], ["without the key of this session"])

    def test_with_another_key(self):
        def connect_all(listening):
            for port in listening:
                self.assertTrue(refused_with_own_key(port))
        self.check([], ["without the key of this session"], connect_all)

    @unittest.skipUnless(os.geteuid() == 0, "only root can record what others send")
    def test_with_recorded_messages(self):
        recorder = Recorder()

        def play_again(listening):
            streams = recorder.streams()
            # No io process has connected to the host's socket for them.
            (quiet,) = [port for port in listening if not streams[port]]
            streams[quiet] = [stream for port in listening for stream in streams[port]]
            for port in listening:
                for stream in streams[port]:
                    # The whole, and as a peer that waits for the answers to its greeting and hello.
                    self.assertTrue(attack(port, [stream]))
                    self.assertTrue(attack(port, [stream[:64], stream[64:266], stream[266:]]))
        try:
            self.check([], ["without the key of this session"], play_again)
        finally:
            recorder.streams()

    def test_without_keys(self):
        self.check(["--insecure-tcp"],
                   [f"Shutdown from node {STRANGER}, which is not a node of this machine",
                    "a message of 1 parts with a header of 4 bytes"])


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv.pop()).resolve()
    unittest.main()
