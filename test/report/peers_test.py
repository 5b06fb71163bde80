#!/usr/bin/python3
"""Other programs in the report, none of them installed: the first lines of its pages, what cannot be had, and runs that fail.

    peers_test.py BIN [unittest options]        BIN is not used
"""
import contextlib
import io
import math
import os
import pathlib
import signal
import sys
import tempfile
import time
import unittest
from unittest import mock

sys.dont_write_bytecode = True
REPORT = pathlib.Path(__file__).resolve().parents[2] / "src/report"
sys.path[:0] = [str(REPORT), str(REPORT / "peers")]
import jinja2  # noqa: E402  pylint: disable=wrong-import-position
import contest  # noqa: E402  pylint: disable=wrong-import-position
import environment  # noqa: E402  pylint: disable=wrong-import-position
import results  # noqa: E402  pylint: disable=wrong-import-position


def curve(engine, method, *seconds):
    """Rows of a table: this time for an error of 1e-3, 1e-6, 1e-9."""
    return [{"engine": engine, "method": method, "setting": "1", "error_theta": error, "cpu_seconds": str(time_), "evaluations": "0",
             "outcome": "ok"} for error, time_ in zip(("1e-3", "1e-6", "1e-9"), seconds)]


class FirstLines(unittest.TestCase):
    def test_they_say_by_how_much_another_program_is_faster_and_where_the_aim_is_missed(self):
        rows = [*curve("planar_chain", "auto", 1, 3, 6), *curve("planar_chain", "taylor", 0.1, 0.1, 0.1), *curve("heyoka", "Taylor", 4, 4, 5),
                *curve("MuJoCo", "RK4", 40), *curve("odeint", "Fehlberg 7(8)", 0.1, 0.1, 0.1)]
        cells = {("swing", level): results.verdict(rows, level, 1e-15, "programs") for level in (3, 6, 9)}
        self.assertEqual(cells["swing", 9].why, "another program, whose evaluations are not counted")
        text = jinja2.Environment(loader=jinja2.FileSystemLoader(str(REPORT / "sections"))).get_template("first_lines.jinja").render(
            results=results, cells={"programs": cells}, tables={"peers": [
                {"what": "a run in a batch on one core", "setting": "1e-9", "seconds": seconds} for seconds in ("4e-5", "3e-5")]})
        self.assertIn("takes 0.75 of heyoka's time", text)
        self.assertIn("In 1 of the 3 cells", text)
        faster, missed = text.split("Another program is faster: ")[1].split("more than half of the next best program's time: ")
        self.assertIn("swing (heyoka): 1.20 at 1e-9", faster)
        self.assertIn("swing (heyoka): 0.75 at 1e-6", missed)

    def test_a_tighter_setting_counts_where_it_is_cheaper(self):
        times = results.times_to(curve("heyoka", "Taylor", 4, 2, 3))["heyoka", "Taylor"]
        self.assertEqual([times[level] for level in (3, 4, 6)], [2, 2, 2])
        self.assertAlmostEqual(times[9], 3)


class CannotBeHad(unittest.TestCase):
    def test_without_an_environment_every_program_has_a_line(self):
        with tempfile.TemporaryDirectory() as name:
            with mock.patch.multiple(environment, FOLDER=pathlib.Path("/dev/null/peers"), SOURCE=pathlib.Path(name)):
                peers = environment.Peers()
            self.assertEqual(os.listdir(name), [])
        self.assertEqual(set(peers.left_out), {*environment.REQUIREMENTS, "report_peers"})
        for why in peers.versions().values():
            self.assertRegex(why, r"^left out: [^\n]+$")
        self.assertEqual(list(peers.commands("race", [], "equations")), [])

    def test_a_program_that_the_index_does_not_have_is_left_out_alone(self):
        with tempfile.TemporaryDirectory() as name:
            pip = pathlib.Path(name) / "bin/pip"  # a stand-in, which has all but one
            pip.parent.mkdir()
            pip.write_text('#!/bin/sh\ncase "$*" in *nobody*) echo Looking; echo "ERROR: No $4"; exit 1;; esac\n', encoding="utf-8")
            pip.chmod(0o755)
            with mock.patch.multiple(environment, FOLDER=pathlib.Path(name), REQUIREMENTS={"Nobody": "nobody==0", "Pip": "pip"}):
                self.assertEqual(environment.install(), {"Nobody": "no nobody==0: ERROR: No nobody==0"})


class Run:
    """Ends `off` the mark; or it gives up, takes long, or crashes."""

    def __init__(self, off, arrives=True, seconds=0):
        self.off, self.arrives, self.seconds = off, arrives, seconds

    def start(self):
        pass

    def go(self):
        if self.off is None:
            os.kill(os.getpid(), signal.SIGKILL)
        time.sleep(self.seconds)
        return self.arrives

    def read(self):
        return [1 + self.off], [2 - self.off], 7, 5, 1


class Race(unittest.TestCase):
    def rows(self, make):
        """{setting: (error of θ, outcome)}"""
        scene = mock.Mock(end=1, errors=lambda theta, omega: contest.Contest.errors(mock.Mock(ends=[[(0, 1.0)], [(0, 2.0)]]), theta, omega))
        scene.name = "made up"
        text = io.StringIO()
        with contextlib.redirect_stdout(text):
            contest.race("engine", [contest.Method("method", False, lambda _: True, make)], scene, True, 1)
        cells = [line.split(",") for line in text.getvalue().splitlines()]
        for line in cells:
            self.assertEqual((line[:3], len(line)), (["made up", "engine", "method"], 12))
        return {line[3]: (float(line[4]), line[-1]) for line in cells}

    def test_errors_and_failures_are_told_apart(self):
        runs = {1e-3: Run(0.5), 1e-6: Run(3.0), 1e-9: Run(0.0, False)}
        rows = self.rows(lambda _, setting: runs[setting])
        self.assertEqual(rows["0.001"], (0.5, "ok"))
        self.assertEqual([rows[setting][1] for setting in ("1e-06", "1e-09")], ["diverged", "refused"])
        self.assertTrue(math.isnan(rows["1e-06"][0]))

    def test_a_crash_and_a_run_without_end_cost_the_points_that_follow(self):
        for bad, outcome in ((Run(None), "refused"), (Run(0.0, seconds=20), "timed out")):
            rows = self.rows(lambda _, setting: bad if setting == 1e-6 else Run(0.0))  # pylint: disable=cell-var-from-loop
            self.assertEqual({setting: row[1] for setting, row in rows.items()}, {"0.001": "ok", "1e-06": outcome})

    def test_a_program_that_ends_did_not_crash(self):
        self.assertEqual([list(contest.lines_of(lambda: iter([k]), 5)) for k in range(20)], [[k] for k in range(20)])


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    del sys.argv[1]
    unittest.main()
