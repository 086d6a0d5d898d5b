#!/usr/bin/env python3
"""Uploads, downloads, and how the server starts: test_server_files.py ECHO_SERVER."""
import json
import os
import pathlib
import shutil
import socket
import subprocess
import sys
import tempfile
import unittest
import urllib.parse

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from server_case import Case, EchoServer, main  # noqa: E402
from websocket_client import Closed, Refused, WebSocket, connect_to  # noqa: E402


class Files(Case):
    def upload(self, path, body=b"", **words):
        status, _, answer = self.server.request(path, method="POST", body=body, **words)
        return status, json.loads(answer)

    def test_a_download_is_an_attachment(self):
        status, headers, body = self.server.request("/download/mesh.ply")
        self.assertEqual((status, body), (200, b"ply" * 100_000))
        self.assertEqual(headers["content-disposition"], 'attachment; filename="mesh.ply"')

    def test_a_folder_is_uploaded_file_by_file(self):
        content = bytes(range(256)) * 20_000
        for name in ("study/1.dcm", "study/2.dcm", "../study/empty"):
            query = urllib.parse.urlencode({"name": name, "batch": "b1"})
            body = b"" if name.endswith("empty") else content
            self.assertEqual(self.upload("/upload?" + query, body), (200, {}))
        status, answer = self.upload("/upload/done?batch=b1")
        self.assertEqual((status, answer["files"], answer["name"]), (200, 3, "study"))
        path = pathlib.Path(answer["path"])
        self.assertEqual(path.parent.parent, pathlib.Path(self.folder) / "uploads")
        self.assertEqual((path / "2.dcm").read_bytes(), content)
        self.assertEqual((path / "empty").read_bytes(), b"")

    def test_an_upload_stays_after_another_volume_was_opened(self):
        self.upload("/upload?name=a.nrrd&batch=b", b"voxels")
        path = pathlib.Path(self.upload("/upload/done?batch=b")[1]["path"])
        viewer = self.join()
        for opened in (path, "phantom:torus"):
            viewer.send(json.dumps({"opened": str(opened)}))
            self.sync(viewer)
            self.assertEqual(path.read_bytes(), b"voxels")

    def test_what_is_wrong_with_an_upload_is_said(self):
        status, answer = self.upload("/upload?name=..&batch=b", b"x" * 1_000_000)
        self.assertEqual((status, answer["error"]), (400, "A file cannot be named '..'."))
        self.assertEqual(self.upload("/upload?name=a&batch=../b", b"x")[0], 400)
        self.assertEqual(self.upload("/upload/done?batch=b")[0], 400)
        connection = connect_to(self.server.url)
        self.addCleanup(connection.close)
        parts = urllib.parse.urlsplit(self.server.url)
        connection.sendall((f"POST /upload?name=a&batch=b&{parts.query} HTTP/1.1\r\nHost: "
                            f"{parts.netloc}\r\nContent-Length: {5 << 30}\r\n\r\n").encode())
        self.assertIn(b" 413 ", connection.recv(65536).split(b"\r\n")[0])

    def test_an_upload_that_breaks_off_leaves_no_file(self):
        parts = urllib.parse.urlsplit(self.server.url)
        connection = connect_to(self.server.url)
        connection.sendall((f"POST /upload?name=a&batch=b&{parts.query} HTTP/1.1\r\nHost: "
                            f"{parts.netloc}\r\nContent-Length: 100\r\n\r\nhalf").encode())
        connection.shutdown(socket.SHUT_WR)
        connection.recv(1)
        connection.close()
        self.sync(self.join())
        left = [path for path in pathlib.Path(self.folder, "uploads").rglob("*") if path.is_file()]
        self.assertEqual(left, [])

    def test_a_watcher_may_neither_upload_nor_download(self):
        token = urllib.parse.urlsplit(self.server.watch_url).query
        status, _, body = self.server.request("/upload?name=a&batch=b&" + token, method="POST",
                                              body=b"x", token=False)
        self.assertEqual((status, body), (403, b"A view-only address cannot upload files.\n"))
        status, _, body = self.server.request("/download/mesh.ply?" + token, token=False)
        self.assertEqual((status, body), (403, b"A view-only address cannot download files.\n"))


