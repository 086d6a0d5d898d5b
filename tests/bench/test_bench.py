#!/usr/bin/env python3
"""The measuring programs themselves: statistics, parsers, goals. No time is measured here."""
import contextlib
import gzip
import io
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import zlib

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE / "peers")]
import compare  # noqa: E402
import figures  # noqa: E402
import goals  # noqa: E402
import loads  # noqa: E402
import machine  # noqa: E402
import measure  # noqa: E402
import processes  # noqa: E402
import scaling  # noqa: E402
import session  # noqa: E402
import stereo  # noqa: E402
import volume_file  # noqa: E402


class Figures(unittest.TestCase):
    def test_a_percentile_is_a_sample_that_enough_do_not_exceed(self):
        samples = list(range(100, 0, -1))
        self.assertEqual(figures.percentile(samples, 0.95), 95)
        self.assertEqual(figures.percentile(samples, 1), 100)
        self.assertEqual(figures.percentile([7], 0.95), 7)
        for share in (0, 1.1):
            self.assertRaises(ValueError, figures.percentile, samples, share)

    def test_the_median_of_an_even_number_lies_between_the_middle_two(self):
        self.assertEqual(figures.median([9, 1, 2, 4]), 3)
        self.assertRaises(ValueError, figures.median, [])

    def test_ratios_are_taken_between_neighbors_in_time(self):
        # Both halve in the second run: the ratio of the medians would say otherwise.
        self.assertEqual(figures.pairwise_ratio([8, 4, 80], [10, 5, 100]), 0.8)
        self.assertRaises(ValueError, figures.pairwise_ratio, [1], [1, 2])

    def test_four_digits_are_kept_whatever_the_size(self):
        self.assertEqual(figures.rounded(0.00123456), 0.001235)
        self.assertEqual(figures.rounded(123.456), 123.5)
        self.assertEqual(figures.rounded(0), 0)

    def test_a_table_has_a_line_a_row_and_refuses_short_ones(self):
        self.assertEqual(figures.table(["a", "b"], [["1", "2"]]), "| a | b |\n|---|---|\n| 1 | 2 |")
        self.assertRaises(ValueError, figures.table, ["a", "b"], [["1"]])

    def test_figures_over_runs_are_medians_of_each_runs_own(self):
        kept = measure.Figures()
        for run in ([1, 2, 30], [4, 5, 60], [7, 8, 90]):
            kept.add("a", run)
        kept.add_one("b", 3)
        kept.add_summary("c", {"median": 1, "p95": 2, "max": 3})
        self.assertEqual(kept.over_runs(), {"a": 5, "b": 3, "c": 1})
        self.assertEqual(kept.p95_over_runs(), {"a": 60, "c": 2})


