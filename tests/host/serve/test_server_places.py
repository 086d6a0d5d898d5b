#!/usr/bin/env python3
"""Tests who gets a place, and how long: test_server_places.py ECHO_SERVER."""
import json
import pathlib
import socket
import sys
import time
import urllib.parse

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from server_case import Case, EchoServer, main  # noqa: E402
from websocket_client import Closed, WebSocket, connect_to  # noqa: E402


def silent_at(url, count):
    """Connections that send the begin of a request and no more."""
    connections = []
    for _ in range(count):
        connections.append(connect_to(url))
        connections[-1].sendall(b"GET / HTTP/1.1\r\nX-Slow: ")
    return connections


def own_address():
    """An address of this computer by which others reach it; empty if it has none."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # Sends nothing.
            return probe.getsockname()[0]
        except OSError:
            return ""


class Strangers(Case):
    def silent(self, count):
        return silent_at(self.server.url, count)

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

    def test_a_driver_takes_the_place_of_a_driver_that_is_silent(self):
        self.join()  # It answers no ping, as if its computer were off.
        watchers = [self.join(self.server.watch_url) for _ in range(7)]
        for _ in range(8):
            self.assertTrue(self.server.event().startswith("joined"))
        refusals, deadline = 0, time.monotonic() + 40
        while time.monotonic() < deadline:
            driver = WebSocket(self.server.url)
            try:
                self.assertIn("hello", json.loads(driver.receive()))
                break
            except Closed as full:
                self.assertEqual(full.code, 1013)
                refusals += 1
        self.assertGreater(refusals, 0)
        events = {self.server.event() for _ in range(2)}
        self.assertIn("left 1", events)
        self.sync(driver)
        driver.close()
        for watcher in watchers:
            watcher.close()

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


class OneAddress(Case):
    """Viewers of one other computer, or behind one router: the server sees one address."""

    def setUp(self):
        address = own_address()
        if not address or address.startswith("127."):
            self.skipTest("this computer has no address but that of the loopback")
        super().setUp()
        self.plain, self.server = self.server, EchoServer(self.folder, "bind", "0.0.0.0",
                                                          "insecure", "1")
        self.addCleanup(lambda: self.assertEqual(self.plain.stop(), (0, "")))
        for name in ("url", "watch_url"):
            parts = urllib.parse.urlsplit(getattr(self.server, name))
            setattr(self.server, name, parts._replace(netloc=f"{address}:{parts.port}").geturl())

    def test_two_watch_and_a_third_does_not(self):
        watchers = [self.join(self.server.watch_url) for _ in range(2)]
        self.assertIn("2 watchers of this computer",
                      self.closed(1013, WebSocket(self.server.watch_url)))
        driver = self.join()
        for viewer in (*watchers, driver):
            self.sync(viewer)
        watchers[0].close()
        for _ in range(4):
            event = self.server.event()
        self.assertEqual(event, "left 1")
        self.sync(self.join(self.server.watch_url))

    def test_a_crowd_of_strangers_keeps_neither_of_two_watchers_out(self):
        watchers = []
        for _ in range(2):
            crowd = silent_at(self.server.url, 40)  # More than may come from one address.
            watchers.append(self.join(self.server.watch_url))
            for connection in crowd:
                self.addCleanup(connection.close)
        for watcher in watchers:
            self.sync(watcher)

    def test_strangers_of_one_address_leave_room_for_another(self):
        crowd = silent_at(self.server.url, 300)
        local = self.server.watch_url.replace(own_address(), "127.0.0.1")
        self.sync(self.join(local))
        self.sync(self.join(self.server.watch_url))
        for connection in crowd:
            connection.close()


if __name__ == "__main__":
    main()
