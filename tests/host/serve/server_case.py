"""A server under test, and a case that has one."""
import http.client
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest
import urllib.parse

from websocket_client import Closed, Refused, WebSocket, connect_to

ECHO_SERVER = ""  # From the command line.


class EchoServer:
    """The server under test with a page, a download and a folder for uploads."""

    def __init__(self, folder, *words):
        folder = pathlib.Path(folder)
        for name in ("page", "uploads", "downloads"):
            (folder / name).mkdir(exist_ok=True)
        (folder / "page/index.html").write_text("<h1>page</h1>")
        (folder / "page/main.js").write_text("export {}")
        (folder / "downloads/mesh.ply").write_bytes(b"ply" * 100_000)
        (folder / "secret").write_text("secret")
        self.process = subprocess.Popen(
            [ECHO_SERVER, "page", folder / "page", "uploads", folder / "uploads", "downloads",
             folder / "downloads", *words],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.url = self.process.stdout.readline().strip()
        self.watch_url = self.process.stdout.readline().strip()

    def event(self):
        return self.process.stdout.readline().strip()

    def stop(self):
        """Ends it by the end of its input; its exit code and what it complained of."""
        _, complaint = self.process.communicate()
        return self.process.returncode, complaint

    def request(self, path, method="GET", token=True, headers=None, body=None):
        """One request on a connection of its own: status, headers, body."""
        parts = urllib.parse.urlsplit(self.url)
        connection = http.client.HTTPConnection(parts.hostname, parts.port)
        connection.sock = connect_to(self.url)
        if token:
            path += ("&" if "?" in path else "?") + parts.query
        connection.request(method, path, body=body, headers=headers or {})
        answer = connection.getresponse()
        body = answer.read()
        connection.close()
        return answer.status, answer.headers, body


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)
        self.server = EchoServer(self.folder)
        self.addCleanup(self.ends_well)

    def ends_well(self):
        code, complaint = self.server.stop()
        self.assertEqual((code, complaint), (0, ""))

    def join(self, url=None, **words):
        viewer = WebSocket(url or self.server.url, **words)
        self.addCleanup(viewer.close)
        self.assertIn("hello", json.loads(viewer.receive()))
        return viewer

    def ask(self, viewer, **words):
        viewer.send(json.dumps(words))
        return json.loads(viewer.receive())

    def sync(self, viewer):
        """Returns when the server has done all that the viewer said before."""
        self.assertEqual(self.ask(viewer, echo=0), {"echo": 0})

    def refused(self, status, **words):
        with self.assertRaises(Refused) as caught:
            WebSocket(self.server.url, **words)
        self.assertEqual(caught.exception.status, status, caught.exception.body)
        return caught.exception.body

    def closed(self, code, viewer):
        with self.assertRaises(Closed) as caught:
            while True:
                viewer.receive()
        self.assertEqual(caught.exception.code, code)
        return caught.exception.reason


def main():
    """Runs the cases of the program: PROGRAM ECHO_SERVER [unittest's words]."""
    global ECHO_SERVER
    ECHO_SERVER = sys.argv.pop(1)
    unittest.main(warnings="ignore")  # Of sockets that a failing case leaves open.
