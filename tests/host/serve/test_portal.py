#!/usr/bin/env python3
"""The server behind a portal that adds a prefix to its paths: test_portal.py ECHO_SERVER."""
import pathlib
import subprocess
import sys
import urllib.parse

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import server_case  # noqa: E402
from portal import Portal  # noqa: E402
from websocket_client import Refused, WebSocket  # noqa: E402

NAME = "portal.example.edu"
KINDS = ("/rnode/localhost", "/node/localhost")


class BehindAPortal(server_case.Case):
    def setUp(self):
        super().setUp()
        self.portal = Portal()
        self.addCleanup(self.portal.close)
        self.plain, self.server = self.server, server_case.EchoServer(
            self.folder, "allow-host", f"{NAME}:8443", "allow-host", "Other.Example")
        self.addCleanup(lambda: self.assertEqual(self.plain.stop(), (0, "")))

    def prefix(self, kind, server=None):
        parts = urllib.parse.urlsplit((server or self.server).url)
        return f"{kind}/{parts.port}", parts.query.partition("=")[2]

    def ask(self, path, **headers):
        """One request to the portal, as a browser sends it."""
        portal = server_case.EchoServer.request
        self.url = f"http://127.0.0.1:{self.portal.port}/"
        return portal(self, path, token=False, headers={"Host": NAME + ":8443", **headers})

    def test_page_files_and_socket_have_paths_behind_the_prefix(self):
        for kind in KINDS:
            prefix, token = self.prefix(kind)
            status, headers, body = self.ask(f"{prefix}/?token={token}")
            self.assertEqual((status, body), (200, b"<h1>page</h1>"), kind)
            cookie, *flags = headers["set-cookie"].split("; ")
            self.assertEqual(flags, ["HttpOnly", "SameSite=Strict"])
            for path in ("/", "/main.js"):
                self.assertEqual(self.ask(prefix + path, Cookie=cookie)[0], 200, kind + path)
                self.assertEqual(self.ask(prefix + path)[0], 403, kind + path)
            # A cookie of a download would belong to its folder.
            for name in ("mesh.ply", "index.html"):
                (pathlib.Path(self.folder) / "downloads" / name).touch()
                status, headers, _ = self.ask(f"{prefix}/download/{name}?token={token}")
                self.assertEqual((status, headers["set-cookie"]), (200, None), name)
            self.assertEqual(self.ask(prefix + "/nothing", Cookie=cookie)[0], 404)
            for path in ("/../secret", "/download/..%2fsecret", "/%2e%2e/%2e%2e/secret"):
                self.assertIn(self.ask(prefix + path, Cookie=cookie)[0], (400, 403, 404), path)
            for origin in (f"https://{NAME}:8443", f"http://{NAME}:8443", "https://other.example"):
                self.join(f"http://127.0.0.1:{self.portal.port}/", path=prefix + "/socket",
                          token=token, headers={"Cookie": cookie, "Origin": origin})

    def test_an_upload_passes_the_portal(self):
        for kind in KINDS:
            prefix, token = self.prefix(kind)
            self.url = f"http://127.0.0.1:{self.portal.port}/?token={token}"
            post = server_case.EchoServer.request
            body = bytes(range(256)) * 1000
            batch = kind.strip("/").replace("/", "-")
            self.assertEqual(post(self, f"{prefix}/upload?name=a.nrrd&batch={batch}", "POST",
                                  body=body)[0], 200)
            self.assertEqual(post(self, f"{prefix}/upload/done?batch={batch}", "POST")[0], 200)
        stored = [path.read_bytes() for path in pathlib.Path(self.folder).rglob("a.nrrd")]
        self.assertEqual(stored, [body, body])

    def test_a_missing_slash_is_added_where_the_server_sees_it(self):
        prefix, token = self.prefix("/node/localhost")
        status, headers, _ = self.ask(f"{prefix}?token={token}")
        self.assertEqual((status, headers["location"]), (302, f"{prefix}/?token={token}"))
        self.assertEqual(self.ask(prefix)[0], 403)
        port = prefix.rpartition("/")[2]
        # The library makes one slash of several, so the first address stays on this server.
        there = f"/evil.example/{port}/?token={token}"
        for path, expected in ((f"//evil.example/{port}", (302, there)),
                               (f"/%2f/evil.example/{port}", (302, there)),
                               (f"/a%0d%0aX:1/{port}", (403, None)),  # No token after the line.
                               (f"/\\evil.example/{port}", (404, None)),
                               (f"/%5cevil.example/{port}", (404, None))):
            status, headers, _ = self.server.request(path)
            self.assertEqual((status, headers["location"]), expected, path)
            self.assertNotRegex(headers.get("location", "/"), r"^(//|/\\|[a-z]+:)", path)
            self.assertNotIn("x", headers)

    def test_other_origins_and_hosts_stay_refused(self):
        for server, origin in ((self.server, "https://evil.example"),
                               (self.server, f"https://{NAME}"),
                               (self.server, f"https://{NAME}:8443.evil.example"),
                               (self.plain, f"https://{NAME}:8443")):
            prefix, token = self.prefix("/rnode/localhost", server)
            with self.assertRaises(Refused) as refused:
                WebSocket(f"http://127.0.0.1:{self.portal.port}/", path=prefix + "/socket",
                          token=token, headers={"Origin": origin})
            self.assertEqual(refused.exception.status, 403, origin)
        for server, status in ((self.server, 200), (self.plain, 403)):
            token = self.prefix("", server)[1]
            for host in (f"{NAME}:8443", f"{NAME}:1", NAME.upper()):
                got = server.request(f"/?token={token}", token=False, headers={"Host": host})[0]
                self.assertEqual(got, status, host)

    def test_what_is_no_host_is_refused(self):
        for wrong in ("https://portal.example", "portal.example/", "", "a b", "portal:", ":80",
                      "portal:8o"):
            done = subprocess.run(
                [server_case.ECHO_SERVER, "uploads", self.folder, "downloads", self.folder,
                 "allow-host", wrong], capture_output=True, text=True, timeout=20, check=False)
            self.assertEqual(done.returncode, 64, wrong)
            self.assertIn(f"--allow-host '{wrong}' is no host. Give the part", done.stderr)


if __name__ == "__main__":
    server_case.main()
