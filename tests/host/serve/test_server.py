#!/usr/bin/env python3
"""Tests access and the messages of a WebSocket: test_server.py ECHO_SERVER."""
import gzip
import json
import os
import pathlib
import socket
import sys
import urllib.parse

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from server_case import Case, main  # noqa: E402
from websocket_client import (BINARY, TEXT, Closed, Refused, WebSocket, all_from, connect_to,
                              masked_frame)  # noqa: E402


class Access(Case):
    def test_a_token_opens_the_page_and_leaves_a_cookie(self):
        status, headers, body = self.server.request("/")
        self.assertEqual((status, body), (200, b"<h1>page</h1>"))
        cookie, *flags = headers["set-cookie"].split("; ")
        self.assertEqual(flags, ["HttpOnly", "SameSite=Strict"])
        for path in ("/", "/main.js"):
            self.assertEqual(self.server.request(path, token=False)[0], 403, path)
            with_cookie = self.server.request(path, token=False, headers={"Cookie": cookie})
            self.assertEqual(with_cookie[0], 200, path)
        # Other ports of this computer may see the cookie: it opens nothing but the page.
        self.assertIn("token is missing", self.refused(403, token="", headers={"Cookie": cookie}))
        for method, path in (("GET", "/download/mesh.ply"), ("POST", "/upload?name=a.nrrd")):
            status, _, body = self.server.request(path, method, token=False, body=b"",
                                                  headers={"Cookie": cookie})
            self.assertEqual((status, b"token is missing" in body), (403, True), path)
        self.join(headers={"Cookie": cookie})
        token = urllib.parse.parse_qs(urllib.parse.urlsplit(self.server.url).query)["token"][0]
        self.assertNotIn(token, headers["set-cookie"])

    def test_every_answer_forbids_what_a_page_must_not_do(self):
        for path, token, status in (("/", True, 200), ("/", False, 403), ("/nothing", True, 404)):
            got, headers, _ = self.server.request(path, token=token)
            self.assertEqual(got, status)
            self.assertIn("default-src 'self'", headers["content-security-policy"])
            self.assertNotIn("unsafe", headers["content-security-policy"])
            self.assertEqual(headers["x-content-type-options"], "nosniff")
            self.assertEqual(headers["cache-control"], "no-store")
            self.assertEqual(headers["referrer-policy"], "no-referrer")
            self.assertEqual(headers["x-frame-options"], "deny")
            self.assertEqual(headers["cross-origin-resource-policy"], "same-origin")
            self.assertEqual(headers["cross-origin-opener-policy"], "same-origin")

    def test_wrong_tokens_hosts_and_origins_are_refused(self):
        self.assertIn("token", self.refused(403, token="0" * 32))
        self.refused(403, token="")
        self.refused(403, headers={"Cookie": "pxpl5=1"}, token="")
        self.refused(403, headers={"Host": "evil.example"})
        self.refused(403, headers={"Origin": "http://evil.example"})
        self.refused(404, path="/elsewhere")
        host = urllib.parse.urlsplit(self.server.url).netloc
        self.join(headers={"Origin": f"http://{host}"})
        self.join(headers={"Host": "localhost:1", "Origin": "http://localhost:1"})
        self.assertEqual(self.server.request("/", headers={"Host": "evil.example"})[0], 403)

    def test_paths_lead_nowhere_else(self):
        for path in ("/../secret", "/..%2fsecret", "/%2e%2e/secret", "//secret", "/page/index.html",
                     "/download/../secret", "/download/..%2fsecret", "/download/%2e%2e%2fsecret",
                     "/download/" + self.folder + "/secret", "/download/%00", "/uploads/"):
            status, _, body = self.server.request(path)
            self.assertIn(status, (400, 403, 404), path)
            self.assertNotIn(b"secret\n", body + b"\n", path)

    def answer_to(self, target):
        """Status and body of a request for exactly these bytes; 0 if the server only closes."""
        parts = urllib.parse.urlsplit(self.server.url)
        connection = connect_to(self.server.url)
        self.addCleanup(connection.close)
        connection.sendall(b"GET " + target + f"?{parts.query} HTTP/1.1\r\nHost: {parts.netloc}\r\n"
                           "Connection: close\r\n\r\n".encode())
        head, _, body = all_from(connection).partition(b"\r\n\r\n")
        return int(head.split(b" ")[1]) if head else 0, body

    def test_odd_targets_of_a_request_are_refused(self):
        self.assertEqual(self.answer_to(b"/"), (200, b"<h1>page</h1>"))
        here = urllib.parse.urlsplit(self.server.url).netloc.encode()
        for target in (b"http://evil/", b"http://evil/main.js", b"http://evil/../secret",
                       b"https://evil:1/secret", b"http://" + here + b"/", b"//evil/main.js",
                       b"file:///etc/passwd", b"*", b"secret", b"../secret", b"\\secret",
                       b"/%c0%ae%c0%ae/secret", b"/%c0%ae%c0%ae%c0%afsecret",
                       b"/\xc0\xae\xc0\xae/secret", b"/%e0%80%ae%e0%80%ae/secret",
                       b"/download/%c0%ae%c0%ae%c0%afsecret", b"/%2e%2e%2fsecret",
                       b"/download/%2e%2e%2fsecret", b"/%2e%2e%5csecret", b"/..\\secret",
                       b"/%252e%252e%252fsecret", b"/%u002e%u002e/secret", b"/%zz", b"/%2",
                       b"/download/%2fetc/passwd", b"/main.js;secret"):
            status, body = self.answer_to(target)
            self.assertIn(status, (400, 403, 404), target)
            self.assertNotEqual(body, b"secret", target)
        # The library closes the connection at most of these, and does not answer.
        for target in (b"/main.js%00", b"/main.js\0", b"/main.js%00.png", b"/download/mesh.ply%00",
                       b"/..%00/secret", b"/\0../secret", b"/download/..%00/../secret"):
            status, body = self.answer_to(target)
            self.assertIn(status, (0, 400, 403, 404), target)
            self.assertNotIn(body, (b"secret", b"export {}", b"ply" * 100_000), target)
        self.sync(self.join())

    def test_the_page_is_compressed_for_those_who_accept_gzip(self):
        for path in ("/", "/main.js"):
            _, plain_headers, plain = self.server.request(path)
            self.assertNotIn("content-encoding", plain_headers)
            for accepted in ("gzip", "br, gzip", "deflate;q=1, gzip ; q=0.5"):
                status, headers, body = self.server.request(
                    path, headers={"Accept-Encoding": accepted})
                self.assertEqual((status, headers["content-encoding"]), (200, "gzip"), accepted)
                self.assertEqual(gzip.decompress(body), plain)
                self.assertEqual(headers["vary"], "Accept-Encoding")
                self.assertEqual(headers["content-type"], plain_headers["content-type"])
                self.assertEqual("set-cookie" in headers, "set-cookie" in plain_headers)
                self.assertEqual(headers["cache-control"], "no-store")
                self.assertIn("default-src 'self'", headers["content-security-policy"])
            for accepted in ("identity", "gzip;q=0", "gzip;q=0.000", "xgzip", "br"):
                _, headers, body = self.server.request(path, headers={"Accept-Encoding": accepted})
                self.assertNotIn("content-encoding", headers, accepted)
                self.assertEqual(body, plain)
            _, headers, body = self.server.request(path, method="HEAD",
                                                   headers={"Accept-Encoding": "gzip"})
            self.assertEqual((headers["content-length"], body), (str(len(plain)), b""))
            self.assertNotIn("content-encoding", headers)
        status, headers, body = self.server.request("/download/mesh.ply",
                                                    headers={"Accept-Encoding": "gzip"})
        self.assertNotIn("content-encoding", headers)
        self.assertEqual((status, body), self.server.request("/download/mesh.ply")[::2])
        self.assertEqual(status, 200)

    def test_a_changed_file_is_compressed_again(self):
        gzip_only = {"Accept-Encoding": "gzip"}
        page = pathlib.Path(self.folder) / "page"
        for text in (b"// one\n", b"// another one\n" * 1000):
            (page / "main.js").write_bytes(text)
            body = self.server.request("/main.js", headers=gzip_only)[2]
            self.assertEqual(gzip.decompress(body), text)
        self.assertLess(len(body), 200)
        (page / "main.js").unlink()
        self.assertEqual(self.server.request("/main.js", headers=gzip_only)[0], 404)

    def test_methods_and_upgrades_that_do_not_fit_are_refused(self):
        self.assertEqual(self.server.request("/", method="POST", body=b"x")[0], 405)
        self.assertEqual(self.server.request("/upload")[0], 405)
        self.assertEqual(self.server.request("/socket")[0], 426)
        for upgrade in ("h2c", "ftp"):
            with self.assertRaises((Refused, Closed)):
                WebSocket(self.server.url, headers={"Upgrade": upgrade})
        self.join()

    def test_a_head_of_nonsense_is_refused_and_others_go_on(self):
        for nonsense in (b"\r\n\r\n", b"GET\r\n\r\n", b"\x16\x03\x01" * 100, b"GET / HTTP/1.1\r\n",
                         b"GET /?" + b"a" * 20_000 + b" HTTP/1.1\r\n\r\n",
                         b"GET / HTTP/1.1\r\nCookie: " + b"c" * 20_000 + b"\r\n\r\n"):
            connection = connect_to(self.server.url)
            connection.sendall(nonsense)
            connection.close()
        self.sync(self.join())

    def test_bodies_whose_length_is_unclear_are_refused(self):
        """No second request is smuggled in behind the first one."""
        parts = urllib.parse.urlsplit(self.server.url)
        inner = f"GET /?{parts.query} HTTP/1.1\r\nHost: {parts.netloc}\r\n\r\n"
        for lines, body in (
                ([f"Content-Length: {1 << 63}"], ""), (["Content-Length: -1"], inner),
                (["Content-Length: 3", "Content-Length: 4"], "abc" + inner),
                (["Content-Length: 5", "Transfer-Encoding: chunked"], "0\r\n\r\n" + inner),
                (["Transfer-Encoding: chunked"], "0\r\n\r\n" + inner)):
            connection = connect_to(self.server.url)
            self.addCleanup(connection.close)
            head = "\r\n".join([f"POST /upload?name=a&batch=b&{parts.query} HTTP/1.1",
                                f"Host: {parts.netloc}", *lines])
            connection.sendall(f"{head}\r\n\r\n{body}".encode())
            connection.shutdown(socket.SHUT_WR)
            got = all_from(connection)
            self.assertIn(got.split(b" ")[1], (b"411", b"413"), lines)
            self.assertNotIn(b"<h1>page</h1>", got, lines)
        self.sync(self.join())

    def test_downloads_are_plain_files(self):
        folder = pathlib.Path(self.folder, "downloads")
        (folder / "link").symlink_to("../secret")
        (folder / "folder").mkdir()
        os.mkfifo(folder / "fifo")
        for name in ("link", "folder", "folder/", "fifo", "nothing"):
            self.assertEqual(self.server.request(f"/download/{name}")[0], 404, name)

    def test_a_watcher_does_not_learn_which_downloads_exist(self):
        token = urllib.parse.urlsplit(self.server.watch_url).query
        for name in ("mesh.ply", "nothing"):
            status, _, body = self.server.request(f"/download/{name}?{token}", token=False)
            self.assertEqual((status, body), (403, b"A view-only address cannot download files.\n"))


