#!/usr/bin/env python3
"""`pxpl5 serve --sessions N` as a class meets it: test_class.py FOLDER_OF_BINARIES [words]."""
import calendar
import contextlib
import http.client
import json
import os
import pathlib
import random
import re
import select
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.parse

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "system/cli"))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import test_serve  # noqa: E402
from portal import Portal  # noqa: E402
from processes import children_of  # noqa: E402
from websocket_client import Closed, Refused, WebSocket  # noqa: E402

LIMIT_S, POLL_S = 90, 0.1


class Front:
    """The program that serves the class."""

    def __init__(self, folder, *words):
        self.process = subprocess.Popen(
            [test_serve.BINARIES / "pxpl5", "serve", "phantom:sphere", "--run-folder", folder,
             "--topology", "one-of-each", *words],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            env={**os.environ, "TMPDIR": str(folder.parent)})
        self.said = ""
        while "Ctrl-C" not in self.said:
            line = self.process.stdout.readline()
            assert line, self.process.communicate()[1]
            self.said += line
        self.url, = re.findall(r"http://\S+", self.said)
        assert "session 1 is ready: " in self.said, self.said
        self.parts = urllib.parse.urlsplit(self.url)

    def end(self, by=signal.SIGINT):
        """Exit code, what it has said since its start, and what it complained of."""
        self.process.send_signal(by)
        said, complaint = self.process.communicate(timeout=LIMIT_S)
        return self.process.returncode, said, complaint


def get(url, cookie=None, host=None):
    """One request: status, headers, body."""
    parts = urllib.parse.urlsplit(url)
    connection = http.client.HTTPConnection(parts.hostname, parts.port, timeout=LIMIT_S)
    headers = {"Cookie": cookie} if cookie else {}
    if host:
        headers["Host"] = host
    connection.request("GET", (parts.path or "/") + ("?" + parts.query if parts.query else ""),
                       headers=headers)
    answer = connection.getresponse()
    body = answer.read().decode()
    connection.close()
    return answer.status, answer.headers, body


def heading(answer):
    return re.search("<h1>(.*)</h1>", answer[2])[1]


