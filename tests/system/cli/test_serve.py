#!/usr/bin/env python3
"""`pxpl5 serve` as a viewer meets it: test_serve.py FOLDER_OF_BINARIES [unittest's words]."""
import json
import os
import pathlib
import re
import signal
import struct
import subprocess
import sys
import tempfile
import unittest
import urllib.parse
import urllib.request

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "host/serve"))
from websocket_client import Refused, WebSocket  # noqa: E402

BINARIES = pathlib.Path()  # From the command line.
HEADER = struct.Struct("<IIIHHBBBBfQdII")


class Program:
    """The program under test, in a run folder of its own."""

    def __init__(self, folder, *words):
        self.folder = folder
        self.process = subprocess.Popen(
            [BINARIES / "pxpl5", "serve", "--run-folder", folder, "--topology", "one-of-each",
             *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.said = ""
        while "Ctrl-C" not in self.said:
            line = self.process.stdout.readline()
            assert line, self.process.communicate()[1]
            self.said += line
        self.url, self.watch_url = re.findall(r"http://\S+", self.said)[:2]

    def stop(self, by=signal.SIGINT):
        """Its exit code and what it complained of."""
        self.process.send_signal(by)
        _, complaint = self.process.communicate(timeout=60)  # Closes the pipes, too.
        return self.process.returncode, complaint

    def end(self):
        """After a test that failed, too."""
        if self.process.poll() is None:
            self.stop()

    def nodes(self, name):
        """Process ids of the nodes of that name that run in this run folder."""
        found = []
        for entry in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                # Another program's arguments may be any bytes.
                command = (entry / "cmdline").read_text(errors="replace").split("\0")
                parent = (entry / "stat").read_text(errors="replace").rsplit(")", 1)[1].split()[1]
            except (FileNotFoundError, ProcessLookupError, PermissionError):
                continue
            if command[0].endswith(name) and parent == str(self.process.pid):
                found.append(int(entry.name))
        return found

    def get(self, path):
        with urllib.request.urlopen(
                urllib.parse.urljoin(self.url, path) + "?" + urllib.parse.urlsplit(self.url).query,
                timeout=20) as answer:
            return answer.read()


class Viewer:
    """Speaks the protocol; acknowledges frames as a page does."""

    def __init__(self, url):
        self.socket = WebSocket(url)
        self.texts, self.frames, self.next_id = [], [], 1

    def next(self):
        """The next message, noted: a text as an object, a frame as its header's fields."""
        message = self.socket.receive()
        if isinstance(message, str):
            self.texts.append(json.loads(message))
            return self.texts[-1]
        magic, number, revision, width, height, kind, _, samples, flags, _, digest, *_ = \
            HEADER.unpack_from(message)
        assert magic == 0x46523550, hex(magic)
        self.socket.send(json.dumps({"shown": number}))
        self.frames.append({"revision": revision, "size": (width, height), "png": kind == 2,
                            "samples": samples, "rests": bool(flags & 1),
                            "digest": f"{digest:016x}", "bytes": message[HEADER.size:]})
        return self.frames[-1]

    def until(self, fits):
        message = self.next()
        while not fits(message):
            message = self.next()
        return message

    def send(self, line):
        self.next_id += 1
        self.socket.send(json.dumps({"id": self.next_id, "do": line}))
        return self.next_id

    def answer_to(self, number):
        return self.until(lambda message: message.get("re") == number)

    def do(self, line):
        return self.answer_to(self.send(line))

    def resting(self, revision):
        """The picture of one sample of that revision, or a newer one; it may have come already.

        On a busy computer a refined picture takes its place: then the picture is drawn again.
        """
        def fits(message):
            return message.get("rests") and message["revision"] >= revision
        frame = next((each for each in self.frames if fits(each) and each["samples"] == 1), None)
        frame = frame or self.until(fits)
        while frame["samples"] != 1:
            width, height = frame["size"]
            self.do(f"size {width + 1}x{height}")
            reply = self.do(f"size {width}x{height}")
            if not reply["ok"]:
                break  # A watcher takes what comes.
            revision = reply["revision"]
            frame = self.until(fits)
        return frame


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def program(self, *words):
        program = Program(self.folder.name, *words)
        self.addCleanup(program.end)
        return program

    def viewer(self, url):
        viewer = Viewer(url)
        self.addCleanup(viewer.socket.close)
        return viewer


class Serve(Case):
    def test_a_first_visit_shows_the_pelvis(self):
        program = self.program()
        viewer = self.viewer(program.url)
        self.assertEqual(viewer.next()["hello"]["role"], "driver")
        state = viewer.until(lambda message: "state" in message)["state"]
        self.assertEqual(state["volume"]["name"], "phantom:pelvis")
        self.assertEqual([surface["name"] for surface in state["surfaces"]], ["bone", "skin"])
        frame = viewer.resting(state["revision"])
        self.assertEqual((frame["size"], frame["png"]), ((512, 512), True))
        self.assertIn("ssh -L", program.said)
        self.assertEqual(program.stop(), (0, ""))

    def test_what_rests_is_the_picture_that_digest_tells_of(self):
        program = self.program("phantom:sphere", "--surface", "ball=0.2,red")
        viewer = self.viewer(program.url)
        viewer.do("size 200x160")
        reply = viewer.do("view 30 20 zoom=1.5 roll=20 pan=3,4")
        self.assertEqual(reply["result"]["roll_deg"], 20)
        frame = viewer.resting(reply["revision"])
        self.assertEqual(frame["size"], (200, 160))
        self.assertEqual(frame["digest"], viewer.do("digest")["result"]["frame"])

    def test_a_script_does_what_the_page_did(self):
        program = self.program("phantom:sphere")
        viewer = self.viewer(program.url)
        for line in ("size 120x100", "surface sphere iso=0.3", "view 10 20", "clip L 1", "undo",
                     "background white", "surface sphere opacity=0.5", "undo"):
            self.assertTrue(viewer.do(line)["ok"], line)
        script = viewer.do("history")["result"]["script"]
        told = viewer.do("digest")["result"]["frame"]
        again = subprocess.run([BINARIES / "pxpl5", "run", "-", "--json", "--run-folder",
                                self.folder.name], input=script + "digest\n", text=True,
                               capture_output=True, check=True)
        last = json.loads(again.stdout.splitlines()[-1])
        self.assertEqual(last["result"]["frame"], told)

    def test_a_flood_ends_with_the_newest_state_on_show(self):
        program = self.program("phantom:sphere")
        viewer = self.viewer(program.url)
        numbers = [viewer.send(f"surface sphere iso={0.001 * step:.3f}") for step in range(300)]
        replies = {}
        while numbers[-1] not in replies:
            message = viewer.next()
            if "re" in message:
                replies[message["re"]] = message
        self.assertTrue(replies[numbers[-1]]["ok"])
        self.assertEqual(replies[numbers[-1]]["result"]["isovalue"], 0.299)
        frame = viewer.resting(replies[numbers[-1]]["revision"])
        self.assertEqual(frame["digest"], viewer.do("digest")["result"]["frame"])

    def test_what_is_exported_can_be_fetched(self):
        program = self.program("phantom:sphere")
        viewer = self.viewer(program.url)
        reply = viewer.do("export download:ball.ply")
        self.assertEqual(reply["result"]["download"], "download/ball.ply")
        self.assertTrue(program.get("/download/ball.ply").startswith(b"ply"))
        for name in ("../x.ply", ".x.ply", "a/b.ply"):
            self.assertIn("is no name", viewer.do(f"export download:{name}")["error"])
        self.assertIn("export ball.ply", viewer.do("history")["result"]["script"])

    def test_a_dead_node_is_told_of_and_the_session_goes_on(self):
        program = self.program("phantom:sphere")
        viewer = self.viewer(program.url)
        reply = viewer.do("view 30 20")
        before = viewer.resting(reply["revision"])["digest"]
        (node,) = program.nodes("pxpl5-gp")
        os.kill(node, signal.SIGKILL)
        note = viewer.until(lambda message: "note" in message)["note"]
        self.assertRegex(note["text"], "gp-0 was killed by signal 9")
        viewer.until(lambda message: "The machine runs again" in str(message.get("note")))
        self.assertEqual(viewer.resting(reply["revision"] + 1)["digest"], before)
        self.assertTrue(viewer.do("undo")["ok"])
        self.assertEqual(program.stop()[0], 0)

    def test_the_terminal_tells_a_death_and_the_restart(self):
        """Also if no viewer is connected."""
        program = self.program("phantom:sphere")
        os.kill(program.nodes("pxpl5-gp")[0], signal.SIGKILL)
        self.assertRegex(program.process.stderr.readline(),
                         r"^warning: gp-0 was killed by signal 9 \(SIGKILL\) \(log: .*"
                         r"\. The machine is started again \(restart 1 of 3\)$")
        self.assertRegex(program.process.stderr.readline(),
                         r"^note: The machine runs again with 1 GP, 1 Renderer\. Everything is "
                         r"restored after \d+ ms$")
        self.assertEqual(program.stop()[0], 0)

    def test_a_signal_during_a_restart_ends_the_program_as_at_any_time(self):
        for number in (signal.SIGTERM, signal.SIGINT):
            program = self.program("phantom:sphere")
            (uploads,) = pathlib.Path(program.folder).glob("*/uploads")
            (uploads / "scan.nii").write_bytes(b"x")
            os.kill(program.nodes("pxpl5-gp")[0], signal.SIGKILL)
            self.assertTrue(any("The machine is started again" in line
                                for line in program.process.stderr))
            self.assertEqual(program.stop(number)[0], 0)
            self.assertFalse(uploads.exists())

    def test_the_session_is_saved_if_the_machine_cannot_be_started_again(self):
        program = self.program("phantom:sphere", "--set", "renderer.restart.max=0")
        viewer = self.viewer(program.url)
        self.assertTrue(viewer.do("surface extra iso=300")["ok"])
        os.kill(program.nodes("pxpl5-renderer")[0], signal.SIGKILL)
        _, complaint = program.process.communicate(timeout=60)
        self.assertEqual(program.process.returncode, 128 + signal.SIGKILL, complaint)
        (saved,) = re.findall(r"note: the session is saved in (\S+)\. Open it again with: "
                              r"pxpl5 serve --session \1\n", complaint)
        self.assertIn("renderer.restart.max is 0", complaint.splitlines()[-1])
        again = self.program("--session", saved)
        surfaces = self.viewer(again.url).until(lambda m: "state" in m)["state"]["surfaces"]
        self.assertIn("extra", [surface["name"] for surface in surfaces])

    def test_no_socket_of_the_server_is_open_in_a_node(self):
        """Also after a restart, when viewers are connected."""
        def sockets(pid):
            folder = pathlib.Path(f"/proc/{pid}/fd")
            return {link for link in map(os.readlink, folder.iterdir()) if "socket:" in link}

        program = self.program("phantom:sphere")
        viewer = self.viewer(program.url)
        self.assertTrue(viewer.do("kill gp-0")["ok"])
        viewer.until(lambda message: "The machine runs again" in str(message.get("note")))
        nodes = [pid for name in ("gp", "renderer", "framebuffer")
                 for pid in program.nodes(f"pxpl5-{name}")]
        self.assertEqual(len(nodes), 3)
        for node in nodes:
            self.assertTrue(sockets(node))
            self.assertEqual(sockets(node) & sockets(program.process.pid), set())

    def test_a_stopped_node_silences_nobody_and_can_be_killed(self):
        """The picture afterwards is the one before."""
        program = self.program("phantom:sphere", "--set", "heartbeat.interval_ms=100", "--set",
                               "heartbeat.misses=1000")
        viewer = self.viewer(program.url)
        before = viewer.do("digest")["result"]
        os.kill(program.nodes("pxpl5-gp")[0], signal.SIGSTOP)
        waits = viewer.send("digest")
        another = self.viewer(program.watch_url)
        self.assertEqual(another.until(lambda m: "hello" in m)["hello"]["role"], "watcher")
        state = another.until(lambda m: "state" in m)["state"]
        self.assertEqual(state["volume"]["name"], "phantom:sphere")
        self.assertTrue(viewer.do("stats")["ok"])
        self.assertTrue(viewer.do("kill gp-0")["ok"])
        # The machine was lost under this command, or under a picture before it.
        answer = viewer.answer_to(waits)
        self.assertIn("gp-0 was killed by signal 9", str(viewer.texts))
        self.assertEqual(answer.get("result", before), before)
        self.assertEqual(viewer.do("digest")["result"], before)

    def test_a_stopped_node_is_found_and_the_session_goes_on(self):
        program = self.program("phantom:sphere", "--set", "heartbeat.interval_ms=100", "--set",
                               "heartbeat.misses=20")
        viewer = self.viewer(program.url)
        before = viewer.do("digest")["result"]
        os.kill(program.nodes("pxpl5-renderer")[0], signal.SIGSTOP)
        viewer.send("orbit 4")
        viewer.until(lambda message: "does not answer: last heard" in str(message.get("note")))
        self.assertRegex(str(viewer.texts), r"renderer-0 \(process \d+\) does not answer")
        self.assertEqual(viewer.do("digest")["result"], before)

    def test_a_watcher_sees_and_changes_nothing(self):
        program = self.program("phantom:sphere")
        watcher = self.viewer(program.watch_url)
        self.assertEqual(watcher.next()["hello"]["role"], "watcher")
        self.assertIn("only watch", watcher.do("view 1 2")["error"])
        driver = self.viewer(program.url)
        reply = driver.do("view 3 4")
        watcher.resting(reply["revision"])
        with self.assertRaises(Refused):
            self.viewer(program.url.split("?")[0] + "?token=" + "0" * 32)

    def test_commands_of_the_browser_stay_in_their_folders(self):
        base = pathlib.Path(self.folder.name)
        allowed, private = base / "allowed", base / "private"
        allowed.mkdir()
        private.mkdir()
        (private / "secret").write_bytes(b"s" * 64)
        (allowed / "link").symlink_to(private / "secret")
        (allowed / "out").symlink_to(private)
        (allowed / "script").write_text(f"history {private}/by-script\n")
        viewer = self.viewer(self.program("phantom:sphere", "--allow", str(allowed)).url)
        layout = "raw=4x4x4,uint8 spacing=1,1,1"
        for line in (f"load {private}/secret {layout}", f"load {allowed}/link {layout}",
                     f"load {allowed}/../private/secret {layout}", f"info {private}/secret",
                     f"play {private}/secret", f"model {private}/secret",
                     f"history {private}/new", f"history {allowed}/out/new",
                     f"snapshot {private}/x.png", f"orbit 2 {private}/x{{}}.png",
                     f"export {private}/x.ply", f"certificate {private}/x.ply",
                     f"load /proc/self/mem {layout}", "load /proc/kmsg", "info /proc/kmsg",
                     f"load /dev/zero {layout}", "info /dev/zero", "play /proc/kmsg",
                     f"play {allowed}/script"):
            reply = viewer.do(line)
            self.assertFalse(reply["ok"], line)
            self.assertIn("outside of the folders that the browser may", reply["error"], line)
        self.assertEqual(os.listdir(private), ["secret"])
        for name, reason in ((".bashrc", "hidden"), ("script", "exists already")):
            reply = viewer.do(f"history {allowed}/{name}")
            self.assertIn(reason, reply["error"])
        for line in (f"history {allowed}/new", f"snapshot {allowed}/new.png",
                     "history download:new", "history download:new"):
            self.assertTrue(viewer.do(line)["ok"], line)
        reply = viewer.do(f"play {allowed}/new")
        self.assertTrue(reply["ok"], reply)
        self.assertIn("control character", viewer.do("surface 'a\nb' iso=0")["error"])

    def test_uploads_are_gone_at_the_end(self):
        program = self.program("phantom:sphere")
        query = urllib.parse.urlsplit(program.url).query
        url = urllib.parse.urljoin(program.url, "/upload") + f"?{query}&name=a.raw&batch=u"
        with urllib.request.urlopen(urllib.request.Request(url, b"x" * 100), timeout=20) as answer:
            self.assertEqual(answer.status, 200)
        uploads = list(pathlib.Path(self.folder.name).glob("*/uploads"))
        self.assertEqual([path.name for path in uploads[0].rglob("*.raw")], ["a.raw"])
        self.assertEqual(program.stop(), (0, ""))
        self.assertFalse(uploads[0].exists())

    def test_no_process_is_left_by_either_signal(self):
        for by in (signal.SIGINT, signal.SIGTERM):
            program = self.program("phantom:sphere")
            nodes = program.nodes("pxpl5-gp") + program.nodes("pxpl5-renderer")
            self.assertEqual(len(nodes), 2)
            self.assertEqual(program.stop(by), (0, ""))
            for node in nodes:
                self.assertFalse(pathlib.Path(f"/proc/{node}").exists())

    def test_content_that_is_none_ends_it_with_a_sentence(self):
        empty = pathlib.Path(self.folder.name, "empty.pxpl5")
        empty.write_text("# Comments are no commands.\n\n")
        for words, code in ((["--session", str(empty)], 65),
                            (["--session", str(empty.with_name("nowhere.pxpl5"))], 65),
                            (["--session", str(empty.parent)], 65),
                            (["nowhere.nrrd"], 65), (["phantom:pelvi"], 64),
                            (["/proc/kmsg"], 65), (["/proc/self"], 65), (["/dev/zero"], 65),
                            (["phantom:sphere", "--bind", "0.0.0.0"], 64)):
            done = subprocess.run(
                [BINARIES / "pxpl5", "serve", "--run-folder", self.folder.name, "--topology",
                 "one-of-each", *words], capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertRegex(done.stderr, "^error: ")


if __name__ == "__main__":
    BINARIES = pathlib.Path(sys.argv.pop(1))
    unittest.main()
