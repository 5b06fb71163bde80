#!/usr/bin/python3
"""sweep: its values, its files, its interruptions.

    sweep_test.py BIN [unittest options]        BIN: the folder that holds the tools; PYTHONPATH finds planar_chain
"""
import csv
import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
import unittest

try:
    import numpy as np
except ImportError:
    print("numpy not found: skipped")
    sys.exit(77)

from planar_chain import Scene, simulate_many
from planar_chain.sweeps import BadSweep, table_of
from sweep_tool import ANGLE, BIN, LIMIT, MASS, SCENE, VARIED, SweepTool


class Tables(unittest.TestCase):
    def test_the_grid_begins_again_and_random_columns_have_streams_of_their_own(self):
        paths, values = table_of([("a", "1:2:3"), ("b", "7,9"), ("c", "uniform(0, 1)"), ("d", "uniform(0,1)")], 7, 5)
        self.assertEqual(paths, ["a", "b", "c", "d"])
        self.assertEqual(values[:, 0].tolist(), [1, 1, 1.5, 1.5, 2, 2, 1])
        self.assertEqual(values[:, 1].tolist(), [7, 9, 7, 9, 7, 9, 7])
        self.assertEqual(len(set(values[:, 2:].ravel())), 14)
        self.assertTrue((values[:, 2:] == table_of([("a", "1"), ("b", "7"), ("c", "uniform(0,1)"), ("d", "uniform(0,1)")],
                                                   9, 5)[1][:7, 2:]).all())
        self.assertEqual(table_of([("a", "1:2:3"), ("b", "7,9")], None, 0)[1].shape, (6, 2))
        many = table_of([("a", "normal(3, 0.5)")], 10000, 1)[1]
        self.assertAlmostEqual(many.mean(), 3, delta=0.02)
        self.assertAlmostEqual(many.std(), 0.5, delta=0.02)

    def test_other_values_are_refused(self):
        for text in ("", "x", "1:2", "1:2:0", "1:2:1", "1:2:2.5", "1:2:3:4", "normal(1)", "normal(1,-1)", "nan", "1,inf", "cauchy(0,1)",
                     "uniform(2,1)", "uniform(-1e308,1e308)", "1:2:inf", "1:2:nan", "1:2:1e15"):
            with self.assertRaisesRegex(BadSweep, "--vary: expected"):
                table_of([("a", text)], None, 0)
        for text, hint in (("0,5:2:3", True), ("normal(0,3,0,01)", True), ("normal(0,3,-0,01)", False), ("0,5:x:3", False)):
            with self.assertRaisesRegex(BadSweep, "got '.*'" + r" \(a decimal point, not a comma\?\)" * hint + "$"):
                table_of([("a", text)], None, 0)
        self.assertEqual(set(table_of([("a", "uniform(2,2)")], 3, 0)[1].ravel()), {2})
        with self.assertRaisesRegex(BadSweep, "--vary: expected each path once, got a 2 times"):
            table_of([("a", "1"), ("b", "1"), ("a", "2")], None, 0)
        for runs in (0, -1, 10 ** 30):
            with self.assertRaisesRegex(BadSweep, f"--runs: expected a number from 1, the points of the grid, to 100000000, got {runs}"):
                table_of([("a", "1")], runs, 0)
        with self.assertRaisesRegex(BadSweep, "--runs: expected a number from 6, the points of the grid, to 100000000, got 4"):
            table_of([("a", "1,2"), ("b", "1:3:3")], 4, 0)
        with self.assertRaisesRegex(BadSweep, "--runs: expected .* to 100000000, got 10000000000"):
            table_of([("a", "0:1:100000"), ("b", "0:1:100000")], None, 0)


