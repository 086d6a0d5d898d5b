#!/usr/bin/env python3
"""A portal for tests: a reverse proxy on loopback with the paths of Open OnDemand and JupyterHub.

usage: portal.py

Prints its port, and ends with its input. A request for `/rnode/HOST/PORT/X` goes to port PORT of
this computer as `/X`, one for `/node/HOST/PORT/X` with its whole path. The server is called
HOST:PORT. As Apache does, the portal writes headers of its own for WebSockets.
"""
import re
import socket
import socketserver
import sys
import threading

PATH = re.compile(r"/(r?node)/([^/?]+)/(\d+)([^ ]*)")
ANSWER_404 = b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"


def head_of(connection):
    """The bytes up to the end of the request's head, and those after it."""
    got = b""
    while b"\r\n\r\n" not in got:
        more = connection.recv(65536)
        if not more:
            return "", b""
        got += more
    head, rest = got.split(b"\r\n\r\n", 1)
    return head.decode("latin-1"), rest


def passed_on(head):
    """The port of the server and the head that it gets; None without a place in the path."""
    first, *lines = head.split("\r\n")
    method, target, version = first.split(" ")
    found = PATH.fullmatch(target)
    if not found:
        return None
    kind, host, port, path = found.groups()
    target = target if kind == "node" else path if path.startswith("/") else "/" + path
    upgrades = any(line.lower().startswith("upgrade:") for line in lines)
    own = ("host:", "connection:", "upgrade:")
    kept = [line for line in lines if not line.lower().startswith(own)]
    more = ["Upgrade: WebSocket", "Connection: Upgrade"] if upgrades else ["Connection: close"]
    return int(port), "\r\n".join([f"{method} {target} {version}", f"Host: {host}:{port}", *more,
                                   *kept, "", ""]).encode("latin-1")


def pump(source, sink):
    """Passes bytes on until the source ends."""
    try:
        while chunk := source.recv(65536):
            sink.sendall(chunk)
        sink.shutdown(socket.SHUT_WR)
    except OSError:
        pass  # One end has gone.


class Handler(socketserver.BaseRequestHandler):
    def handle(self):
        head, rest = head_of(self.request)
        wanted = passed_on(head) if head else None
        if not wanted:
            self.request.sendall(ANSWER_404 if head else b"")
            return
        with socket.create_connection(("127.0.0.1", wanted[0])) as server:
            server.sendall(wanted[1] + rest)
            up = threading.Thread(target=pump, args=(self.request, server), daemon=True)
            up.start()
            pump(server, self.request)
            try:
                self.request.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass  # The browser has gone.
            up.join()


class Portal(socketserver.ThreadingTCPServer):
    """Runs in threads of its own until close()."""
    daemon_threads = True

    def __init__(self):
        super().__init__(("127.0.0.1", 0), Handler)
        self.port = self.server_address[1]
        threading.Thread(target=self.serve_forever, daemon=True).start()

    def close(self):
        self.shutdown()
        self.server_close()


if __name__ == "__main__":
    PORTAL = Portal()
    print(PORTAL.port, flush=True)
    sys.stdin.read()
    PORTAL.close()