class Start(unittest.TestCase):
    def fails(self, code, *words):
        with tempfile.TemporaryDirectory() as folder:
            server = EchoServer(folder, *words)
            self.assertEqual(server.url, "")
            got, complaint = server.stop()
            self.assertEqual(got, code, complaint)
            return complaint

    def test_options_that_contradict_each_other_are_refused(self):
        self.assertIn("--bind 0.0.0.0", self.fails(64, "bind", "0.0.0.0"))
        self.assertIn("not 'localhost'", self.fails(64, "bind", "localhost"))
        self.assertIn("not 65536", self.fails(64, "port", "65536"))
        self.assertIn("must be given together", self.fails(64, "cert", "c.pem"))
        self.assertIn("cannot read c.pem: does not exist",
                      self.fails(65, "cert", "c.pem", "key", "k.pem"))
        with tempfile.TemporaryDirectory() as folder:
            fifo = f"{folder}/fifo"
            os.mkfifo(fifo)
            self.assertIn(f"cannot read {fifo}: is a FIFO, not a file",
                          self.fails(65, "cert", __file__, "key", fifo))
        self.assertRegex(
            self.fails(65, "cert", __file__, "key", __file__),
            rf"the certificate {__file__} and the key {__file__} cannot be used: .*PEM")
        self.assertIn("/nowhere is missing", self.fails(65, "page", "/nowhere"))
        self.assertIn("cannot make the folder '/dev/null/up'",
                      self.fails(1, "uploads", "/dev/null/up"))

    def test_a_port_in_use_is_named(self):
        with socket.create_server(("127.0.0.1", 0)) as other:
            port = other.getsockname()[1]
            self.assertIn(f"cannot listen on 127.0.0.1 port {port}: Address already in use",
                          self.fails(69, "port", str(port)))

    def test_insecure_lets_others_in(self):
        with tempfile.TemporaryDirectory() as folder:
            server = EchoServer(folder, "bind", "0.0.0.0", "insecure", "1")
            url = urllib.parse.urlsplit(server.url)
            local = f"http://127.0.0.1:{url.port}/?{url.query}"
            WebSocket(local).close()
            with self.assertRaises(Refused):
                WebSocket(local, headers={"Host": "evil.example"})
            self.assertEqual(server.stop(), (0, ""))

    def test_ipv6_is_served_where_there_is_any(self):
        try:
            socket.create_server(("::1", 0), family=socket.AF_INET6).close()
        except OSError as error:
            self.skipTest(f"no IPv6 here: {error}")
        with tempfile.TemporaryDirectory() as folder:
            server = EchoServer(folder, "bind", "::1")
            self.assertTrue(server.url.startswith("http://[::1]:"), server.url)
            WebSocket(server.url).close()
            self.assertEqual(server.stop(), (0, ""))

    def test_with_a_certificate_all_is_encrypted(self):
        if not shutil.which("openssl"):
            self.skipTest("openssl is not installed")
        with tempfile.TemporaryDirectory() as folder:
            key, cert = folder + "/key.pem", folder + "/cert.pem"
            subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt",
                            "ec_paramgen_curve:P-256", "-nodes", "-days", "1", "-subj",
                            "/CN=viewer.example", "-keyout", key, "-out", cert],
                           check=True, capture_output=True)
            server = EchoServer(folder, "bind", "0.0.0.0", "cert", cert, "key", key)
            url = urllib.parse.urlsplit(server.url)
            self.assertEqual(url.scheme, "https")
            local = f"https://127.0.0.1:{url.port}/?{url.query}"
            server.url = local
            status, headers, _ = server.request("/")
            self.assertEqual(status, 200)
            self.assertIn("content-security-policy", headers)
            self.assertNotIn("strict-transport-security", headers)
            viewer = WebSocket(local)
            viewer.send('{"binary":3000000}')
            self.assertIn("hello", viewer.receive())
            self.assertEqual(len(viewer.receive()), 3_000_000)
            WebSocket(local, headers={"Host": "viewer.example"}).close()
            with self.assertRaises((Refused, Closed, ConnectionResetError)):
                WebSocket(local.replace("https", "http"))
            viewer.close()
            self.assertEqual(server.stop(), (0, ""))

    def test_tls_without_forward_secrecy_is_refused(self):
        if not shutil.which("openssl"):
            self.skipTest("openssl is not installed")
        with tempfile.TemporaryDirectory() as folder:
            key, cert = folder + "/key.pem", folder + "/cert.pem"
            subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days",
                            "1", "-subj", "/CN=viewer.example", "-keyout", key, "-out", cert],
                           check=True, capture_output=True)
            server = EchoServer(folder, "cert", cert, "key", key)
            port = urllib.parse.urlsplit(server.url).port
            for suite, is_taken in (("ECDHE-RSA-AES128-GCM-SHA256", True), ("AES256-SHA", False),
                                    ("AES128-GCM-SHA256", False)):
                done = subprocess.run(
                    ["openssl", "s_client", "-connect", f"127.0.0.1:{port}", "-tls1_2", "-cipher",
                     suite + ":@SECLEVEL=0"], input="", capture_output=True, text=True, timeout=20)
                self.assertEqual("Cipher is " + suite in done.stdout, is_taken, (suite, done))
            self.assertEqual(server.stop(), (0, ""))


if __name__ == "__main__":
    main()
