#!/usr/bin/env python3
"""Tests access and the messages of a WebSocket: test_server.py ECHO_SERVER."""
import json
import os
import pathlib
import socket
import struct
import sys
import urllib.parse
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from server_case import Case, main  # noqa: E402
from websocket_client import (BINARY, TEXT, Closed, Refused, WebSocket, connect_to,
                              masked_frame)  # noqa: E402


class Access(Case):
    def test_a_token_opens_the_page_and_leaves_a_cookie(self):
        status, headers, body = self.server.request("/")
        self.assertEqual((status, body), (200, b"<h1>page</h1>"))
        cookie, *flags = headers["set-cookie"].split("; ")
        self.assertEqual(flags, ["HttpOnly", "SameSite=Strict"])
        for path in ("/", "/main.js", "/d3.js", "/download/mesh.ply"):
            self.assertEqual(self.server.request(path, token=False)[0], 403, path)
            with_cookie = self.server.request(path, token=False, headers={"Cookie": cookie})
            self.assertEqual(with_cookie[0], 200, path)
        self.join(token="", headers={"Cookie": cookie})
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

    def test_methods_and_upgrades_that_do_not_fit_are_refused(self):
        self.assertEqual(self.server.request("/", method="POST", body=b"x")[0], 405)
        self.assertEqual(self.server.request("/upload")[0], 405)
        self.assertEqual(self.server.request("/socket")[0], 426)
        for upgrade in ("h2c", "ftp"):
            with self.assertRaises((Refused, Closed)):
                WebSocket(self.server.url, headers={"Upgrade": upgrade})
        self.join()

    def test_a_head_of_nonsense_hurts_nobody(self):
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
            got = b""
            try:
                while more := connection.recv(65536):
                    got += more
            except ConnectionResetError:
                pass
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


class Strangers(Case):
    def silent(self, count):
        """Connections that send the begin of a request and no more."""
        connections = []
        for _ in range(count):
            connections.append(connect_to(self.server.url))
            connections[-1].sendall(b"GET / HTTP/1.1\r\nX-Slow: ")
        return connections

    def test_unfinished_requests_keep_no_viewer_out(self):
        crowd = self.silent(300)
        self.assertEqual(self.server.request("/")[0], 200)
        self.sync(self.join())
        for connection in crowd:
            connection.close()

    def test_an_unfinished_request_ends_by_itself_and_a_viewer_stays(self):
        viewer = self.join()
        slow, = self.silent(1)
        slow.settimeout(20)
        try:
            self.assertEqual(slow.recv(1), b"")  # Returns when the server has closed.
        except ConnectionResetError:
            pass
        slow.close()
        self.sync(viewer)

    def test_watchers_leave_a_place_for_a_driver(self):
        watchers = [self.join(self.server.watch_url) for _ in range(7)]
        eighth = WebSocket(self.server.watch_url)
        self.assertIn("7 watchers", self.closed(1013, eighth))
        driver = self.join()
        self.sync(driver)
        for watcher in watchers:
            watcher.close()


class Messages(Case):
    def test_texts_go_to_who_asked_and_to_all(self):
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

    def test_who_joins_is_pinged_to_learn_how_far_away_it_is(self):
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

    def test_a_ninth_viewer_waits_until_one_has_left(self):
        viewers = [self.join() for _ in range(8)]
        ninth = WebSocket(self.server.url)
        self.assertIn("8 viewers", self.closed(1013, ninth))
        for _ in range(8):
            self.assertTrue(self.server.event().startswith("joined"))
        viewers[0].close()
        self.assertEqual(self.server.event(), "left 1")
        self.join()
        self.assertEqual(self.server.event(), "joined 9 driver")

    def test_who_does_not_read_is_closed_and_hurts_nobody(self):
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


