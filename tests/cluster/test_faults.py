#!/usr/bin/env python3
"""Machines on three computers: deaths and strangers have the right message and exit code.

usage: test_faults.py BIN [unittest's arguments]

SKIPPED without root, without the packages of `host/setup.sh cluster`, or without namespaces.
"""
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from cluster import OTHER_USER, missing  # noqa: E402
from on_cluster import (BIN, ENDS, FOUR_GPS, IN_JOB, LIMIT_S, NAMES, PXPL5, SLURM,  # noqa: E402
                        SPREAD, SSH, OnACluster, new_cluster, results)

SPHERE = ("load phantom:sphere", "surface s iso=0")
OTHER_BUILD = "LC_ALL=C sed 's/pxpl5 {}, protocol/pxpl9 {}, protocol/'"


class Faults(OnACluster):
    @classmethod
    def setUpClass(cls):
        cls.cluster = cls.enterClassContext(new_cluster())

    def tearDown(self):
        self.cluster.wait_until_idle()

    def waiting(self, *words):
        """A machine of engine wait, and the words that let a computer join."""
        machine = self.dialog("--engine", "wait", *words)
        return machine, machine.note(r": (/.*/pxpl5 join .*)$")[1].split()

    def test_computers_that_join_give_every_topology_the_bits_of_one(self):
        lines = [*SPHERE, "digest", "certificate s"]
        for topology in ("one-of-each", "default", "paper-1993"):
            alone = results(self.run_lines(lines, "--topology", topology).stdout)
            for more in ((), ("--insecure-tcp",)):
                with self.subTest(topology=topology, more=more):
                    machine, words = self.waiting("--set", "wait=3", "--topology", topology, *more)
                    joins = [self.cluster.popen(name, words, stderr=-1, text=True)
                             for name in NAMES.split(",")]
                    self.assertEqual([machine.result(line) for line in lines], alone)
                    code, said = machine.end()
                    self.assertEqual(code, 0, said)
                    for join in joins:
                        _, complaint = join.communicate(timeout=LIMIT_S)
                        self.assertEqual(join.returncode, 0, complaint)

    def test_one_ssh_for_each_computer_and_no_file_left_there(self):
        """The usual sshd allows 10 sessions for a connection, and the paper's machine has 54."""
        # A join that was killed leaves a folder, which a later one removes when it is 10 s old.
        before = set(self.cluster.files())
        machine = self.dialog("--topology", "paper-1993", *SSH, *SPREAD)
        for line in (*SPHERE, "digest"):
            machine.result(line)
        self.assertEqual(len([each for each in self.cluster.processes()
                              if each.computer == "login" and each.argv[0] == "ssh"]), 3)
        self.assertGreater(len(self.programs("pxpl5-gp", "n2")), 10)
        code, said = machine.end()
        self.assertEqual(code, 0, said)
        self.cluster.wait_until_idle()
        self.assertEqual([path for path in self.cluster.files()
                          if path.startswith("n") and path not in before], [])

    def test_a_killed_node_ends_the_machine(self):
        for words, before in ((SSH, ()), (SLURM, IN_JOB)):
            with self.subTest(words=words):
                machine = self.start(*words, *ENDS, *SPREAD, *FOUR_GPS, before=before)
                victim, = self.programs("gp-3.mcap") or self.programs("--index 3")
                self.cluster.on(victim.computer, ["pkill", "-9", "-f", "gp-3.mcap|--index 3"])
                code, _, complaint = self.end_of(machine)
                self.assertEqual(code, 137, complaint)
                self.assertIn("gp-3 was killed by signal 9 (SIGKILL)", complaint)
                self.cluster.wait_until_idle()

    def test_a_killed_join_ends_the_machine(self):
        for words, before, codes in ((SSH, (), (69, 255)), (SLURM, IN_JOB, (69, 137))):
            with self.subTest(words=words):
                machine = self.start(*words, *ENDS, *SPREAD, *FOUR_GPS, before=before)
                self.cluster.on("n2", ["pkill", "-9", "-f", "pxpl5 join"])
                code, _, complaint = self.end_of(machine)
                self.assertIn(code, codes, complaint)
                self.assertRegex(complaint, "is lost with computer n2|engine-n2 ended with exit")
                self.cluster.wait_until_idle()

    def test_strangers_are_refused_and_the_machine_waits_on(self):
        machine, words = self.waiting("--set", "wait=1", *FOUR_GPS)
        address, key = words[2], words[4]
        other = "umask 077; {} key >other.key; {} {} >pxpl9; chmod 700 pxpl9".format(
            PXPL5, OTHER_BUILD, PXPL5)
        plain = f"umask 077; awk '{{print $1, \"11\", $3, \"-\", \"-\"}}' {key} >plain.key"
        self.cluster.login(["sh", "-c", f"{other}; {plain}"])
        for program, more, user, code, complaint in (
                (PXPL5, (), "ada", 64, "(?i)key"),
                (PXPL5, ("--key-file", key), OTHER_USER, 64, "cannot read the key file"),
                (PXPL5, ("--key-file", "other.key"), "ada", 69, "does not accept this key"),
                (PXPL5, ("--key-file", "plain.key"), "ada", 69, "does not accept this key"),
                ("./pxpl9", ("--key-file", key), "ada", 69, "refuses this computer: it has build")):
            with self.subTest(program=program, more=more, user=user):
                stranger = self.cluster.on("n1", [program, "join", address, *more], user=user,
                                           check=False)
                self.assertEqual(stranger.returncode, code, stranger.stderr)
                self.assertRegex(stranger.stderr, complaint)
        machine.note("computer n1 at .* was refused: it has build")
        join = self.cluster.popen("n1", words, stderr=-1, text=True)
        for line in SPHERE:
            machine.result(line)
        code, said = machine.end()
        self.assertEqual(code, 0, said)
        join.communicate(timeout=LIMIT_S)
        self.assertEqual(join.returncode, 0)


if __name__ == "__main__":
    if reason := missing([BIN]):
        print(f"SKIPPED: {reason}")
    else:
        unittest.main()