class Sweeps(SweepTool):
    def test_its_files_hold_what_simulate_many_gives(self):
        self.sweep(*VARIED, "--runs", "50", "--duration", "1", "--instants", "2", "--chunk", "7",
                   output=("runs.csv", "runs.npz"))
        with np.load(self.path("runs.npz")) as kept:
            values, states = kept["values"], kept["states"]
            self.assertEqual((kept["times"].tolist(), kept["done"].all(), set(kept["reasons"])), ([0.5, 1], True, {""}))
        self.assertEqual(values.shape, (50, 2))
        many = simulate_many(Scene.from_file(SCENE), [0.5, 1], parameters={MASS: values[:, 0], ANGLE: values[:, 1]})
        self.assertEqual(states.tolist(), many.states.tolist())
        header, *rows = csv.reader(self.text("runs.csv").splitlines())
        self.assertEqual(header, ["run", MASS, ANGLE, "t", "q_upper_joint", "q_lower_joint", "qd_upper_joint",
                                  "qd_lower_joint", "reason"])
        self.assertEqual([[float(x) for x in row[:-1]] for row in rows],
                         [[run, *values[run], t, *states[run, k]] for run in range(50) for k, t in enumerate((0.5, 1))])
        self.assertEqual(sorted(os.listdir(self.folder)), ["runs.csv", "runs.npz"])

    def test_it_finds_the_module_of_its_build_alone(self):
        bare = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        run = subprocess.run(self.command("--vary", MASS + "=1,2", "--duration", "0.1"), env=bare, stdout=subprocess.DEVNULL, check=False)
        self.assertEqual(run.returncode, 0)

    def test_what_fails_is_kept_with_its_reason_and_drawn(self):
        said = self.sweep("--vary", MASS + "=-1:2:4", "--duration", "1", status=3)
        self.assertRegex(said, "^sweep: 4 runs written to .*; 2 failed, the first: links/lower/mass: expected a number > 0 kg, got -1$")
        rows = list(csv.reader(self.text("runs.csv").splitlines()))[1:]
        self.assertEqual([row[-1] != "" for row in rows], [True, True, False, False])
        self.assertEqual(rows[0][3:7], ["nan"] * 4)
        subprocess.run([os.path.join(BIN, "plot"), self.path("runs.csv")], check=True, stdout=subprocess.DEVNULL)
        self.assertGreater(os.path.getsize(self.path("runs.csv.png")), 10000)

    def test_a_sweep_of_which_every_run_fails_has_failed(self):
        for chunk in ("1", "500"):
            said = self.sweep("--vary", MASS + "=-1,-2", "--duration", "1", "--chunk", chunk, "--overwrite", status=1)
            self.assertRegex(said, "^sweep: 2 runs written to .*; 2 failed, the first: links/lower/mass: expected a number > 0 kg, got -1$")
            self.assertEqual(len(self.text("runs.csv").splitlines()), 3)

    def test_a_folder_of_somebody_else_is_left_alone(self):
        os.mkdir(self.path("runs.csv.parts"))
        notes = self.path("runs.csv.parts/notes.txt")
        with open(notes, "w", encoding="utf-8"):
            pass
        said = self.sweep("--vary", MASS + "=1,2", "--duration", "1", status=2)
        self.assertRegex(said, "^sweep: --output: expected .*runs.csv.parts to be a sweep's own folder, got notes.txt in it$")
        self.assertTrue(os.path.exists(notes))
        with open(self.path("other.csv.parts"), "w", encoding="utf-8"):
            pass
        said = self.sweep("--vary", MASS + "=1,2", "--duration", "1", status=2, output=("other.csv",))
        os.mkdir(self.path("new.csv.parts"))
        inside = self.sweep("--vary", MASS + "=1,2", "--duration", "1", status=2, output=("new.csv", "new.csv.parts/x.npz"))
        self.assertRegex(inside, "^sweep: --output: expected a file outside of .*new.csv.parts, which is removed at the end, got .*x.npz$")
        self.assertRegex(said, "^sweep: --output: expected .*other.csv.parts to be a sweep's own folder, got a file$")

    def test_a_partial_file_of_somebody_else_is_left_alone(self):
        with open(self.path("runs.csv.partial"), "w", encoding="utf-8") as file:
            file.write("mine")
        for more in ((), ("--overwrite",)):
            said = self.sweep("--vary", MASS + "=1,2", "--duration", "1", *more, status=2)
            self.assertRegex(said, r"^sweep: --output: expected no file .*runs.csv.partial, which a sweep of .*runs.csv has while it runs, got one$")
        self.assertEqual((self.text("runs.csv.partial"), os.listdir(self.folder)), ("mine", ["runs.csv.partial"]))

    def test_an_output_that_comes_later_replaces_nothing(self):
        arguments = ("--vary", MASS + "=1,2", "--duration", "1")
        self.killed(*arguments)
        for name, words in (("new.npz.partial", "expected no file .*new.npz.partial"), ("new.npz", "expected a new file, got .*new.npz")):
            with open(self.path(name), "w", encoding="utf-8") as file:
                file.write("mine")
            self.assertRegex(self.sweep(*arguments, output=("runs.csv", "new.npz"), status=2), words)
            self.assertEqual(self.text(name), "mine")
            os.remove(self.path(name))
        self.sweep(*arguments, output=("runs.csv", "new.npz"))
        self.assertEqual(sorted(os.listdir(self.folder)), ["new.npz", "runs.csv", "runs.npz.partial"])

    def test_two_names_of_one_output_have_one_lock(self):
        os.symlink(self.path("runs.csv"), self.path("link.csv"))
        arguments = (*VARIED, "--runs", "2000", "--duration", "30", "--chunk", "20")
        with subprocess.Popen(self.command(*arguments), stderr=subprocess.PIPE, universal_newlines=True) as process:
            os.makedirs(self.path("runs.csv.parts"), exist_ok=True)
            self.wait_for_chunks(1, process)
            self.assertIn("expected a file that no other sweep writes", self.sweep(*arguments, status=2, output=("link.csv",)))
            process.kill()
            process.communicate()

    def test_it_continues_over_a_partial_file_of_its_own(self):
        arguments = ("--vary", MASS + "=1,2", "--duration", "1")
        self.killed(*arguments)
        os.rename(self.path("runs.csv"), self.path("runs.csv.partial"))  # as if killed while it wrote
        self.sweep(*arguments, output=("runs.csv", "runs.npz"))
        self.assertEqual(sorted(os.listdir(self.folder)), ["runs.csv", "runs.npz"])
        with open(self.path("early.csv.partial"), "w", encoding="utf-8"):
            pass  # as of one that was killed before it described itself
        self.sweep(*arguments, output=("early.csv",))
        self.assertEqual(sorted(os.listdir(self.folder)), ["early.csv", "runs.csv", "runs.npz"])

    def test_one_that_is_killed_at_its_end_leaves_no_chunk_to_another(self):
        self.killed("--vary", MASS + "=1,2", "--duration", "1", at="shutil.rmtree")
        self.assertEqual(sorted(os.listdir(self.path("runs.csv.parts"))), ["lock", "sweep.json"])

    def test_no_run_begins_if_an_output_cannot_be_written(self):
        os.mkdir(self.path("folder.csv"))
        for output, words in ((("runs.csv", "missing/runs.npz"), "missing/runs.npz: No such file or directory"),
                              (("missing/runs.csv",), "missing/runs.csv: No such file or directory"),
                              (("folder.csv",), "folder.csv: Is a directory")):
            said = self.sweep("--vary", MASS + "=1,2", "--duration", "1", "--overwrite", output=output, status=2)
            self.assertRegex(said, f"^sweep: --output: expected a file that can be written, got .*{words}$")
        self.assertEqual(os.listdir(self.folder), ["folder.csv"])

    def test_a_link_stays_a_link(self):
        os.mkdir(self.path("there"))
        os.symlink("there/true.csv", self.path("runs.csv"))
        for values in ("1,2", "3,4"):  # to no file, to a file
            self.sweep("--vary", f"{MASS}={values}", "--duration", "1", "--overwrite")
            self.assertTrue(os.path.islink(self.path("runs.csv")))
            self.assertEqual(os.listdir(self.path("there")), ["true.csv"])
            self.assertIn(f"\n0,{values[0]},1,", self.text("there/true.csv"))

    def test_a_urdf_is_a_scene(self):
        command = [os.path.join(BIN, "sweep"), self.robot(), "--vary", "links/rod/initial/angle=1,2", "--vary", "links/rod/mass=2",
                   "--duration", "0.1", "--output", self.path("robot.csv")]
        subprocess.run(command, timeout=LIMIT, check=True)
        header, *rows = csv.reader(self.text("robot.csv").splitlines())
        self.assertEqual(header[:5], ["run", "links/rod/initial/angle", "links/rod/mass", "t", "q_pin"])
        self.assertEqual([row[1:3] for row in rows], [["1", "2"], ["2", "2"]])
        many = simulate_many(Scene.from_file(self.robot()), [0.1], parameters={"links/rod/initial/angle": np.array([1.0, 2.0])})
        np.testing.assert_allclose([[float(x) for x in row[4:6]] for row in rows], many.states[:, 0], rtol=1e-12)

    def test_notes_on_a_scene_come_once_and_in_words(self):
        command = [os.path.join(BIN, "sweep"), "four_bar", "--vary", "links/rocker/mass=1,2", "--duration", "0.1", "--output", self.path("bar.csv")]
        run = subprocess.run(command, stderr=subprocess.PIPE, universal_newlines=True, timeout=LIMIT, check=True)
        self.assertRegex(run.stderr, r"\Asweep: note: tip.*\nsweep: note: 2 of 2 runs have notes; of run 0: tip.*\n\Z")

    def test_notes_on_runs_are_counted_and_kept(self):
        friction = "links/lower/joint/friction"
        said = self.sweep("--vary", friction + "=0,1e-12,1e-3,1e-13", "--duration", "0.1", "--chunk", "3", output=("runs.npz",))
        self.assertRegex(said, rf"sweep: note: 2 of 4 runs have notes; of run 1: {friction}: is left out: .*\n")
        with np.load(self.path("runs.npz")) as kept:
            self.assertEqual([bool(note) for note in kept["notes"]], [False, True, False, True])

    def test_a_full_disk_loses_nothing(self):
        arguments = ("--vary", MASS + "=1:2:3000", "--duration", "1", "--instants", "10", "--chunk", "3000")
        command = shlex.join(self.command(*arguments))
        run = subprocess.run(["bash", "-c", f"ulimit -f 8; exec {command}"], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                             universal_newlines=True, timeout=LIMIT, check=False)
        self.assertEqual(run.returncode, 1)
        self.assertRegex(run.stderr, r"^sweep: cannot write .*runs.csv.parts/000000000.npz: File too large \(after 0 of 3000 runs; the same command goes on from there\)$")
        self.assertEqual(sorted(os.listdir(self.path("runs.csv.parts"))), ["lock", "sweep.json"])
        self.sweep(*arguments)
        self.assertEqual(len(self.text("runs.csv").splitlines()), 30001)

    def test_outputs_that_are_given_one_by_one_are_all_written(self):
        arguments = ("--vary", MASS + "=1:2:3", "--duration", "0.1", "--output", self.path("first.npz"))
        self.assertRegex(self.sweep(*arguments, output=("runs.csv", "runs.npz")), "first.npz and .*runs.csv and .*runs.npz")
        self.assertEqual(sorted(os.listdir(self.folder)), ["first.npz", "runs.csv", "runs.npz"])
        twice = self.sweep(*arguments, output=("runs.csv", "./first.npz"), status=2)
        self.assertRegex(twice, "--output: expected a file that is not another of the run's, got .*/./first.npz")
        own = self.path("own.csv")
        shutil.copy(SCENE, own)
        for name in ("own.csv", "link.csv"):
            run = subprocess.run([os.path.join(BIN, "sweep"), own, *arguments[:4], "--overwrite", "--output", self.path(name)],
                                 stderr=subprocess.PIPE, universal_newlines=True, timeout=LIMIT, check=False)
            self.assertEqual(run.returncode, 2)
            self.assertIn("expected a file that is not another of the run's", run.stderr)
            if name == "own.csv":
                os.symlink("own.csv", self.path("link.csv"))
        with open(SCENE, encoding="utf-8") as file:
            self.assertEqual(self.text("own.csv"), file.read())

    def test_a_chunk_that_holds_other_runs_is_refused(self):
        arguments = ("--vary", MASS + "=1:2:100", "--duration", "1", "--chunk", "20")
        self.killed("--vary", MASS + "=3:4:100", *arguments[2:])
        parts = self.path("runs.csv.parts")
        other = self.path("other.npz")
        os.rename(os.path.join(parts, "000000040.npz"), other)
        shutil.rmtree(parts)
        self.killed(*arguments, "--overwrite")
        older = os.path.join(parts, "000000060.npz")
        with np.load(older) as kept:
            mark = str(kept["holds"]).split()[-1]
            arrays = {name: kept[name] for name in kept.files if name != "holds"}
        np.savez(older, **arrays)
        shutil.copy(os.path.join(parts, "000000000.npz"), os.path.join(parts, "000000020.npz"))
        shutil.copy(other, os.path.join(parts, "000000040.npz"))
        said = self.sweep(*arguments, status=1)
        self.assertRegex(said, "^sweep: expected the chunks of this sweep, got other or damaged files; remove them:\n")
        for line, start, words in zip(said.splitlines()[1:], (20, 40, 60), (
                f"runs 0 to 19 of the sweep {mark}", r"runs 40 to 59 of the sweep [0-9a-f]{16}", "one of an older version, which does not say its runs")):
            self.assertRegex(line, rf"{start:09d}.npz: expected runs {start} to {start + 19} of the sweep {mark}, got {words}")
        self.assertEqual(len(said.splitlines()), 4)

    def test_damaged_chunks_are_all_named_before_any_run(self):
        arguments = ("--vary", MASS + "=1:2:100", "--duration", "1", "--chunk", "20")
        self.killed(*arguments)
        parts = self.path("runs.csv.parts")
        os.remove(os.path.join(parts, "000000040.npz"))  # is missing still when the others are refused
        with open(os.path.join(parts, "000000020.npz"), "r+b") as file:
            file.truncate(100)
        with open(os.path.join(parts, "000000060.npz"), "r+b") as file:
            file.seek(300)
            file.write(b"damaged!")
        with np.load(os.path.join(parts, "000000080.npz")) as kept:
            sound = {"holds": str(kept["holds"]), "states": np.zeros((20, 1, 4)), "done": np.ones(20, dtype=bool), "reasons": "{}",
                     "notes": "{}"}
        np.savez(os.path.join(parts, "000000080.npz"), **{**sound, "states": np.zeros((20, 2, 4))})
        said = self.sweep(*arguments, status=1)
        self.assertRegex(said, "^sweep: expected the chunks of this sweep, got other or damaged files; remove them:\n")
        self.assertEqual([line.split(".npz")[0][-9:] for line in said.splitlines()[1:]], ["000000020", "000000060", "000000080"])
        self.assertIn("000000080.npz: damaged (states of 20 x 2 x 4, not 20 x 1 x 4)", said)
        self.assertNotIn("000000040.npz", os.listdir(parts))
        for name, wrong, words in (("states", sound["states"].astype("U8"), "states of <U8, not float64"),
                                   ("states", sound["states"].astype(complex), "states of complex128, not float64"),
                                   ("done", sound["done"].astype("U8"), "done of <U8, not bool"),
                                   ("reasons", '{"0": 5}', "reasons or notes that are not a text for a run"),
                                   ("notes", '{"20": "why"}', "reasons or notes that are not a text for a run"),
                                   ("reasons", "[" * 100000, "damaged (")):
            np.savez(os.path.join(parts, "000000080.npz"), **{**sound, name: wrong})
            self.assertIn("000000080.npz: damaged (" + words.replace("damaged (", ""), self.sweep(*arguments, status=1))
        for name in ("000000020.npz", "000000060.npz", "000000080.npz"):
            os.remove(os.path.join(parts, name))
        self.sweep(*arguments)
        self.sweep(*arguments, output=("whole.csv",))
        self.assertEqual(self.text("runs.csv"), self.text("whole.csv"))

    def test_a_damaged_description_is_named(self):
        arguments = ("--vary", MASS + "=1:2:40", "--duration", "1", "--chunk", "20")
        for text in ("", "[1]", "{\x00", '{"scene": ', "[" * 100000, None):
            self.killed(*arguments)
            with open(self.path("runs.csv.parts/sweep.json"), encoding="utf-8") as file:
                text = text if text is not None else json.dumps({**json.load(file), "outputs": [5]})
            with open(self.path("runs.csv.parts/sweep.json"), "w", encoding="utf-8") as file:
                file.write(text)
            self.assertRegex(self.sweep(*arguments, status=2), r"^sweep: .*runs.csv.parts/sweep.json: expected the description of a sweep, "
                             r"got a damaged file; remove the folder\n$")
            shutil.rmtree(self.path("runs.csv.parts"))
            os.remove(self.path("runs.csv"))

    def test_bad_arguments_are_refused(self):
        for arguments, words in ((("--vary", MASS + "=1", "--vary", MASS + "=2"), f"each path once, got {MASS} 2 times"),
                                 (("--vary", "links/lower/masss=1", "--vary", "start=1"),
                                  'got "masss"\nstart: expected the path of a number'),
                                 (("--vary", MASS + "=uniform(2,1)"), "LOW <= HIGH, got 'uniform(2,1)'"),
                                 (("--vary", MASS + "=1", "--seed", "-1"), "--seed: expected a number >= 0, got -1"),
                                 (("--vary", MASS + "=1", "--chunk", "0"), "--chunk: expected a number > 0, got 0"),
                                 (("--vary", MASS + "=1", "--instants", "1000000000"), "--instants, --chunk: expected at most"),
                                 (("--vary", MASS + "=1", "--scheduler", "here"), "--scheduler: expected an address"),
                                 (("--vary", "links/lowr/mass=1"), 'links/lowr/mass: expected a link listed in chain (did you mean lower?), got "lowr"'),
                                 (("--vary", "loads/push/force/1=1"), "loads/push/force/1: expected a number of a list that the scene has, got nothing at \"loads/push/force\""),
                                 *((("--vary", still + "=1,2"), f"--vary: expected a number that changes the motion, got {still}, which acts only on") for still in (
                                     "publish/rate", "seed", "real_time_factor", "sensors/e/noise", "links/lower/joint/motor/time_constant")),
                                 (("--vary", MASS + "=1_0,2"), "--vary: expected FIRST:LAST:COUNT"), (("--vary", MASS + "=1:2:٣"), "--vary: expected FIRST"),
                                 (("--vary", MASS + "=1", "--runs", "1_0"), "argument --runs: invalid int value: '1_0'"),
                                 (("--vary", MASS), "--vary: expected PATH=VALUES"), ((), "--vary: expected at least one"),
                                 (("--vary", MASS + "=1", "--runs", "0"), "--runs: expected a number from 1"),
                                 (("--vary", MASS + "=1", "--duration", "nan"), "--duration: expected")):
            self.assertIn(words, self.sweep("--duration", "1", *arguments, status=2))
        self.assertIn("--output: expected names of files that end", self.sweep("--duration", "1", status=2, output=("runs.txt",)))
        os.mkfifo(self.path("pipe.csv"))
        self.assertIn("--output: expected names of files that end", self.sweep("--duration", "1", "--overwrite", status=2, output=("pipe.csv",)))
        os.remove(self.path("pipe.csv"))
        self.assertIn("--duration: expected a number > 0, at most 1e6, in s", self.sweep("--duration", "1e308", status=2))
        self.assertEqual(os.listdir(self.folder), [])

    def test_a_complete_sweep_is_replaced_only_on_request(self):
        arguments = ("--vary", MASS + "=1:2:4", "--duration", "1")
        self.sweep(*arguments)
        first = self.text("runs.csv")
        self.assertIn("runs.csv, which is complete (--overwrite", self.sweep(*arguments, "--seed", "8", status=2))
        self.sweep("--vary", MASS + "=1:2:5", "--duration", "1", "--overwrite")
        self.assertNotEqual(self.text("runs.csv"), first)

    def test_an_interrupted_sweep_goes_on_where_it_was(self):
        arguments = (*VARIED, "--runs", "2000", "--duration", "30", "--chunk", "20")
        self.sweep(*arguments, output=("whole.csv",))
        process = subprocess.Popen(self.command(*arguments), stderr=subprocess.PIPE, universal_newlines=True)
        os.makedirs(self.path("runs.csv.parts"), exist_ok=True)
        self.wait_for_chunks(3, process)
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=LIMIT)[1]
        self.assertEqual(process.returncode, 130, said)
        self.assertIn("the same command goes on from there", said)
        kept = {name: os.path.getmtime(self.path("runs.csv.parts/" + name))
                for name in os.listdir(self.path("runs.csv.parts")) if not name.endswith(".partial")}
        self.assertLess(len(kept), 100)
        self.assertIn("expected the chunks of this sweep", self.sweep(*arguments, "--seed", "8", status=2))
        plain = subprocess.run(self.command(*arguments), env={**os.environ, "PLANAR_CHAIN_PLAIN_KERNEL": "1"}, stderr=subprocess.PIPE,
                               universal_newlines=True, check=False)
        self.assertIn("got those of another, which differs in its plain_kernel. ", plain.stderr)
        process = subprocess.Popen(self.command(*arguments))
        self.wait_for_chunks(len(kept), process)
        for name, when in kept.items():
            self.assertEqual(os.path.getmtime(self.path("runs.csv.parts/" + name)), when, name)
        self.assertEqual(process.wait(LIMIT), 0)
        self.assertEqual(self.text("runs.csv"), self.text("whole.csv"))

    def test_two_sweeps_of_one_file_do_not_meet(self):
        arguments = (*VARIED, "--runs", "2000", "--duration", "30", "--chunk", "20")
        process = subprocess.Popen(self.command(*arguments))
        os.makedirs(self.path("runs.csv.parts"), exist_ok=True)
        self.wait_for_chunks(1, process)
        self.assertRegex(self.sweep(*arguments, status=2), "^sweep: --output: expected a file that no other sweep writes, got .*runs.csv$")
        self.assertEqual(process.wait(LIMIT), 0)
        self.assertEqual(os.listdir(self.folder), ["runs.csv"])

    def test_two_sweeps_of_which_only_one_file_is_the_same_do_not_meet(self):
        long, short = (*VARIED, "--runs", "2000", "--duration", "30", "--chunk", "20"), ("--vary", MASS + "=1,2", "--duration", "1")
        interrupted = "kept.csv", "runs.csv", "runs.npz"
        self.killed(*short, output=interrupted)
        kept = os.listdir(self.folder)
        for first, second in ((("runs.csv", "both.npz"), ("both.npz",)), (("runs.csv",), ("other.csv", "runs.csv")),
                              (("runs.csv", "both.npz"), ("other.csv", "both.npz")), (("runs.csv",), interrupted)):
            process = subprocess.Popen(self.command(*long, "--overwrite", output=first), stderr=subprocess.DEVNULL)
            os.makedirs(self.path("runs.csv.parts"), exist_ok=True)
            self.wait_for_chunks(1, process)
            self.assertRegex(self.sweep(*short, "--overwrite", status=2, output=second),
                             r"^sweep: --output: expected no file .*\.partial, which a sweep of .* has while it runs, got one$")
            process.send_signal(signal.SIGINT)
            self.assertEqual(process.wait(LIMIT), 130)
            shutil.rmtree(self.path("runs.csv.parts"))
            self.assertEqual(os.listdir(self.folder), kept)


if __name__ == "__main__":
    unittest.main()
