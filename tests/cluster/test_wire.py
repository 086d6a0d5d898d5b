#!/usr/bin/env python3
"""The switch of a cluster: test_wire.py WIRE. Sockets stand for the computers' TAP devices."""
import os
import socket
import struct
import subprocess
import sys
import time
import unittest

LIMIT_S = 30
HEADER = bytes(10)  # virtio_net_hdr
COMPUTERS = ("a", "b", "c")


def mac(name):
    return b"\x02\0\0\0\0" + name.encode()


def frame(source, to, number, size=0):
    return HEADER + mac(to) + mac(source) + b"\x08\0" + struct.pack("!I", number) + bytes(size)


class Wire(unittest.TestCase):
    def setUp(self):
        self.start(seed=1)

    def start(self, seed):
        """A switch with a, b and c. All know the addresses of all."""
        listening = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        listening.bind("")  # Linux chooses a name.
        listening.listen()
        self.control = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.control.connect(listening.getsockname())
        with listening:
            process = subprocess.Popen([WIRE, str(listening.fileno()), str(seed)],
                                       pass_fds=[listening.fileno()])
        self.addCleanup(process.wait, LIMIT_S)
        self.addCleanup(process.kill)
        self.addCleanup(self.control.close)
        self.control.settimeout(LIMIT_S)
        self.ends = {}
        for name in COMPUTERS:
            self.connect(name)
        for name in COMPUTERS:  # A frame for all shows where its sender is.
            self.ends[name].send(HEADER + b"\xff" * 6 + mac(name) + bytes(6))
            for other in set(COMPUTERS) - {name}:
                self.ends[other].recv(100)

    def connect(self, name):
        self.ends[name], tap = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.addCleanup(self.ends[name].close)
        self.ends[name].settimeout(LIMIT_S)
        os.set_blocking(tap.fileno(), False)
        self.ask(f"add {name}", tap)
        tap.close()

    def ask(self, request, tap=None, reply=b"ok"):
        socket.send_fds(self.control, [request.encode()], [tap.fileno()] if tap else [])
        self.assertEqual(self.control.recv(256), reply)

    def numbers_until(self, name, last):
        """The numbers of the frames that a computer receives, up to the last."""
        numbers = []
        while not numbers or numbers[-1] != last:
            numbers.append(struct.unpack_from("!I", self.ends[name].recv(70000), 24)[0])
        return numbers

    def send(self, source, to, numbers, size=0):
        for number in numbers:
            self.ends[source].send(frame(source, to, number, size))

    def test_frames_reach_their_receiver_alone(self):
        self.send("a", "b", range(5))
        self.send("a", "c", [9])
        self.assertEqual(self.numbers_until("b", 4), list(range(5)))
        self.assertEqual(self.numbers_until("c", 9), [9])

    def test_jitter_keeps_the_order(self):
        self.ask("set a 0 20000 0 0")
        self.send("a", "b", range(50))
        self.assertEqual(self.numbers_until("b", 49), list(range(50)))

    def test_delays_of_both_cables_add_up(self):
        self.ask("set a 100000 0 0 0")
        self.ask("set b 50000 0 0 0")
        for source, to in (("a", "b"), ("b", "a")):
            begin = time.monotonic()
            self.send(source, to, [1])
            self.numbers_until(to, 1)
            self.assertGreaterEqual(time.monotonic() - begin, 0.15)

    def losses(self, seed):
        self.start(seed)
        self.ask("set b 0 0 300000 0")
        self.send("a", "b", range(100))
        # All frames before this one have passed when c, on the same cable of a, has received it.
        self.send("a", "c", [100])
        self.numbers_until("c", 100)
        self.ask("set b 0 0 0 0")
        self.send("a", "b", [101])
        return self.numbers_until("b", 101)[:-1]

    def test_a_seed_repeats_the_losses(self):
        first = self.losses(7)
        self.assertTrue(50 <= len(first) <= 90, f"{len(first)} of 100 frames at 30 % loss")
        self.assertEqual(self.losses(7), first)
        self.assertNotEqual(self.losses(8), first)

    def test_a_rate_takes_its_time_and_drops_what_waits_too_long(self):
        size, mbit = 4000 - 28, 1.6
        for limited in ("a", "b"):
            self.ask(f"set {limited} 0 0 0 {mbit}")
            begin = time.monotonic()
            self.send("a", "b", range(5), size)
            self.assertEqual(self.numbers_until("b", 4), list(range(5)))
            self.assertGreaterEqual(time.monotonic() - begin, 5 * 4000 * 8 / (mbit * 1e6))
            self.send("a", "b", range(60), size)
            self.send("c", "a", [60])  # The switch reads frames of a before those of c.
            self.numbers_until("a", 60)
            self.ask(f"set {limited} 0 0 0 0")
            self.send("a", "b", [61])
            self.assertLess(len(self.numbers_until("b", 61)), 30)

    def test_a_cut_cable_drops_frames_and_a_joined_one_does_not(self):
        self.ask("cut b")
        for source, to in (("a", "b"), ("b", "a"), ("a", "c")):
            self.send(source, to, [1])
        self.numbers_until("c", 1)
        self.send("c", "a", [2])
        self.assertEqual(self.numbers_until("a", 2), [2])
        self.ask("join b")
        self.send("a", "b", [3])
        self.assertEqual(self.numbers_until("b", 3), [3])

    def test_a_computer_comes_back_with_a_new_cable(self):
        self.ask("cut b")
        self.ends["b"].close()
        self.connect("b")
        self.send("a", "b", [4])
        self.assertEqual(self.numbers_until("b", 4), [4])

    def test_wrong_requests_are_refused(self):
        self.ask("cut d", reply=b"no cable is called d")
        self.ask("set a 1 2", reply=b"not a request: set a 1 2")
        self.ask("add d", reply=b"no cable is called d")


if __name__ == "__main__":
    WIRE = sys.argv.pop(1)
    unittest.main()