class Messages(Case):
    def test_texts_go_to_the_viewer_that_asked_or_to_all(self):
        first, second = self.join(), self.join(self.server.watch_url)
        self.assertEqual(self.server.event(), "joined 1 driver")
        self.assertEqual(self.server.event(), "joined 2 watcher")
        self.assertEqual(self.ask(first, echo="\u00e4"), {"echo": "\u00e4"})
        first.send('{"say":1}')
        self.assertEqual(json.loads(second.receive()), {"say": 1})
        second.close()
        self.assertEqual(self.server.event(), "left 2")
        third = self.join()
        self.assertEqual(self.server.event(), "joined 3 driver")
        third.send('{"binary":100000}')
        self.assertEqual(third.receive(), b"b" * 100_000)

    def test_a_viewer_is_pinged_when_it_joins_to_measure_the_latency(self):
        viewer = self.join()
        self.sync(viewer)
        while not viewer.pings:
            self.sync(viewer)
        self.assertEqual(viewer.pings, [b"p"])

    def test_fragments_make_one_message(self):
        viewer = self.join()
        viewer.send_frame(TEXT, b'{"echo":', final=False)
        viewer.send_frame(0, b'"whole"}')
        self.assertEqual(json.loads(viewer.receive()), {"echo": "whole"})

    def test_a_message_of_64_kib_passes_a_longer_one_closes(self):
        viewer = self.join()
        text = json.dumps({"echo": "x" * (65536 - 12)})
        self.assertEqual(len(text), 65536)
        viewer.send(text)
        self.assertEqual(len(json.loads(viewer.receive())["echo"]), 65536 - 12)
        viewer.send("x" * 65537)
        self.assertIn("65536", self.closed(1009, viewer))
        viewer = self.join()
        viewer.send("x" * 20_000_000)  # Most of it comes after the reason is known.
        self.assertIn("65536", self.closed(1009, viewer))
        self.sync(self.join())

    def test_bytes_and_what_is_no_utf8_close(self):
        viewer = self.join()
        viewer.send_frame(BINARY, b"12")
        self.closed(1003, viewer)
        viewer = self.join()
        viewer.send_frame(TEXT, b"\xff\xfe")
        self.closed(1007, viewer)

    def test_frames_that_are_none_close(self):
        good = masked_frame(TEXT, b'{"echo":1}')
        for frame in (bytes([good[0] | 0x40]) + good[1:],        # A reserved bit.
                      bytes([0x83]) + good[1:],                  # A reserved opcode.
                      bytes([0x81, 0xff]) + b"\x7f" + b"\xff" * 7 + bytes(70_000),
                      bytes([0x81, 0xff]) + b"\xff" * 8 + bytes(4),  # Longer than any frame.
                      bytes([0x89, 0xfe, 0x00, 0x80]) + bytes(4 + 128),  # A long ping.
                      masked_frame(0, b"no begin")):
            viewer, other = self.join(), self.join()
            viewer.socket.sendall(frame)
            with self.assertRaises((Closed, ConnectionResetError), msg=frame[:12]):
                while True:
                    viewer.receive()
            self.sync(other)
            other.close()

    def test_a_flood_closes_its_viewer_alone(self):
        flood, other = self.join(), self.join()
        flood.send_frames([(TEXT, b'{"flood":1}')] * 20_000)  # Some come after the reason is known.
        self.assertIn("400 messages per second", self.closed(1008, flood))
        self.sync(other)

    def test_a_viewer_that_does_not_read_is_closed_and_others_go_on(self):
        deaf, other = self.join(receive_buffer=4096), self.join()
        for _ in range(20):
            try:
                deaf.send('{"texts":[100,10000]}')
            except (BrokenPipeError, ConnectionResetError):
                pass  # Closed by now.
            self.sync(other)
        self.assertEqual([self.server.event()[:6] for _ in range(2)], ["joined"] * 2)
        self.assertEqual(self.server.event(), "left 1")
        self.sync(other)


if __name__ == "__main__":
    main()