class Goals(unittest.TestCase):
    def test_every_goal_of_the_statement_is_in_the_table(self):
        names = [goal.figure for goal in goals.GOALS]
        for work, count in (("extraction_ms/", 6), ("frames_per_s/default/512x512/", 10),
                            ("frames_per_s/default/1280x1024/", 5), ("isovalue_picture_ms/", 5),
                            ("frames_per_s/paper-1993/", 5), ("first_picture_s/", 2),
                            ("view_depths_ratio/default/", 4), ("pair_depths_ratio/default/", 4)):
            self.assertEqual(sum(name.startswith(work) for name in names), count, work)
        for name in ("view_picture_ms/default/512x512/skin", "triangles_8px_per_s",
                     "end_of_region_us", "memory_mib/paper-1993", "flight_ratio/default"):
            self.assertEqual(names.count(name), 1, name)

    def test_limits_are_the_statements(self):
        limits = {(goal.figure, goal.factor): goal.limit({}) for goal in goals.GOALS}
        expected = {("extraction_ms/default/skin", 0.5): 1.0,
                    ("extraction_ms/default/512x512x300", 0.5): 74.0,
                    ("frames_per_s/default/512x512/head", 4): 4000 / 51,
                    ("frames_per_s/default/1280x1024/muscle", 5): 5000 / 56,
                    ("frames_per_s/default/512x512/ultrasound", 10): 120.0,
                    ("frames_per_s/paper-1993/512x512/bone", 1.5): 1500 / 12.1,
                    ("isovalue_picture_ms/default/512x512/skin", 0.35): 4.13}
        for key, limit in expected.items():
            self.assertAlmostEqual(limits[key], limit, msg=str(key))

    def test_a_times_goal_is_an_upper_bound_and_a_rates_goal_a_lower_one(self):
        verdicts = goals.judge({"end_of_region_us": 40.0, "triangles_8px_per_s": 12e6})
        self.assertEqual([verdict.met for verdict in verdicts], [True, True])
        verdicts = goals.judge({"end_of_region_us": 40.1, "triangles_8px_per_s": 11.9e6})
        self.assertEqual([verdict.met for verdict in verdicts], [False, False])
        self.assertEqual([goals.text_of(verdict).split(":")[0] for verdict in verdicts],
                         ["missed", "missed"])

    def test_what_the_peer_took_in_this_session_replaces_the_statements_figure(self):
        name, draw = "frames_per_s/default/512x512/skin", "vtk_draw_ms/512x512/skin"
        four_times = next(goal for goal in goals.GOALS if goal.figure == name and goal.factor == 4)
        self.assertAlmostEqual(four_times.limit({draw: 20.0}), 200.0)
        self.assertTrue(four_times.is_met(201, {draw: 20.0}))
        self.assertFalse(four_times.is_met(201, {}))
        half = goals.GOALS[0]
        self.assertAlmostEqual(half.limit({half.peer: 5.0}), 2.5)

    def test_check_fails_on_a_missed_goal_and_on_nothing_to_check(self):
        with open(os.devnull, "w", encoding="utf-8") as nowhere, \
                contextlib.redirect_stderr(nowhere):
            self.assertEqual(machine.tell({"end_of_region_us": 39.0}, True), 0)
            self.assertEqual(machine.tell({"end_of_region_us": 41.0}, True), 1)
            self.assertEqual(machine.tell({}, True), 1)
            self.assertEqual(machine.tell({"end_of_region_us": 41.0}, False), 0)

    def test_a_row_says_how_many_times_better_we_are(self):
        verdict = goals.judge({"extraction_ms/default/skin": 0.8}, {"vtk_extraction_ms/skin": 2.4})
        row = compare.row_of(verdict[0], {"vtk_extraction_ms/skin": 2.4})
        self.assertEqual(row[1:], ["0.8", "2.4 (VTK)", "3.00", "at most 1.2 = 0.5 x", "yes"])
        verdict = goals.judge({"frames_per_s/default/1280x1024/skin": 100.0})
        row = compare.row_of(verdict[0], {})
        self.assertEqual(row[2:], ["42.74 (statement)", "2.34", "at least 213.7 = 5 x",
                                   "**no**"])

    def test_rates_and_work_without_a_goal_are_shown_beside_the_peers(self):
        ours = {"frames_per_s/default/512x512/skin": 200.0,
                "cpu_ms_per_frame/default/512x512/skin": 8.0}
        peers = {"egl_draw_ms/512x512/skin": 20.0, "vtk_draw_cpu_ms/512x512/skin": 24.0,
                 "vtk_loop_cpu_ms/512x512/skin": 9.0, "egl_draw_ms/512x512/head": 1.0}
        self.assertEqual(compare.other_rows(ours, peers), [
            ["frames_per_s/default/512x512/skin", "200", "50 (OpenGL)", "4.00", "-", "-"],
            ["cpu_ms_per_frame/default/512x512/skin", "8", "24 (VTK)", "3.00", "-", "-"]])

    def test_of_the_numbers_of_threads_the_quicker_counts(self):
        peers = compare.Peers.__new__(compare.Peers)
        peers.runs = measure.Figures()
        peers.keep_best("vtk_draw_ms/512x512/skin", [{"ms": [9, 1, 5], "cpu_ms": 5},
                                                     {"ms": [4, 4, 4], "cpu_ms": 8}])
        self.assertEqual(peers.runs.over_runs(), {"vtk_draw_ms/512x512/skin": 4,
                                                  "vtk_draw_cpu_ms/512x512/skin": 8})

    def test_peers_may_use_all_cores_that_we_may_and_the_table_says_so(self):
        self.assertEqual(set(compare.THREADS), {1, len(os.sched_getaffinity(0))})
        head = compare.tables({}, {}).splitlines()[0]
        self.assertIn(f"{len(os.sched_getaffinity(0))} thread", head)

    def test_other_surfaces_are_not_compared(self):
        compare.require_same_work("skin", 1000, 1005)
        self.assertRaises(session.MeasureError, compare.require_same_work, "skin", 1000, 1020)


class CommandLine(unittest.TestCase):
    def test_a_count_that_sweep_would_refuse_is_refused_at_once(self):
        for count in (1, 100001):
            with contextlib.redirect_stderr(io.StringIO()) as told:
                self.assertRaises(SystemExit, machine.parse, ["pxpl5", "--count", str(count)])
            self.assertIn(f"--count is 2 to 100000; it is {count}", told.getvalue())
        self.assertEqual(machine.parse(["pxpl5", "--count", "2"]).count, 2)