class Frames(Case):
    def show(self, viewer, revision, rests=False, size=(64, 48), depths=False, layers=False):
        viewer.send(json.dumps({"frame": [*size, revision, rests, depths, layers]}))

    def frame(self, viewer):
        """The next frame's header as a dict, and its picture."""
        message = viewer.receive()
        names = ("magic", "number", "revision", "width", "height", "kind", "quality", "samples",
                 "flags", "machine_ms", "digest", "moved_mm", "picture_bytes", "depth_bytes",
                 "pose", "views", "layers", "opacity", "reserved")
        head = dict(zip(names, struct.unpack("<IIIHHBBBBfQdIIIBBBB", message[:56])))
        self.assertEqual(len(message), 56 + head["picture_bytes"] + head["depth_bytes"])
        return head, message[56:]

    def shown(self, viewer, number):
        viewer.send(json.dumps({"shown": number}))

    def test_moving_frames_are_jpegs_and_resting_ones_pngs(self):
        viewer = self.join()
        self.show(viewer, 7)
        head, picture = self.frame(viewer)
        self.assertEqual((head["magic"], head["number"], head["revision"]), (0x46523550, 1, 7))
        self.assertEqual((head["width"], head["height"], head["kind"]), (64, 48, 1))
        self.assertEqual((head["flags"], head["digest"]), (0, 0))
        self.assertTrue(50 <= head["quality"] <= 90)
        self.assertEqual(picture[:2], b"\xff\xd8")
        self.show(viewer, 8, rests=True)
        head, picture = self.frame(viewer)
        self.assertEqual((head["number"], head["revision"], head["kind"]), (2, 8, 2))
        self.assertEqual((head["flags"], head["digest"]), (1, 8))
        self.assertEqual(picture[:8], b"\x89PNG\r\n\x1a\n")

    def test_depths_follow_the_picture_of_who_wants_them(self):
        plain, warps = self.join(), self.join()
        self.assertFalse(self.ask(plain, wants=0)["depths"])
        warps.send('{"depths":true}')
        self.assertTrue(self.ask(warps, wants=0)["depths"])
        for revision, rests in ((1, False), (2, True)):
            self.show(plain, revision, rests, depths=True)
            head, bytes_ = self.frame(plain)
            self.assertEqual((head["depth_bytes"], len(bytes_)), (0, head["picture_bytes"]))
            head, bytes_ = self.frame(warps)
            self.assertGreater(head["depth_bytes"], 0)
            depths = bytes_[head["picture_bytes"]:]  # Of one picture, after their length.
            self.assertEqual(depths[:4], struct.pack("<I", len(depths) - 4))
            lean = zlib.decompress(depths[4:], wbits=-15)
            # A bit per pixel, two bytes for each of the 17 x 13 corners, and a bit per cell.
            self.assertEqual(len(lean), 64 * 48 // 8 + 2 * 17 * 13 + 16 * 12 // 8)
            self.assertEqual(lean[:8], b"\xff" * 8)
            self.shown(plain, head["number"])
            self.shown(warps, head["number"])
        self.show(plain, 3)
        self.assertEqual(self.frame(warps)[0]["depth_bytes"], 0)
        warps.send('{"depths":false}')
        self.assertFalse(self.ask(warps, wants=0)["depths"])
        watcher = self.join(self.server.watch_url)  # It must not slow down the driver's machine.
        watcher.send('{"depths":true}')
        self.assertFalse(self.ask(warps, wants=0)["depths"])

    def test_layers_are_blended_for_who_wants_no_depths(self):
        plain, warps = self.join(), self.join()
        warps.send('{"depths":true}')
        self.sync(warps)
        self.show(plain, 1, depths=True, layers=True)
        flat, _ = self.frame(plain)
        self.assertEqual((flat["layers"], flat["opacity"], flat["depth_bytes"]), (1, 0, 0))
        head, bytes_ = self.frame(warps)
        self.assertEqual((head["layers"], head["opacity"], head["height"]), (2, 6, 48))
        self.assertGreater(head["depth_bytes"], 0)
        self.assertGreater(head["picture_bytes"], 1.5 * flat["picture_bytes"])
        first, = struct.unpack_from("<I", bytes_, head["picture_bytes"])
        second, = struct.unpack_from("<I", bytes_, head["picture_bytes"] + 4 + first)
        self.assertEqual(head["depth_bytes"], 8 + first + second)

    def test_layers_of_the_resting_picture_go_to_who_warps(self):
        plain, warps = self.join(), self.join()
        warps.send('{"depths":true}')
        self.sync(warps)
        self.show(plain, 1, rests=True)
        self.show(plain, 1, depths=True, layers=True)
        heads = [self.frame(warps)[0] for _ in range(2)]
        self.assertEqual([(head["number"], head["flags"], head["layers"]) for head in heads],
                         [(1, 1, 1), (2, 0, 2)])
        late = self.join()
        self.assertEqual(self.frame(late)[0]["flags"], 1)
        late.send('{"depths":true}')
        self.assertEqual(self.frame(late)[0]["layers"], 2)
        self.assertEqual(self.frame(plain)[0]["flags"], 1)
        self.shown(plain, 1)
        self.shown(warps, 2)
        self.show(plain, 2)
        self.assertEqual([self.frame(each)[0]["revision"] for each in (plain, warps)], [2, 2])

    def test_who_does_not_show_frames_gets_two_and_then_the_newest(self):
        viewer = self.join()
        for revision in (1, 2):
            self.show(viewer, revision)
            self.assertEqual(self.frame(viewer)[0]["revision"], revision)
        self.assertFalse(self.ask(viewer, wants=0)["wants"])
        for revision in range(3, 40):
            self.show(viewer, revision)
        self.show(viewer, 40, rests=True)
        self.sync(viewer)  # Nothing but the answer has come.
        self.shown(viewer, 2)
        head, _ = self.frame(viewer)
        self.assertEqual((head["number"], head["revision"], head["flags"]), (3, 40, 1))
        self.assertTrue(self.ask(viewer, wants=0)["wants"])

    def test_a_stalled_viewer_gets_the_newest_in_the_end_and_holds_nobody_up(self):
        stalled, other = self.join(receive_buffer=1 << 17), self.join()
        size = (640, 512)
        for revision in range(1, 61):
            self.show(other, revision, rests=revision == 60, size=size)
            head, _ = self.frame(other)
            self.assertEqual((head["number"], head["revision"]), (revision, revision))
            self.shown(other, head["number"])
        seen = [self.frame(stalled)[0]["revision"] for _ in range(2)]
        self.shown(stalled, 2)
        seen.append(self.frame(stalled)[0]["revision"])
        self.assertEqual((seen[0], seen[-1]), (1, 60))

    def test_who_comes_late_or_again_gets_the_newest_frame(self):
        viewer = self.join()
        self.show(viewer, 5, rests=True)
        self.assertEqual(self.frame(viewer)[0]["number"], 1)
        viewer.close()
        again = self.join()
        head, _ = self.frame(again)
        self.assertEqual((head["number"], head["revision"]), (1, 5))

    def pair(self, viewer, revision, pose, wearer=1, size=(64, 48)):
        viewer.send(json.dumps({"frame": [*size, revision, False, True, pose, wearer]}))

    def test_a_pair_goes_to_who_wears_the_headset_and_frames_to_the_others(self):
        wearer, other = self.join(), self.join()
        self.pair(other, 1, 16)  # Nobody wears a headset yet.
        other.send('{"wear":[1,6144]}')
        self.sync(other)
        self.assertTrue(self.ask(other, wants=0)["pair"])
        self.pair(other, 2, 17)
        head, bytes_ = self.frame(wearer)
        self.assertEqual((head["number"], head["revision"], head["pose"]), (1, 2, 17))
        self.assertEqual((head["views"], head["width"], head["height"]), (2, 64, 48))
        depths = bytes_[head["picture_bytes"]:]  # Of two pictures, though it did not ask.
        left = 4 + struct.unpack("<I", depths[:4])[0]
        self.assertEqual(len(depths), left + 4 + struct.unpack("<I", depths[left:left + 4])[0])
        self.show(other, 3)
        self.assertEqual(self.frame(other)[0]["revision"], 3)
        self.pair(other, 4, 18)
        head, _ = self.frame(wearer)  # It has not had revision 3.
        self.assertEqual((head["number"], head["revision"], head["pose"]), (2, 4, 18))
        wants = self.ask(other, wants=0)  # The wearer has two to acknowledge, the other has one.
        self.assertEqual((wants["wants"], wants["pair"]), (True, False))
        self.pair(other, 5, 19)
        self.pair(other, 6, 20)
        self.sync(other)
        self.shown(wearer, 2)
        self.assertEqual(self.frame(wearer)[0]["pose"], 20)  # The newest.
        self.shown(wearer, 3)
        self.sync(wearer)
        other.send('{"wear":[0,0]}')
        head, _ = self.frame(wearer)
        self.assertEqual((head["revision"], head["pose"], head["views"]), (3, 0, 1))
        self.assertFalse(self.ask(other, wants=0)["pair"])

    def test_a_wearer_who_leaves_wants_no_pair_and_holds_nobody_up(self):
        wearer, other = self.join(), self.join()
        other.send('{"wear":[1,6144]}')
        self.sync(other)
        wearer.close()
        self.assertEqual([self.server.event() for _ in range(3)][-1], "left 1")
        self.assertFalse(self.ask(other, wants=0)["pair"])
        self.pair(other, 2, 17)
        self.show(other, 3)
        self.assertEqual(self.frame(other)[0]["revision"], 3)

    def test_nobody_wants_frames_where_nobody_is(self):
        viewer = self.join()
        self.assertTrue(self.ask(viewer, wants=0)["wants"])
        self.shown(viewer, 4_000_000_000)  # Never sent: no harm.
        viewer.send('{"shown":-1}')
        self.assertTrue(self.ask(viewer, wants=0)["wants"])


if __name__ == "__main__":
    main()
