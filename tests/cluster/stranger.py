#!/usr/bin/env python3
"""A stranger at the tcp ports of a machine: what it sends, and what it gets back.

usage: stranger.py listening UID            prints the tcp ports at which a user's programs listen
       stranger.py record INTERFACE         records until standard input ends; prints the streams
       stranger.py attack ADDRESS:PORT...   attacks ports with text, garbage and orders
       stranger.py keys ADDRESS:PORT...     connects to ports with keys of its own
       stranger.py play ADDRESS:PORT...     plays the streams of standard input again at ports

`attack` and `play` print the most bytes that one connection got. Streams are JSON. `record` needs
root.
"""
import collections
import ctypes
import ctypes.util
import encodings.idna  # noqa: F401: another user may not be able to read Python's files.
import json
import pathlib
import socket
import struct
import sys
import threading

SHUTDOWN, SAVE_TRACE = 5, 25    # Kinds of PROTOCOL.md.
STRANGER, HOST, GP = 999, 0, 1  # Node ids.
LIMIT_S = 60
LOOPBACK = "0100007F"  # In /proc/net/tcp.
# The greeting of ZMTP 3, and the WELCOME of CURVE. Neither says anything about the machine.
MOST_ANSWER_BYTES = 64 + 2 + 168


def frame(data, more):
    return struct.pack(">BQ", 2 | int(more), len(data)) + data


def message(kind, source, to):
    body = bytes(64)
    header = struct.pack("<IHHHHHHQQQQQ", 0x35505850, 5, kind, source, to, 0, 0, 0, len(body), 0,
                         2**64 - 1, 2**64 - 1)
    return frame(header, True) + frame(body, False)


def greeting(mechanism):
    return (b"\xff" + bytes(8) + b"\x7f\x03\x00" + mechanism.ljust(20, b"\0") + bytes(32))


def null_peer(*messages):
    """The steps of a ZMTP 3.0 peer without a key, and its messages."""
    ready = b"\x05READY\x0bSocket-Type" + struct.pack(">I", 4) + b"PUSH"
    return [greeting(b"NULL"), b"\x04" + bytes([len(ready)]) + ready, b"".join(messages)]


def command(data):
    return b"\x06" + struct.pack(">Q", len(data)) + data


ATTACKS = {
    "text": [b"hello\n" * 20],
    "HTTP": [b"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n\r\nhello"],
    "old version": [b"\x01\x00" + b"\x06\x00hello"],
    "part": null_peer(frame(b"junk", False)),
    "orders": null_peer(message(SHUTDOWN, STRANGER, GP), message(SAVE_TRACE, STRANGER, GP),
                        message(SHUTDOWN, STRANGER, HOST)),
    "other mechanism": [greeting(b"PLAIN"), command(b"\x05HELLO\x01a\x01b")],
    "short hello": [greeting(b"CURVE"), command(b"\x05HELLO" + bytes(10))],
    "junk hello": [greeting(b"CURVE"), command(b"\x05HELLO\x01\x00" + b"\x7f" * 192)],
    "huge frame": [greeting(b"CURVE"), b"\x06" + b"\xff" * 8 + b"\x05HELLO"],
    "message before the proof": [greeting(b"CURVE"), message(SHUTDOWN, HOST, GP)],
}


def speak(address, port, steps):
    """Sends `steps` to a port and reads until it closes. Returns the number of bytes read."""
    got = 0
    with socket.create_connection((address, port), LIMIT_S) as stream:
        try:
            for step in steps:
                stream.sendall(step)
                stream.settimeout(0.2)  # An answer comes at once, or never.
                try:
                    got += len(stream.recv(1 << 16))
                except TimeoutError:
                    pass
            stream.settimeout(LIMIT_S)
            stream.shutdown(socket.SHUT_WR)
            while data := stream.recv(1 << 16):
                got += len(data)
        except TimeoutError:
            raise
        except OSError:
            pass  # The port has closed the connection.
    return got


def steps_of(stream):
    """A recorded stream as a whole, and as that of a peer that waits for both answers."""
    return [stream], [stream[:64], stream[64:266], stream[266:]]


class Recorder:
    """Records what is sent to tcp ports on a network interface.

    streams()["10.0.0.1:4711"] are the bytes of each connection to a port, from its beginning.
    """
    MOST_BYTES = 1 << 17

    def __init__(self, interface):
        self.sent = collections.defaultdict(dict)  # Bytes by sequence number, by both ends.
        self.packets = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.ntohs(3))
        self.packets.bind((interface, 0))
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
            if packet[12:14] == b"\x08\x00" and packet[23] == socket.IPPROTO_TCP:
                tcp = 14 + 4 * (packet[14] & 15)
                end = 14 + struct.unpack_from(">H", packet, 16)[0]  # Short frames are filled up.
                source, to, number = struct.unpack_from(">HHI", packet, tcp)
                connection = (packet[26:30], source, packet[30:34], to)
                data = packet[tcp + 4 * (packet[tcp + 12] >> 4):end]
                if packet[tcp + 13] & 2:
                    self.sent[connection]["start"] = (number + 1) % 2**32
                elif data:
                    self.sent[connection].setdefault(number, data)

    def streams(self):
        self.is_done = True
        self.thread.join()
        self.packets.close()
        found = collections.defaultdict(list)
        for (_, _, address, port), parts in self.sent.items():
            number, stream = parts.get("start", 0), b""
            while parts.get(number) and len(stream) < self.MOST_BYTES:
                data = parts[number]
                stream += data
                number = (number + len(data)) % 2**32
            if stream:
                found[f"{socket.inet_ntoa(address)}:{port}"].append(stream)
        return found


def refused_with_own_key(address, port):
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
    zmq.zmq_connect(stranger, f"tcp://{address}:{port}".encode())
    event = ctypes.create_string_buffer(6)
    size = zmq.zmq_recv(events, event, 6, 0)
    zmq.zmq_close(stranger)
    zmq.zmq_close(events)
    zmq.zmq_ctx_term(context)
    return size == 6 and struct.unpack("=H", event.raw[:2])[0] != succeeded


def listening(uid):
    """The tcp ports of this computer at which programs of a user listen to other computers."""
    lines = [line.split() for line in pathlib.Path("/proc/net/tcp").read_text().splitlines()[1:]]
    return sorted({int(words[1].split(":")[1], 16) for words in lines
                   if words[3] == "0A" and int(words[7]) == uid
                   and not words[1].startswith(LOOPBACK)})


def main(what, *words):
    ends = [(word.split(":")[0], int(word.split(":")[1])) for word in words if ":" in word]
    if what == "listening":
        print(json.dumps(listening(int(words[0]))))
    elif what == "record":
        recorder = Recorder(words[0])
        print("records", flush=True)
        sys.stdin.read()
        print(json.dumps({end: [stream.hex() for stream in streams]
                          for end, streams in recorder.streams().items()}))
    elif what == "attack":
        print(max(speak(*end, steps) for steps in ATTACKS.values() for end in ends))
    elif what == "keys":
        print(json.dumps([refused_with_own_key(*end) for end in ends]))
    elif what == "play":
        streams = {end: [bytes.fromhex(stream) for stream in of_end]
                   for end, of_end in json.load(sys.stdin).items()}
        everything = [stream for of_end in streams.values() for stream in of_end]
        # No program has connected to some ports yet. They get all streams.
        print(max(speak(address, port, steps) for address, port in ends
                  for stream in streams.get(f"{address}:{port}", everything)
                  for steps in steps_of(stream)))


if __name__ == "__main__":
    main(*sys.argv[1:])