class Answers(unittest.TestCase):
    def test_a_refused_command_says_its_reason(self):
        self.assertEqual(session.parse_answer('{"ok":true,"result":{"a":1}}', "x"), {"a": 1})
        with self.assertRaisesRegex(session.CommandFailed, "'load x': no such file"):
            session.parse_answer('{"ok":false,"error":"no such file"}', "load x")
        with self.assertRaisesRegex(session.CommandFailed, "not JSON"):
            session.parse_answer("oops", "load x")

    def test_volumes_and_surfaces_that_are_not_there_are_named(self):
        with self.assertRaisesRegex(session.MeasureError, "/nowhere/ct/knee.*: not there"):
            loads.chosen_loads("", "/nowhere", "")
        with tempfile.TemporaryDirectory() as folder:
            for _, name, _ in loads.REAL:
                path = pathlib.Path(folder) / name
                path.parent.mkdir(exist_ok=True)
                path.touch()
            with self.assertRaisesRegex(session.MeasureError, "there is no tooth; there are skin"):
                loads.chosen_loads("", folder, "skin,tooth")
            kind, chosen = loads.chosen_loads("", folder, "head,skin")
        self.assertEqual((kind, [load.key for load in chosen]), ("real", ["skin", "head"]))

    def test_a_program_that_is_not_there_is_named(self):
        with self.assertRaisesRegex(session.MeasureError,
                                    "/none/pxpl5: No such file or directory; give the path"):
            session.Session("/none/pxpl5")

    def test_what_cannot_be_measured_is_an_exit_code(self):
        def fail():
            raise session.MeasureError("why")
        with open(os.devnull, "w", encoding="utf-8") as nowhere, \
                contextlib.redirect_stderr(nowhere):
            self.assertEqual(session.told_errors(fail), 65)
        self.assertEqual(session.told_errors(lambda: 3), 3)

    def test_stages_are_found_by_name_and_turned_into_the_goals_units(self):
        text = json.dumps({"benchmarks": [
            {"name": "triangles/8px/avx2", "cpu_time": 5.0, "time_unit": "ns", "triangles": 2e7},
            {"name": "end_of_region/covered/avx2", "cpu_time": 0.2, "time_unit": "ms"}]})
        self.assertEqual(measure.parse_stages(text, "avx2"),
                         {"triangles_8px_per_s": 2e7, "end_of_region_us": 200.0})
        self.assertRaises(KeyError, measure.parse_stages, text, "sse4")

    def test_a_sphere_goes_through_the_corners_of_the_volume(self):
        info = {"dims": [3, 5, 1], "spacing_mm": [3, 2, 9], "origin_mm": [10, 0, 0]}
        self.assertEqual(compare.sphere_around(info), [13, 4, 0, 5])


class Stereo(unittest.TestCase):
    # Everything takes twice as long in the second round.
    SAMPLES = {row: {"wall_ms": [ms, 2 * ms], "cpu_ms": [3 * ms + 1, 6 * ms + 2]} for row, ms in
               (("view", 10), ("view_depths", 11), ("pair", 20), ("pair_depths", 22), ("lean", 1),
                ("pack", 0.5), ("jpeg", 0.2))}

    def test_ratios_are_taken_within_a_round_and_named_as_the_goals_are(self):
        named = stereo.figures_of(self.SAMPLES, "default/512x512/pelvis")
        self.assertEqual(named["view_depths_ratio/default/512x512/pelvis"], 1.1)
        self.assertEqual(named["pair_depths_ratio/default/512x512/pelvis"], 2.2)
        self.assertEqual(named["pair_cpu_ratio/default/512x512/pelvis"], 1.968)
        self.assertEqual([verdict.met for verdict in goals.judge(named)], [True, False])

    def test_the_table_has_a_row_for_each_way_and_each_work_of_the_server(self):
        lines = stereo.table_of(self.SAMPLES).splitlines()[2:]
        self.assertEqual([line.split(" | ")[0] for line in lines],
                         ["| " + name for _, name in stereo.ROWS])
        self.assertEqual(lines[1], "| one view, depths | 16.50 | 51.00 | 1.100 | 1.097 |")

    def test_a_folder_without_the_chest_is_refused_and_phantoms_need_none(self):
        self.assertEqual([scene.key for scene in stereo.scenes_of("phantoms")], ["pelvis"])
        with self.assertRaisesRegex(session.MeasureError, "/nowhere/ct/torso.*: not there"):
            stereo.scenes_of("/nowhere")


