"""A small WebSocket client (RFC 6455) over plain sockets, for tests. Standard library alone."""
import base64
import os
import socket
import ssl
import struct
import time
import urllib.parse

MESSAGE_TIMEOUT_S = 20
TEXT, BINARY, CLOSE, PING, PONG = 1, 2, 8, 9, 10


class Refused(Exception):
    """The handshake was answered with another status than 101."""

    def __init__(self, status, body):
        super().__init__(f"{status}: {body}")
        self.status, self.body = status, body


class Closed(Exception):
    """The other side has closed the WebSocket; code 1006: without saying so."""

    def __init__(self, code, reason=""):
        super().__init__(f"{code} {reason}")
        self.code, self.reason = code, reason


def connect_to(url, timeout_s=20):
    """A TCP (or TLS, its certificate unchecked) connection to the host of `url`."""
    parts = urllib.parse.urlsplit(url)
    raw = socket.create_connection((parts.hostname, parts.port), timeout=timeout_s)
    if parts.scheme != "https":
        return raw
    context = ssl.create_default_context()
    context.check_hostname = False
    context.verify_mode = ssl.CERT_NONE
    return context.wrap_socket(raw, server_hostname=parts.hostname)


def all_from(connection):
    """All bytes until the other side closes or resets the connection."""
    got = b""
    try:
        while more := connection.recv(65536):
            got += more
    except ConnectionResetError:
        pass
    return got


def masked_frame(opcode, payload, final=True):
    """A frame as a client must send it."""
    size = len(payload)
    head = bytes([opcode | (0x80 if final else 0)])
    if size < 126:
        head += bytes([0x80 | size])
    elif size < 65536:
        head += bytes([0x80 | 126]) + struct.pack(">H", size)
    else:
        head += bytes([0x80 | 127]) + struct.pack(">Q", size)
    mask = os.urandom(4)
    key = (mask * (size // 4 + 1))[:size]
    masked = (int.from_bytes(payload, "big") ^ int.from_bytes(key, "big")).to_bytes(size, "big")
    return head + mask + masked


class WebSocket:
    """`url` is the printed address with its token; `headers` replace usual ones."""

    def __init__(self, url, path="/socket", token=None, headers=None, receive_buffer=None):
        parts = urllib.parse.urlsplit(url)
        query = urllib.parse.parse_qs(parts.query)
        token = query.get("token", [""])[0] if token is None else token
        self.socket = connect_to(url)
        if receive_buffer:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        self.waiting = b""
        self.pings = []  # What came with them.
        lines = {"Host": parts.netloc, "Upgrade": "websocket", "Connection": "Upgrade",
                 "Sec-WebSocket-Key": base64.b64encode(os.urandom(16)).decode(),
                 "Sec-WebSocket-Version": "13", **(headers or {})}
        target = path + (f"?token={token}" if token else "")
        head = "".join(f"{name}: {value}\r\n" for name, value in lines.items() if value is not None)
        self.socket.sendall(f"GET {target} HTTP/1.1\r\n{head}\r\n".encode())
        status, self.headers = self._read_head()
        if status != 101:
            body = self._exactly(int(self.headers.get("content-length", "0")))
            self.close()
            raise Refused(status, body.decode())

    def _read_head(self):
        while b"\r\n\r\n" not in self.waiting:
            more = self.socket.recv(65536)
            if not more:
                raise Closed(1006)
            self.waiting += more
        head, self.waiting = self.waiting.split(b"\r\n\r\n", 1)
        first, *lines = head.decode("latin-1").split("\r\n")
        pairs = (line.split(":", 1) for line in lines)
        return int(first.split()[1]), {name.lower(): value.strip() for name, value in pairs}

    def _exactly(self, count):
        while len(self.waiting) < count:
            try:
                more = self.socket.recv(1 << 20)
            except ConnectionResetError:
                more = b""
            if not more:
                raise Closed(1006)
            self.waiting += more
        taken, self.waiting = self.waiting[:count], self.waiting[count:]
        return taken

    def send_frame(self, opcode, payload, final=True):
        self.socket.sendall(masked_frame(opcode, payload, final))

    def send_frames(self, frames):
        """Pairs of opcode and payload, all at once."""
        self.socket.sendall(b"".join(masked_frame(*frame) for frame in frames))

    def send(self, text):
        self.send_frame(TEXT, text.encode())

    def receive(self):
        """The next text (str) or binary message (bytes). Answers pings; raises Closed.

        Raises TimeoutError if none comes in time: pings alone would keep it waiting for ever.
        """
        deadline = time.monotonic() + MESSAGE_TIMEOUT_S
        while time.monotonic() < deadline:
            first, second = self._exactly(2)
            size = second & 0x7f
            if size == 126:
                size, = struct.unpack(">H", self._exactly(2))
            elif size == 127:
                size, = struct.unpack(">Q", self._exactly(8))
            payload, opcode = self._exactly(size), first & 0x0f
            assert first & 0x80 and not first & 0x70 and not second & 0x80, "a whole, plain frame"
            if opcode == PING:
                self.pings.append(payload)
                self.send_frame(PONG, payload)
            elif opcode == CLOSE:
                code, = struct.unpack(">H", payload[:2]) if len(payload) > 1 else (1005,)
                raise Closed(code, payload[2:].decode())
            elif opcode == TEXT:
                return payload.decode()
            elif opcode == BINARY:
                return payload
        raise TimeoutError(f"no message within {MESSAGE_TIMEOUT_S} s")

    def close(self):
        self.socket.close()
