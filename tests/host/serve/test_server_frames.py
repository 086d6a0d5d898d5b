#!/usr/bin/env python3
"""Which frames go to which viewer: test_server_frames.py ECHO_SERVER."""
import json
import pathlib
import struct
import sys
import time
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from server_case import Case, main  # noqa: E402


class Frames(Case):
    def show(self, viewer, revision, rests=False, size=(64, 48), depths=False, layers=False,
             **more):
        viewer.send(json.dumps({"frame": [*size, revision, rests, depths, layers], **more}))

    def frame(self, viewer):
        """The next frame's header as a dict, and its picture."""
        message = viewer.receive()
        names = ("magic", "number", "revision", "width", "height", "kind", "quality", "samples",
                 "flags", "machine_ms", "digest", "moved_mm", "picture_bytes", "depth_bytes",
                 "pose", "views", "layers", "opacity", "reserved")
        head = dict(zip(names, struct.unpack("<IIIHHBBBBfQdIIIBBBB", message[:56])))
        self.assertEqual(len(message), 56 + head["picture_bytes"] + head["depth_bytes"])
        return head, message[56:]

    def shown(self, viewer, number, after_ms=0):
        viewer.send(json.dumps({"shown": number, "after_ms": after_ms}))

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

    def test_depths_follow_the_picture_if_the_viewer_wants_them(self):
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

    def test_a_viewer_without_depths_gets_blended_layers(self):
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

    def test_a_viewer_with_depths_gets_layers_after_the_resting_picture(self):
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

    def moving_on_slow_link(self, viewer, revision, size=(64, 48)):
        """The head of a moving frame that takes its time to the viewer."""
        self.show(viewer, revision, size=size)
        head, _ = self.frame(viewer)
        self.take_time()
        self.shown(viewer, head["number"])
        return head

    def take_time(self):
        """Makes requests for 0.2 s: frames of 3 kB then seem to come at 15 kB/s."""
        end = time.monotonic() + 0.2
        while time.monotonic() < end:
            self.server.request("/icon.svg")

    def test_moving_pictures_are_video_over_a_slow_link_if_the_viewer_wants_it(self):
        jpeg, png, video, key = 1, 2, 3, 8
        viewer = self.join()
        for revision in (1, 2, 3):
            self.assertEqual(self.moving_on_slow_link(viewer, revision)["kind"], jpeg)
        viewer.send('{"video":true}')
        frames = [self.moving_on_slow_link(viewer, revision) for revision in (4, 5)]
        self.assertEqual([head["kind"] for head in frames], [video, video])
        self.assertEqual([head["flags"] for head in frames], [key, 0])
        viewer.send('{"video":true}')
        self.assertEqual(self.moving_on_slow_link(viewer, 6)["flags"], key)
        self.assertEqual(self.moving_on_slow_link(viewer, 7)["flags"], 0)
        other = self.moving_on_slow_link(viewer, 8, size=(48, 64))
        self.assertEqual((other["flags"], other["width"], other["height"]), (key, 48, 64))
        self.show(viewer, 9, rests=True)
        head, picture = self.frame(viewer)
        self.assertEqual((head["kind"], picture[:4]), (png, b"\x89PNG"))
        viewer.send('{"video":false}')
        self.shown(viewer, head["number"])
        self.assertEqual(self.moving_on_slow_link(viewer, 10)["kind"], jpeg)

    def test_two_viewers_get_video_and_at_most_one_of_them_is_a_watcher(self):
        viewers = [self.join(self.server.watch_url), self.join(self.server.watch_url), self.join()]
        for viewer in viewers:
            viewer.send('{"video":true}')
        for revision in range(1, 6):
            self.show(viewers[2], revision)
            heads = [self.frame(viewer)[0] for viewer in viewers]
            self.take_time()
            for viewer, head in zip(viewers, heads):
                self.shown(viewer, head["number"])
        kinds = [head["kind"] for head in heads]
        self.assertEqual((sorted(kinds[:2]), kinds[2]), ([1, 3], 3))

    def test_a_large_first_picture_follows_a_preview(self):
        jpeg, png, rests = 1, 2, 1
        viewer = self.join()
        self.show(viewer, 7, rests=True, size=(640, 480))
        heads = [self.frame(viewer)[0] for _ in range(2)]
        self.assertEqual([(head["number"], head["revision"], head["kind"], head["flags"],
                           head["digest"]) for head in heads],
                         [(1, 7, jpeg, 0, 0), (2, 7, png, rests, 7)])
        self.assertLess(heads[0]["picture_bytes"], heads[1]["picture_bytes"] / 2)
        self.shown(viewer, 2)
        self.show(viewer, 8, rests=True, size=(640, 480))
        self.assertEqual(self.frame(viewer)[0]["kind"], png)

    def join_at_rest(self, *viewers):
        """All have had a resting picture, and acknowledge it."""
        self.show(viewers[0], 1, rests=True, size=(640, 480))
        for viewer in viewers:
            for _ in range(2):
                head, _ = self.frame(viewer)
            self.shown(viewer, head["number"])

    def move(self, quick, *slow, **more):
        """Several moving frames, which take their time to `slow`: the last to each viewer."""
        for revision in range(2, 8):
            self.show(quick, revision, size=(640, 480), **more)
            quick_head, _ = self.frame(quick)
            self.shown(quick, quick_head["number"])
            frames = [self.frame(viewer) for viewer in slow]
            self.take_time()
            for viewer, (head, _) in zip(slow, frames):
                self.shown(viewer, head["number"])
        return quick_head, *frames

    def size_of(self, head):
        return head["width"], head["height"]

    def test_a_viewer_on_a_slow_link_gets_smaller_moving_pictures_than_others(self):
        quick, watcher = self.join(), self.join(self.server.watch_url)
        self.join_at_rest(quick, watcher)
        quick_head, (head, _) = self.move(quick, watcher)
        self.assertEqual(self.size_of(head), (320, 240))
        self.assertGreater(quick_head["width"], 320)
        # Two layers become one, in the same size.
        _, (head, _) = self.move(quick, watcher, depths=True, layers=True)
        self.assertEqual((*self.size_of(head), head["layers"]), (320, 240, 1))
        # The rows of a monitor and what rests have their full size.
        _, (head, _) = self.move(quick, watcher, fixed=True)
        self.assertEqual(self.size_of(head), (640, 480))
        self.show(quick, 9, rests=True, size=(640, 480))
        head, _ = self.frame(watcher)
        self.assertEqual((head["flags"], *self.size_of(head)), (1, 640, 480))

    def test_depths_have_the_size_of_their_picture(self):
        quick, warps, plain = self.join(), self.join(), self.join(self.server.watch_url)
        self.join_at_rest(quick, warps, plain)
        warps.send('{"depths":true}')
        self.sync(warps)
        _, (head, bytes_), (other, _) = self.move(quick, warps, plain, depths=True)
        self.assertEqual((self.size_of(head), self.size_of(other)), ((320, 240), (320, 240)))
        self.assertEqual(other["depth_bytes"], 0)
        lean = zlib.decompress(bytes_[head["picture_bytes"] + 4:], wbits=-15)
        self.assertEqual(len(lean), 320 * 240 // 8 + 2 * 81 * 61 + 80 * 60 // 8)
        _, (head, bytes_), (other, _) = self.move(quick, warps, plain, depths=True, layers=True)
        self.assertEqual((*self.size_of(head), head["layers"]), (320, 240, 2))
        self.assertEqual((*self.size_of(other), other["layers"]), (320, 240, 1))
        first, = struct.unpack_from("<I", bytes_, head["picture_bytes"])
        second, = struct.unpack_from("<I", bytes_, head["picture_bytes"] + 4 + first)
        self.assertEqual(head["depth_bytes"], 8 + first + second)

    def test_the_machine_draws_in_the_size_for_the_fastest_driver(self):
        quick, slow = self.join(), self.join()
        self.join_at_rest(quick, slow)
        self.move(quick, slow)
        self.assertGreater(self.ask(quick, wants=0)["scale"], 0.5)
        quick.close()
        self.assertEqual([self.server.event() for _ in range(3)][-1], "left 1")
        self.assertEqual(self.ask(slow, wants=0)["scale"], 0.5)
        # A frame that has been drawn in this size is not made smaller again.
        self.show(slow, 8, size=(320, 240), scale=0.5)
        self.assertEqual(self.size_of(self.frame(slow)[0]), (320, 240))

    def test_frames_that_only_waited_in_the_page_are_no_sign_of_a_slow_link(self):
        for after_ms, kind in ((0, 3), (60000, 1)):
            viewer = self.join()
            viewer.send('{"video":true}')
            for revision in range(1, 6):
                self.show(viewer, revision)
                head, _ = self.frame(viewer)
                self.take_time()
                self.shown(viewer, head["number"], after_ms)
            self.assertEqual(head["kind"], kind, f"after {after_ms} ms in the page")
            viewer.close()

    def test_a_viewer_that_shows_no_frame_gets_two_and_then_the_newest(self):
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

    def test_a_stalled_viewer_gets_the_newest_in_the_end_and_others_go_on(self):
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

    def test_a_viewer_that_joins_late_or_again_gets_the_newest_frame(self):
        viewer = self.join()
        self.show(viewer, 5, rests=True)
        self.assertEqual(self.frame(viewer)[0]["number"], 1)
        viewer.close()
        again = self.join()
        head, _ = self.frame(again)
        self.assertEqual((head["number"], head["revision"]), (1, 5))

    def pair(self, viewer, revision, pose, wearer=1, size=(64, 48)):
        viewer.send(json.dumps({"frame": [*size, revision, False, True, pose, wearer]}))

    def test_a_pair_goes_to_the_headset_and_frames_to_the_other_viewers(self):
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

    def test_after_the_headset_has_left_no_pair_is_wanted_and_others_go_on(self):
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
