#!/usr/bin/env python3
"""Computers that come and go while a session continues: the pictures keep their bits.

usage: test_elastic.py BIN [unittest's arguments]

SKIPPED without root, without the packages of `host/setup.sh cluster`, or without namespaces.
"""
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from cluster import missing  # noqa: E402
from on_cluster import (BIN, FOUR_GPS, LIMIT_S, SLURM, SPREAD, SSH, OnACluster,  # noqa: E402
                        new_cluster)

SCENE = ("load phantom:sphere", "surface s iso=0", "view 30 20", "size 200x160")
QUICK = ("--keep-going", "--set", "gp.restart.backoff_ms=0")


def by_name(reply):
    return {each["name"]: each for each in reply["computers"]}


class Elastic(OnACluster):
    @classmethod
    def setUpClass(cls):
        cls.cluster = cls.enterClassContext(new_cluster())

    def setUp(self):
        self.addCleanup(self.cluster.wait_until_idle)  # After all programs have ended.

    def begin(self, machine):
        """The digest of a scene on a new machine."""
        for line in SCENE:
            machine.result(line)
        return machine.result("digest")

    def waiting(self, count, *words):
        """A machine that waits for `count` computers, and the words that let them join."""
        machine = self.dialog("--engine", "wait", "--set", f"wait={count}", *FOUR_GPS, *QUICK,
                              *words)
        return machine, machine.note(r": (/.*/pxpl5 join .*)$")[1].split()

    def join(self, name, words, *more):
        return self.cluster.popen(name, [*words, *more], stderr=-1, text=True)

    def check_use(self, machine, **uses):
        """The computers and their states. All GPs and Renderers run on those that are used."""
        listed = by_name(machine.result("computers"))
        self.assertEqual({name: each["state"] for name, each in listed.items()}, uses)
        for each in listed.values():
            self.assertEqual(each["nodes"] > 0, each["state"] == "used", each)
        self.assertEqual(sum(each["nodes"] for each in listed.values()), 7)
        return listed

    def end(self, machine, joins=()):
        code, said = machine.end()
        self.assertEqual(code, 0, said)
        for join in joins:
            _, complaint = join.communicate(timeout=LIMIT_S)
            self.assertEqual(join.returncode, 0, complaint)
        return said

    def test_a_computer_that_joins_later_is_used_and_another_is_released(self):
        machine, words = self.waiting(2)
        joins = {name: self.join(name, words, "--again") for name in ("n1", "n2")}
        digest = self.begin(machine)
        joins["n3"] = self.join("n3", words)
        machine.note(r"note: n3 with \d+ cores? has joined")
        self.assertEqual(by_name(machine.result("computers"))["n3"]["state"], "idle")
        self.assertEqual(machine.result("digest"), digest)
        machine.result("computers use")
        self.check_use(machine, n1="used", n2="used", n3="used")
        self.assertEqual(machine.result("digest"), digest)
        machine.result("computers release n2")
        _, complaint = joins.pop("n2").communicate(timeout=LIMIT_S)  # In spite of --again.
        self.assertNotIn("lost", complaint)
        self.check_use(machine, n1="used", n2="released", n3="used")
        self.assertEqual(machine.result("digest"), digest)
        machine.result("computers release n2")  # Nothing happens.
        machine.result("computers release n1")
        self.check_use(machine, n1="released", n2="released", n3="used")
        self.assertEqual(machine.result("digest"), digest)
        last = machine.ask("computers release n3")
        self.assertRegex(last.get("error", ""), "n3 is the only one that has joined")
        joins.pop("n1").communicate(timeout=LIMIT_S)
        self.assertEqual(machine.result("digest"), digest)
        code, said = machine.end()
        self.assertEqual(code, 64, said)  # Of the refused command.
        joins["n3"].communicate(timeout=LIMIT_S)
        self.assertEqual(joins["n3"].returncode, 0)

    def test_a_computer_that_was_lost_comes_back_when_it_joins_again(self):
        machine, words = self.waiting(3, *SPREAD)
        joins = [self.join("n1", words), self.join("n2", words, "--again", "--wait", "60"),
                 self.join("n3", words)]
        digest = self.begin(machine)
        self.cluster.cut("n2")
        try:
            self.assertEqual(machine.result("digest"), digest)
            machine.note("goes on without computer n2")
            listed = self.check_use(machine, n1="used", n2="lost", n3="used")
            self.assertIn("has not answered", listed["n2"]["why"])
            self.wait_until_ended("pxpl5-", "n2")
        finally:
            self.cluster.join("n2")
        machine.note(r"note: n2 with \d+ cores? has joined")
        machine.result("scale gp=5")
        machine.result("scale gp=4")
        self.check_use(machine, n1="used", n2="used", n3="used")
        self.assertEqual(machine.result("digest"), digest)
        machine.result("computers release n2")  # Else --again waits for the next machine.
        self.assertEqual(machine.result("digest"), digest)
        self.end(machine, joins)

    def test_a_computer_that_was_lost_is_started_again_by_ssh(self):
        machine = self.dialog(*SSH, *SPREAD, *FOUR_GPS, *QUICK)
        digest = self.begin(machine)
        self.cluster.on("n2", ["pkill", "-9", "-f", "pxpl5 join"])
        self.assertEqual(machine.result("digest"), digest)
        self.check_use(machine, n1="used", n2="lost", n3="used")
        machine.result("computers use n2")
        self.check_use(machine, n1="used", n2="used", n3="used")
        self.assertEqual(machine.result("digest"), digest)
        machine.result("computers release n3")
        self.wait_until_ended("pxpl5", "n3")
        machine.result("computers use n3")
        self.assertEqual(machine.result("digest"), digest)
        refused = machine.ask("computers use n9")
        self.assertRegex(refused.get("error", ""), "n9 has not joined: engine-n9 ended with exit")
        self.assertEqual(machine.result("digest"), digest)
        machine.end()

    def test_a_computer_of_another_job_joins(self):
        machine = self.dialog(*SLURM, *SPREAD, *FOUR_GPS, *QUICK,
                              before=("salloc", "--quiet", "-w", "n1,n2", "-N2", "-n2"))
        digest = self.begin(machine)
        line = machine.result("computers invite")["join"]
        self.assertRegex(line, "--key-file /")
        self.cluster.login(["sbatch", "-w", "n3", "-N1", "--wrap", line])
        machine.note(r"note: n3 with \d+ cores? has joined")
        machine.result("computers use")
        self.check_use(machine, n1="used", n2="used", n3="used")
        self.assertEqual(machine.result("digest"), digest)
        machine.result("computers release n1")
        self.check_use(machine, n1="released", n2="used", n3="used")
        self.assertEqual(machine.result("digest"), digest)
        machine.result("computers use n1")  # By another step of the job.
        self.check_use(machine, n1="used", n2="used", n3="used")
        self.assertEqual(machine.result("digest"), digest)
        self.end(machine)


if __name__ == "__main__":
    if reason := missing([BIN]):
        print(f"SKIPPED: {reason}")
    else:
        unittest.main()