class Processes(unittest.TestCase):
    def test_a_process_may_have_blanks_and_brackets_in_its_name(self):
        self.assertEqual(processes.parse_stat("42 (a) b (c) S 41 1 1 0 -1"), ("a) b (c", 41))

    def test_a_threads_time_is_what_it_ran_not_what_it_waited(self):
        self.assertEqual(processes.parse_ran("1500000000 7000000000 12\n"), 1.5)

    def test_work_of_a_process_is_found_under_its_name(self):
        name = pathlib.Path("/proc/self/comm").read_text(encoding="utf-8").strip()
        before = processes.cpu_seconds([os.getpid()])[name]
        sum(number * number for number in range(100000))
        self.assertGreater(processes.cpu_seconds([os.getpid()])[name], before)

    def test_proportional_memory_is_read_from_its_own_line(self):
        self.assertEqual(processes.pss_kib("Rss: 9 kB\nPss_Dirty: 4 kB\nPss:     5 kB\n"), 5)
        self.assertRaises(ValueError, processes.pss_kib, "Rss: 9 kB\n")

    def test_shares_add_up_with_what_was_idle_and_what_others_took(self):
        before, after = (processes.Usage({"a": 1.0}, 10.0, 5.0),
                         processes.Usage({"a": 3.0, "b": 0.5}, 11.0, 7.0))
        self.assertEqual(processes.shares(before, after, 2),
                         {"a": 0.5, "b": 0.125, "idle": 0.25, "others": 0.125})
        self.assertRaises(ValueError, processes.shares, before, before, 2)

    def test_waiting_for_a_disk_is_idle(self):
        ticks = os.sysconf("SC_CLK_TCK")
        self.assertEqual(processes.parse_idle("cpu  5 0 5 300 100 1 1 0\ncpu0 1"), 400 / ticks)
        self.assertRaises(ValueError, processes.parse_idle, "intr 1 2 3 4 5 6")

    def test_children_are_family_and_their_memory_counts(self):
        child = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
        try:
            self.assertIn(child.pid, processes.family(os.getpid()))
            with processes.PeakMemory(os.getpid()) as memory:
                alone = processes.memory_kib([os.getpid()])
            self.assertGreater(memory.peak_kib, alone)
            self.assertGreaterEqual(memory.samples, 1)
        finally:
            child.communicate(b"\n")
        self.assertEqual(processes.memory_kib([child.pid]), 0)

    def test_threads_are_put_together_by_what_they_do(self):
        kinds = scaling.by_kind({"pxpl5-gp": 0.3, "pxpl5-gp io": 0.1, "pxpl5-framebuff": 0.05,
                                 "pxpl5-renderer io": 0.15, "idle": 0.4})
        self.assertEqual(kinds, {"GP": 0.3, "io": 0.25, "frame buffer": 0.05, "idle": 0.4})
        self.assertEqual(scaling.bound_by(kinds), "idle")
        self.assertEqual(scaling.bound_by({"GP": 0.3, "io": 0.2}), "nothing alone")
        self.assertEqual(scaling.share_text(kinds), "idle 40 %, GP 30 %, io 25 %, frame buffer 5 %")


class VolumeFiles(unittest.TestCase):
    HEAD = ("NRRD0004\n# by hand\ntype: short\ndimension: 3\nsizes: 2 1 3\n"
            "space directions: (0,0,2) (3,0,4) (0,1,0)\nendian: little\nencoding: {}\n\n")
    VOXELS = bytes(range(12))

    def test_raw_and_packed_voxels_are_the_same(self):
        for encoding, body in (("raw", self.VOXELS), ("gzip", gzip.compress(self.VOXELS))):
            data = self.HEAD.format(encoding).encode() + body
            volume = volume_file.parse_nrrd(data, "a.nrrd")
            self.assertEqual(volume, ((2, 1, 3), (2.0, 5.0, 1.0), "MET_SHORT", self.VOXELS))

    def test_missing_voxels_are_named(self):
        data = self.HEAD.format("raw").encode() + self.VOXELS[:-1]
        with self.assertRaisesRegex(ValueError, "a.nrrd: .* need 12 bytes, there are 11"):
            volume_file.parse_nrrd(data, "a.nrrd")

    def test_a_packed_metaimage_is_written_as_header_and_voxels(self):
        head = ("ObjectType = Image\nNDims = 3\nCompressedData = True\nElementSpacing = 1 2 3\n"
                "DimSize = 2 1 3\nElementType = MET_SHORT\nElementDataFile = LOCAL\n")
        with tempfile.TemporaryDirectory() as folder:
            source = pathlib.Path(folder) / "a.mha"
            source.write_bytes(head.encode() + zlib.compress(self.VOXELS))
            written = pathlib.Path(volume_file.convert(str(source), folder))
            self.assertEqual(written.with_suffix(".raw").read_bytes(), self.VOXELS)
            self.assertIn("DimSize = 2 1 3\nElementSpacing = 1.0 2.0 3.0\n", written.read_text())


if __name__ == "__main__":
    unittest.main()
