#!/usr/bin/python3
"""report: its tables, its pages, what counts as failed, resuming, bad arguments; on a few scenes and studies. The page that
is committed.

    report_test.py BIN [unittest options]        BIN: the folder that holds it
"""
import csv
import fcntl
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from xml.etree import ElementTree

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).absolute().parent / "../../src/report"))
import matplotlib  # noqa: E402  pylint: disable=wrong-import-position
import PIL.Image  # noqa: E402  pylint: disable=wrong-import-position
import figures  # noqa: E402  pylint: disable=wrong-import-position
import results  # noqa: E402  pylint: disable=wrong-import-position

BIN = ""
COLUMNS = ["scene", "engine", "method", "setting", "error_theta", "error_omega", "cpu_seconds", "evaluations", "steps",
           "rejected", "worst_step_seconds", "outcome"]
SCENES = ("pendulum", "triple", "stiffest4", "cart_pole", "four_bar")
COMMITTED = pathlib.Path(__file__).absolute().parent / "../../src/report/page"
MEGABYTE = 10**6


def run(*arguments):
    return subprocess.run([os.path.join(BIN, "report"), *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          universal_newlines=True, timeout=200, check=False)


def table(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


class Report(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.scratch.name) / "new/report"
        cls.arguments = ["--output", str(cls.folder), "--quick", "--scenes", ",".join(SCENES), "--studies", "race,consistency"]
        cls.result = run(*cls.arguments)

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def rows(self, **values):
        return [row for row in table(self.folder / "work_precision.csv")
                if row["engine"] == "planar_chain" and all(row[name] == value for name, value in values.items())]

    def test_it_runs(self):
        self.assertEqual((self.result.returncode, self.result.stderr), (0, ""))

    def test_the_table_has_the_columns_agreed(self):
        with open(self.folder / "work_precision.csv", encoding="utf-8") as file:
            self.assertEqual(file.readline().strip().split(","), COLUMNS)
        self.assertEqual({row["scene"] for row in self.rows()}, set(SCENES))
        for row in self.rows():
            self.assertIn(row["outcome"], ("ok", "diverged", "refused", "timed out"))
            self.assertGreater(float(row["cpu_seconds"]), 0)

    def test_every_method_takes_part(self):
        self.assertEqual({row["method"] for row in self.rows(scene="triple")},
                         {"auto", "rk4", "dopri5", "dop853", "rodas5p", "ros34pw2", "ros34pw2_fixed", "radau13",
                          "taylor"})

    def test_errors_come_down_with_the_tolerance(self):
        for scene in ("pendulum", "triple"):
            for method in ("auto", "dopri5", "dop853", "taylor", "rodas5p", "radau13"):
                errors = [float(row["error_theta"]) for row in self.rows(scene=scene, method=method)]
                self.assertLess(errors[-1], 1e-7, (scene, method))
                self.assertLess(errors[-1], 1e-2 * errors[0], (scene, method))

    def test_carts_and_held_tips_end_where_they_should(self):
        for scene in ("cart_pole", "four_bar"):
            for method in ("auto", "dopri5", "dop853", "rodas5p", "radau13"):
                errors = [float(row["error_theta"]) for row in self.rows(scene=scene, method=method)]
                self.assertLess(errors[-1], 3e-8, (scene, method))

    def test_what_blows_up_is_not_ok(self):
        # Springs of 1e9 N m/rad: rk4 blows up with every step that is tried here.
        for row in self.rows(scene="stiffest4", method="rk4"):
            self.assertIn(row["outcome"], ("diverged", "timed out"), row)
            self.assertEqual(row["error_theta"], "nan", row)
        for row in self.rows(scene="stiffest4", method="auto"):
            self.assertEqual(row["outcome"], "ok", row)

    def test_methods_have_their_orders(self):
        page = (self.folder / "index.html").read_text(encoding="utf-8")
        orders = dict(re.findall(r"<td[^>]*>(\w+)</td><td[^>]*>pendulum</td><td[^>]*>\d+</td><td[^>]*>([0-9.]+)", page))
        for method, order in (("rk4", 4), ("dopri5", 5), ("dop853", 8), ("rodas5p", 5), ("ros34pw2", 3)):
            self.assertLess(abs(float(orders[method]) - order), max(0.5, 0.15 * order), orders)
        self.assertNotIn("DOES NOT FIT", page)

    def test_the_page_is_whole_and_needs_its_folder_only(self):
        page = (self.folder / "index.html").read_text(encoding="utf-8")
        pictures = re.findall(r'<img [^>]*src="([^"]*)"', page)
        self.assertEqual(sorted(pictures), sorted(f"{name}.svg" for name in (*SCENES, "asked", "verdict", "orders")))
        for picture in pictures:
            ElementTree.parse(self.folder / picture)
        for target in re.findall(r'(?:src|href)="([^"]*)"', page):
            self.assertTrue(target in pictures or target.startswith("#") and f"id={target[1:]}" in page, target)
        for fact in ("commit", "-O", "rosrun planar_chain report"):
            self.assertIn(fact, page)

    def test_the_page_for_code_hosts_has_the_same_pictures(self):
        page = (self.folder / "README.md").read_text(encoding="utf-8")
        names = sorted(re.findall(r"!\[.+\]\((.*)\.png\)", page))
        self.assertEqual(names, sorted((*SCENES, "asked", "verdict", "orders")))
        for name in names:
            with PIL.Image.open(self.folder / f"{name}.png") as image:
                self.assertGreaterEqual(image.width, 700)
        self.assertNotIn("DOES NOT FIT", page)
        self.assertRegex(page, r"\| triple \|( [0-9.,e+]+ \|){3}")
        self.assertEqual(page.count("Left out: not measured."), 9)

    def test_curves_stand_before_tables(self):
        page = (self.folder / "index.html").read_text(encoding="utf-8")
        sections = [section for section in page.split("<h2")[1:] if "<table" in section]
        self.assertGreaterEqual(len(sections), 3)
        for section in sections:
            self.assertLess(section.find("<img"), section.find("<table"), section[:80])
            self.assertIn("<img", section)

    def test_it_goes_on_where_it_was(self):
        path = self.folder / "work_precision.csv"
        whole = path.read_text(encoding="utf-8").splitlines(True)
        # Interrupted in the last scene: the others are kept, this one is measured again.
        marked = whole[1].replace(whole[1].split(",")[6], "1.234567e+00")
        kept = [line for line in whole[2:] if not line.startswith(SCENES[-1])]
        self.assertLess(len(kept), len(whole) - 2)
        path.write_text("".join([whole[0], marked, *kept]), encoding="utf-8")
        self.assertEqual(run(*self.arguments).returncode, 0)
        again = path.read_text(encoding="utf-8").splitlines(True)
        self.assertEqual(again[1], marked)
        key = [",".join(line.split(",")[:4]) for line in whole]
        self.assertEqual([",".join(line.split(",")[:4]) for line in again], key)
        # Measured by other programs: everything anew.
        about = self.folder / "about.json"
        about.write_text(about.read_text(encoding="utf-8").replace('"programs": "', '"programs": "0'), encoding="utf-8")
        self.assertEqual(run(*self.arguments).returncode, 0)
        self.assertNotEqual(path.read_text(encoding="utf-8").splitlines(True)[1], marked)

    def test_two_reports_do_not_write_one_folder(self):
        with tempfile.TemporaryDirectory() as folder:
            lock = os.open(folder, os.O_RDONLY)
            fcntl.flock(lock, fcntl.LOCK_EX)
            result = run("--output", folder, "--scenes", "pendulum", "--studies", "race")
            os.close(lock)
            self.assertEqual((result.returncode, os.listdir(folder)), (1, []), result.stderr)


class Committed(unittest.TestCase):
    """The page that the repository shows follows from the tables beside it."""

    def test_it_is_what_its_tables_give(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            for path in (*COMMITTED.glob("*.csv"), COMMITTED / "about.json"):
                shutil.copy(path, folder)
            subprocess.run([COMMITTED / "../render.py", folder], check=True)
            self.assertEqual((folder / "README.md").read_text(encoding="utf-8"),
                             (COMMITTED / "README.md").read_text(encoding="utf-8"))
            drawn = {path.name: self.facts_of(path) for path in folder.glob("*.png")}
        shown = {path.name: self.facts_of(path) for path in COMMITTED.glob("*.png")}
        self.assertEqual(set(shown), set(drawn))
        if {facts["Software"] for facts in shown.values()} == {f"Matplotlib {matplotlib.__version__}"}:
            self.assertEqual(shown, drawn)  # another version draws otherwise

    @staticmethod
    def facts_of(path):
        with PIL.Image.open(path) as image:
            return image.text

    def test_it_is_below_a_megabyte(self):
        files = [path for path in COMMITTED.iterdir() if path.suffix not in (".svg", ".html")]
        self.assertLess(sum(path.stat().st_size for path in files), MEGABYTE)
        self.assertGreater(len(files), 30)


class Reasons(unittest.TestCase):
    """Where auto is not the fastest, from made-up points of errors 1e-2, 1e-4, 1e-6."""

    def verdict(self, level, **others):
        rows = []
        for name, (seconds, evaluations) in {"planar_chain auto": (1, 100), **others}.items():
            engine, method = name.split(" ")
            rows += [{"engine": engine, "method": method, "setting": f"{error:g}", "error_theta": f"{error:g}",
                      "cpu_seconds": str(seconds), "evaluations": str(evaluations), "outcome": "ok"}
                     for error in (1e-2, 1e-4, 1e-6)]
        return results.verdict(rows, level, 1e-12)

    def test_each_case_has_its_own(self):
        seen = set()
        for others, outcome in (({"planar_chain dop853": (2, 100)}, "fastest"),
                                ({"planar_chain dop853": (0.5, 50)}, "slower"),
                                ({"planar_chain dop853": (0.5, 100)}, "slower"),
                                ({"planar_chain dopri5": (0.5, 50)}, "slower"),
                                ({"planar_chain rk4": (0.5, 50)}, "slower"),
                                ({"odeint Fehlberg": (0.5, 50)}, "slower"),
                                ({"odeint Fehlberg": (0.5, 100)}, "slower"),
                                ({"odeint Fehlberg": (0.99, 100)}, "slower")):
            cell = self.verdict(4, **others)
            self.assertEqual(cell.outcome, outcome, others)
            self.assertNotIn(cell.why, seen)
            seen.add(cell.why)
        self.assertEqual(self.verdict(8).outcome, "nobody")
        self.assertEqual(self.verdict(5, **{"odeint Fehlberg": (0.5, 50)}).ratio, 2)


class Pictures(unittest.TestCase):
    def test_the_verdict_has_one_scale_without_jumps_and_a_legend(self):
        scenes = [f"scene{k}" for k in range(60)]
        ratio = {name: 0.3 * 1.04**k for k, name in enumerate(scenes)}  # to 3
        figure = figures.verdict({(name, level): results.Cell("slower", ("odeint", "any"), ratio[name], 1, "")
                                  for name in scenes for level in results.LEVELS}, scenes)
        figure.canvas.draw()
        axes = figure.axes[0]
        rows = axes.collections[0].get_facecolors().reshape(len(scenes), len(results.LEVELS), 4)
        for one, next_one in zip(rows, rows[1:]):
            self.assertLess(abs(one - next_one).max(), 0.05)
        self.assertGreater(abs(rows[0] - rows[-1]).max(), 0.4)
        words = " ".join(text.get_text() for text in axes.get_legend().get_texts())
        for word in ("alone", "not reached", "–"):
            self.assertIn(word, words)

    def test_no_plot_has_more_than_ten_series(self):
        own = ("auto", "rk4", "dopri5", "dop853", "rodas5p", "radau13", "taylor", "ros34pw2", "ros34pw2_fixed")
        others = ("by hand", "odeint", "SUNDIALS", "MuJoCo", "Bullet", "DART", "Simbody", "ODE")
        who = [("planar_chain", method) for method in own] + [(other, method) for other in others for method in "ab"]
        rows = [{"engine": engine, "method": method, "cpu_seconds": "1", "error_theta": "1e-5", "outcome": "ok"}
                for engine, method in who]
        panels = figures.scene("title", rows, 1e-12).axes
        series = [[line for line in axes.lines if not line.get_label().startswith("_")] for axes in panels]
        self.assertEqual([len(each) for each in series], [9, 9])


    def test_a_scene_marks_the_slowest_failure_of_each_and_names_what_it_shows(self):
        rows = [{"engine": "planar_chain", "method": method, "cpu_seconds": seconds, "error_theta": "1e-5", "outcome": outcome}
                for method in ("auto", "rk4") for seconds, outcome in (("1e-5", "diverged"), ("1e-4", "diverged"), ("1e-3", "ok"))]
        left = figures.scene("title", rows, 1e-12).axes[0]
        marks = [line for line in left.lines if line.get_marker() == "x"]
        self.assertEqual([list(line.get_xdata()) for line in marks], [[1e-4], [1e-4]])
        self.assertEqual([text.get_text() for text in left.get_legend().get_texts()], ["auto", "rk4", "rounding", "diverged"])
        orders = {line.get_label(): line.get_zorder() for line in left.lines}
        self.assertLess(orders["auto"], orders["rk4"])

    def test_both_panels_of_a_scene_share_the_scale(self):
        rows = [{"engine": engine, "method": method, "cpu_seconds": seconds, "error_theta": "1e-5", "outcome": "ok"}
                for engine, method, seconds in (("planar_chain", "auto", "1e-3"), ("planar_chain", "rk4", "1e-5"),
                                                ("ODE", "Euler", "10"))]
        left, right = figures.scene("title", rows, 1e-12).axes
        self.assertEqual((left.get_xlim(), left.get_ylim()), (right.get_xlim(), right.get_ylim()))

    def test_no_two_curves_have_one_colour(self):
        rows = [{"engine": "planar_chain", "method": "auto", "setting": "1e-5", "error_theta": "1e-6", "error_omega": "1e-6",
                 "outcome": "ok"}]
        axes = figures.asked_and_got({f"scene{k}": {"rows": rows} for k in range(17)}).axes[0]
        costs = figures.effects([{"scene": "a", "without": name, "seconds": "1"} for name in ("nothing", *"abcdefghijklm")]).axes[0]
        for colours in (figures.COLOURS.values(), [line.get_color() for line in axes.lines],
                        [line.get_color() for line in costs.lines[:-1]]):  # the last one is at 1
            colours = [matplotlib.colors.to_rgb(colour) for colour in colours]
            for k, colour in enumerate(colours):
                for other in colours[:k]:
                    self.assertGreater(max(abs(a - b) for a, b in zip(colour, other)), 0.1)


class Arguments(unittest.TestCase):
    def test_wrong_ones_are_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            for arguments in ([], ["--quick"], ["--output"], ["--output", folder, "--fast"], ["--output", folder, "more"],
                              ["--output", folder, "--scenes", "nobody"], ["--output", folder, "--studies", "race,"],
                              ["--output", "/dev/null/report"], ["--output", __file__], ["--output", ""], ["--output", "-"]):
                result = run(*arguments)
                self.assertEqual((result.returncode, result.stdout), (2, ""), arguments)
                self.assertNotEqual(result.stderr, "", arguments)
            self.assertEqual(os.listdir(folder), [])

    def test_help_is_no_error(self):
        self.assertEqual(run("--help").returncode, 0)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    BIN = sys.argv.pop(1)
    unittest.main()