class Class(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="pxpl5-class-test-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def front(self, *words):
        front = Front(self.folder / "runs", *words)

        def end():
            if front.process.poll() is None:
                front.end()
        self.addCleanup(end)
        return front

    def student(self, front):
        """The cookie of a browser that opens the address of the class for the first time."""
        status, headers, _ = get(front.url)
        self.assertEqual(status, 200)
        return headers["set-cookie"].split(";")[0]

    def until(self, front, cookie, fits):
        """Asks as the page does, until an answer fits."""
        end = time.monotonic() + LIMIT_S
        answer = get(front.url, cookie)
        while not fits(answer):
            self.assertLess(time.monotonic(), end, answer)
            with contextlib.suppress(subprocess.TimeoutExpired):
                front.process.wait(POLL_S)
                self.fail(front.process.communicate()[1])
            answer = get(front.url, cookie)
        return answer

    def session(self, front, cookie):
        """The address of the student's own session, once it is ready."""
        _, headers, _ = self.until(front, cookie, lambda answer: answer[0] == 302)
        there = urllib.parse.urljoin(front.url, headers["location"])
        status, headers, _ = get(there)
        self.assertEqual(status, 302)
        return headers["location"]

    def viewer(self, url):
        viewer = test_serve.Viewer(url)
        self.addCleanup(viewer.socket.close)
        return viewer

    def watch(self, pids):
        """Descriptors that become readable when these processes end."""
        watched = [os.pidfd_open(pid) for pid in pids]
        for each in watched:
            self.addCleanup(os.close, each)
        return watched

    def assert_end(self, watched):
        for each in watched:
            self.assertEqual(select.select([each], [], [], LIMIT_S)[0], [each])

    def test_each_student_has_a_session_and_the_same_one_again(self):
        front = self.front("--sessions", "2")
        self.assertIn("2 sessions at the same time", front.said)
        self.assertIn("30 minutes without use", front.said)
        ann, bob, eve = (self.student(front) for _ in range(3))
        here, there = self.session(front, ann), self.session(front, bob)
        self.assertNotEqual(here, there)
        self.assertEqual(self.session(front, ann), here)
        answer = get(front.url, eve)
        self.assertEqual((answer[0], heading(answer)), (503, "All 2 sessions are taken"))
        # What one does, the other does not see.
        first, second = self.viewer(here), self.viewer(there)
        pictures = [viewer.resting(viewer.do(line)["revision"])["digest"]
                    for viewer, line in ((first, "background white"),
                                         (second, "background #010101"))]
        self.assertNotEqual(*pictures)
        states = [viewer.until(lambda message: "background" in message.get("state", {}))["state"]
                  for viewer in (self.viewer(here), self.viewer(there))]
        self.assertNotEqual(states[0]["background"], states[1]["background"])
        # A token opens its own session alone.
        for address, other in ((here, there), (here, front.url), (front.url, there)):
            parts = urllib.parse.urlsplit(address)
            token = urllib.parse.urlsplit(other).query
            self.assertEqual(get(f"http://{parts.netloc}/?{token}")[0], 403)
        # When one has ended, the next student gets its place.
        listed = subprocess.run([test_serve.BINARIES / "pxpl5", "sessions", "--json",
                                 "--run-folder", self.folder / "runs"], capture_output=True,
                                text=True, timeout=LIMIT_S, check=True)
        pids = [each["pid"] for each in json.loads(listed.stdout)["sessions"]]
        self.assertEqual(sorted(pids), sorted(children_of(front.process.pid)))
        os.kill(pids[0], signal.SIGTERM)
        self.session(front, eve)
        # The student who has lost the session is told once, and waits after that.
        answers = [get(front.url, cookie) for cookie in (ann, bob)]
        lost = [ann, bob][[status for status, _, _ in answers].index(200)]
        told, = [answer for answer in answers if answer[0] == 200]
        self.assertEqual(heading(told), "Your session has ended")
        self.assertIn("The session was asked to end, by", told[2])
        self.assertEqual(get(front.url, lost)[0], 503)
        nodes = self.watch(node for pid in children_of(front.process.pid)
                           for node in children_of(pid))
        code, said, complaint = front.end()
        self.assertEqual((code, complaint), (0, ""))
        self.assertRegex(said, r"session \d has ended: The session was asked to end, .* signal\. "
                         r"\(1 of 2 taken\)")
        self.assertGreaterEqual(len(nodes), 6)
        self.assert_end(nodes)
        self.assertEqual([each.name for each in self.folder.iterdir()], ["runs"])

    def test_strangers_get_nothing(self):
        front = self.front("--sessions", "1")
        base = f"http://{front.parts.netloc}"
        name = self.student(front).split("=")[0]
        for path, status in (("/", 403), ("/?token=" + "0" * 32, 403), ("/main.js", 404),
                             ("/4711/?token=" + "0" * 32, 403), ("/x/../../etc/passwd", 404),
                             ("/socket", 404)):
            self.assertEqual(get(base + path)[0], status, path)
        self.assertEqual(get(base, f"{name}={'0' * 32}")[0], 403)
        self.assertEqual(get(base, f"{name}=")[0], 403)
        self.assertEqual(get(front.url, host="evil.example")[0], 403)
        self.assertNotIn("set-cookie", get(front.url, host="evil.example")[1])
        with self.assertRaises((Refused, Closed)):
            WebSocket(front.url)
        with contextlib.closing(http.client.HTTPConnection(front.parts.netloc)) as connection:
            connection.request("HEAD", f"/?{front.parts.query}")
            self.assertEqual(connection.getresponse().status, 404)
        # A browser that keeps no cookies takes no session.
        for _ in range(3):
            self.assertEqual(get(front.url)[0], 200)
        self.assertEqual(front.end(signal.SIGTERM), (0, "", ""))

    def test_a_portal_leads_to_the_session(self):
        portal = Portal()
        self.addCleanup(portal.close)
        front = self.front("--sessions", "1", "--allow-host", "portal.example.edu")
        for kind in ("/rnode/localhost", "/node/localhost"):
            place = f"http://127.0.0.1:{portal.port}{kind}/{front.parts.port}/"
            _, headers, _ = get(f"{place}?{front.parts.query}", host="portal.example.edu")
            cookie = headers["set-cookie"].split(";")[0]
            self.until(front, cookie, lambda answer: answer[0] in (302, 503))
            status, headers, _ = get(f"{place}?{front.parts.query}", cookie,
                                     host="portal.example.edu")
            if kind == "/node/localhost":  # The one session has the other cookie.
                self.assertEqual(status, 503)
                continue
            there = urllib.parse.urljoin(place, headers["location"])
            self.assertRegex(there, rf"{kind}/\d+/\?token=")
            status, headers, body = get(there, host="portal.example.edu")
            self.assertEqual(status, 200)
            self.assertIn("pxpl5", body)

    def test_a_session_that_nobody_uses_ends(self):
        front = self.front("--sessions", "1", "--idle-limit", "0:04")
        self.assertIn("4 seconds without use", front.said)
        cookie = self.student(front)
        viewer = self.viewer(self.session(front, cookie))
        ends = viewer.until(lambda message: message.get("state", {}).get("end"))["state"]["end"]
        self.assertTrue(ends["why"].startswith("it has not been used for"))
        _, _, body = self.until(front, cookie, lambda answer: answer[0] == 200)
        self.assertIn("The session has ended after 4 seconds without use. Reload",
                      body)
        # A new one begins after that.
        self.session(front, cookie)
        self.assertEqual(front.end()[::2], (0, ""))

    def test_a_session_that_takes_too_much_memory_ends(self):
        # More than the host alone needs, so that the nodes count, too.
        front = self.front("--sessions", "1", "--memory-limit", "18MiB")
        self.assertIn("more than 0.0176 GiB of memory", front.said)
        cookie = self.student(front)
        get(front.url, cookie)
        _, _, body = self.until(front, cookie,
                                lambda answer: "Your session has ended" in answer[2])
        self.assertRegex(body, r"The session uses [\d.]+ GiB of memory, more than its limit of "
                               r"0\.0176 GiB\. Reload")
        self.assertEqual(front.end()[0], 0)

    def test_sessions_end_with_a_front_that_is_killed(self):
        front = self.front("--sessions", "1")
        self.session(front, self.student(front))
        session, = children_of(front.process.pid)
        watched = self.watch([session, *children_of(session)])
        self.assertGreaterEqual(len(watched), 4)
        self.assertLess(front.end(signal.SIGKILL)[0], 0)
        self.assert_end(watched)

    def logs_of_classes(self):
        return list(self.folder.glob("pxpl5-class-*"))

    def test_the_logs_of_a_class_that_was_killed_go_with_the_next_start(self):
        dead, alive = (self.front("--sessions", "1") for _ in range(2))
        both = self.logs_of_classes()
        self.assertEqual(len(both), 2)
        self.assertLess(dead.end(signal.SIGKILL)[0], 0)
        for folder in both:
            os.utime(folder, (1, 1))
        other = self.front("--sessions", "1")
        left = self.logs_of_classes()
        self.assertEqual(len(left), 2)
        self.assertEqual(len(set(left) & set(both)), 1)
        self.assertEqual(other.end()[0], 0)
        self.assertEqual(alive.end()[0], 0)
        self.assertEqual(self.logs_of_classes(), [])

    def test_a_class_that_cannot_work_does_not_start(self):
        port = str(self.three_free_ports())
        for volume, words, code, reason in (
                ("phantom:sphere", ("--surface", "ball=nothing"), 64, "nothing"),
                ("phantom:sphere", ("--port", port), 69, "Address already in use"),
                ("/nowhere.nrrd", (), 65, "No such file")):
            with socket.socket() as other:
                if "--port" in words:
                    other.bind(("127.0.0.1", int(words[1]) + 1))
                    other.listen()
                done = subprocess.run(
                    [test_serve.BINARIES / "pxpl5", "serve", volume, "--sessions", "2",
                     "--run-folder", self.folder / "runs", *words], capture_output=True, text=True,
                    timeout=LIMIT_S, check=False)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertRegex(done.stderr, "error: the first session of the class cannot start: .*"
                             + reason)

    def three_free_ports(self):
        """The first of three ports below those that the kernel gives to other programs."""
        given = int(pathlib.Path("/proc/sys/net/ipv4/ip_local_port_range").read_text().split()[0])
        end = max(given, 10_000)
        for port in random.sample(range(end - 5000, end - 3), 100):
            try:
                with contextlib.ExitStack() as probes:
                    for each in range(port, port + 3):
                        probes.enter_context(socket.socket()).bind(("127.0.0.1", each))
                return port
            except OSError:
                continue
        return self.fail("no three adjacent ports are free")

    def test_ports_follow_that_of_the_class(self):
        port = self.three_free_ports()
        front = self.front("--sessions=2", f"--port={port}")
        self.assertEqual(front.parts.port, port)
        with socket.socket() as other:  # A program that has a port of the class.
            other.bind(("127.0.0.1", port + 2))
            other.listen()
            ann, bob = self.student(front), self.student(front)
            self.assertIn(f":{port + 1}/", self.session(front, ann))
            get(front.url, bob)
            _, _, body = self.until(front, bob, lambda answer: "has ended" in answer[2])
            self.assertIn(f"port {port + 2}: Address already in use.", body)

    def test_a_killed_session_names_the_signal(self):
        front = self.front("--sessions", "1")
        cookie = self.student(front)
        self.session(front, cookie)
        os.kill(children_of(front.process.pid)[0], signal.SIGKILL)
        _, _, body = self.until(front, cookie, lambda answer: "has ended" in answer[2])
        self.assertIn("session 1 was killed by signal 9 (SIGKILL). Reload", body)
        self.session(front, cookie)

    def test_the_time_limit_is_that_of_the_class(self):
        front = self.front("--sessions", "2", "--time-limit", "1:50")
        ann, bob = self.student(front), self.student(front)
        ends = []
        for cookie in (ann, bob):  # The second session starts later.
            viewer = self.viewer(self.session(front, cookie))
            ends.append(viewer.until(lambda message: message.get("state", {}).get("end"))
                        ["state"]["end"])
        self.assertEqual([end["why"] for end in ends], ["--time-limit is reached"] * 2)
        times = [calendar.timegm(time.strptime(end["at"], "%Y-%m-%dT%H:%M:%SZ")) for end in ends]
        self.assertLessEqual(abs(times[0] - times[1]), 1)

    def test_a_time_limit_of_weeks_reaches_the_sessions(self):
        front = self.front("--sessions", "1", "--time-limit", "20-0")
        self.session(front, self.student(front))

    def test_no_limit_of_time_without_use(self):
        front = self.front("--sessions", "1", "--idle-limit", "0")
        self.assertIn("each ends when it uses more than", front.said)
        self.session(front, self.student(front))

    def test_the_end_of_a_job_is_passed_on(self):
        front = self.front("--sessions", "2")
        viewer = self.viewer(self.session(front, self.student(front)))
        late = self.student(front)
        get(front.url, late)  # This session only starts.
        front.process.send_signal(signal.SIGUSR1)
        for each in (viewer, None):
            each = each or self.viewer(self.session(front, late))
            ends = each.until(lambda message: message.get("state", {}).get("end"))["state"]["end"]
            self.assertEqual(ends["why"], "the program has received SIGUSR1")
        self.assertEqual(front.end()[0], 0)

    def test_wrong_options_are_refused(self):
        for words, told in ((("--sessions", "0"), "--sessions"),
                            (("--sessions", "201"), "--sessions"),
                            (("--sessions", "2", "--bind", "0.0.0.0"), "--insecure"),
                            (("--sessions", "2", "--idle-limit", "soon"),
                             "--idle-limit 'soon' is no duration"),
                            (("--sessions", "2", "--memory-limit", "much"), "--memory-limit"),
                            (("--sessions", "2", "--port", "65534"), "65535 to 65536"),
                            (("--sessions", "2", "--engine", "slurm"), "salloc")):
            done = subprocess.run([test_serve.BINARIES / "pxpl5", "serve", *words],
                                  capture_output=True, text=True, timeout=LIMIT_S, check=False)
            self.assertEqual(done.returncode, 64, (words, done.stderr))
            self.assertIn(told, done.stderr)


if __name__ == "__main__":
    test_serve.BINARIES = pathlib.Path(sys.argv.pop(1))
    unittest.main()
