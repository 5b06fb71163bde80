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
import numpy as np  # noqa: E402  pylint: disable=wrong-import-position
import figures  # noqa: E402  pylint: disable=wrong-import-position
import render  # noqa: E402  pylint: disable=wrong-import-position
import report  # noqa: E402  pylint: disable=wrong-import-position
import results  # noqa: E402  pylint: disable=wrong-import-position

BIN = ""
COLUMNS = ["scene", "engine", "method", "setting", "error_theta", "error_omega", "cpu_seconds", "evaluations", "steps",
           "rejected", "worst_step_seconds", "outcome"]
SCENES = ("pendulum", "triple", "stiffest4", "cart_pole", "four_bar")
COMMITTED = pathlib.Path(__file__).absolute().parent / "../../src/report/page"
MOST_BYTES = 1.0e6


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
        others = {results.side_of((row["engine"], "")) for row in table(cls.folder / "work_precision.csv")}
        cls.drawn = [*SCENES, "asked", "against_own", "orders", *(["against_programs"] if "programs" in others else [])]

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
            self.assertEqual(row["error_theta"], "", row)
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
        self.assertEqual(sorted(pictures), sorted(f"{name}.svg" for name in self.drawn))
        for picture in pictures:
            ElementTree.parse(self.folder / picture)
        for target in re.findall(r'(?:src|href)="([^"]*)"', page):
            self.assertTrue(target in pictures or target.startswith("#") and f"id={target[1:]}" in page, target)
        for fact in ("commit", "-O", "rosrun planar_chain report"):
            self.assertIn(fact, page)
        self.assertEqual((self.folder / "about.json").read_text(encoding="utf-8").count('"commit"'), 1)  # of both studies

    def test_the_page_for_code_hosts_has_the_same_pictures(self):
        page = (self.folder / "README.md").read_text(encoding="utf-8")
        names = sorted(re.findall(r"!\[.+\]\((.*)\.png\)", page))
        self.assertEqual(names, sorted(self.drawn))
        for name in names:
            with PIL.Image.open(self.folder / f"{name}.png") as image:
                self.assertGreaterEqual(image.width, 700)
        self.assertNotIn("DOES NOT FIT", page)
        self.assertRegex(page, r"\| triple \|( [0-9.,e+]+ \|){3}")
        self.assertEqual(page.count("Left out: not measured."), 10)

    def test_curves_stand_before_tables(self):
        page = (self.folder / "index.html").read_text(encoding="utf-8")
        sections = [section for section in page.split("<h2")[1:] if "<table" in section]
        self.assertGreaterEqual(len(sections), 2)
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

    def test_it_says_why_errors_exceed_the_tolerance(self):
        page = (COMMITTED / "README.md").read_text(encoding="utf-8")
        for words in ("NOT EXPLAINED", "though expected not to"):
            self.assertNotIn(words, page)

    def test_it_is_small(self):
        files = [path for path in COMMITTED.iterdir() if path.suffix not in (".svg", ".html")]
        self.assertLess(sum(path.stat().st_size for path in files), MOST_BYTES)
        self.assertGreater(len(files), 30)


class Reasons(unittest.TestCase):
    """Where auto is not the fastest, from made-up points of errors 1e-2, 1e-4, 1e-6."""

    def verdict(self, level, side="own", **others):
        rows = []
        for name, (seconds, evaluations) in {"planar_chain auto": (1, 100), **others}.items():
            engine, method = name.split(" ")
            rows += [{"engine": engine, "method": method, "setting": f"{error:g}", "error_theta": f"{error:g}",
                      "cpu_seconds": str(seconds), "evaluations": str(evaluations), "outcome": "ok"}
                     for error in (1e-2, 1e-4, 1e-6)]
        return results.verdict(rows, level, 1e-12, side)

    def test_each_case_has_its_own(self):
        seen = set()
        for side, others, outcome in (("own", {"planar_chain dop853": (2, 100)}, "fastest"),
                                      ("own", {"planar_chain dop853": (0.5, 50)}, "slower"),
                                      ("own", {"planar_chain dop853": (0.5, 100)}, "slower"),
                                      ("own", {"planar_chain dopri5": (0.5, 50)}, "slower"),
                                      ("own", {"planar_chain rk4": (0.5, 50)}, "slower"),
                                      ("programs", {"Bullet RK4": (0.5, 50)}, "slower"),
                                      ("programs", {"Bullet RK4": (0.5, 100)}, "slower"),
                                      ("programs", {"Bullet RK4": (0.99, 100)}, "slower")):
            cell = self.verdict(4, side, **others)
            self.assertEqual(cell.outcome, outcome, others)
            self.assertNotIn(cell.why, seen)
            seen.add(cell.why)
        self.assertEqual(self.verdict(8).outcome, "nobody")
        self.assertEqual(self.verdict(5, "programs", **{"Bullet RK4": (0.5, 50)}).ratio, 2)

    def test_each_side_is_compared_by_itself(self):
        others = {"planar_chain dop853": (4, 1), "odeint Fehlberg": (0.125, 1), "Bullet RK4": (2, 1)}
        self.assertEqual({side: round(self.verdict(4, side, **others).ratio, 9) for side in results.SIDES},
                         {"own": 0.25, "programs": 0.5, "integrators": 8})

    def test_the_first_lines_name_what_is_near_or_ahead(self):
        cells = {("a", 3): self.verdict(4, "programs", **{"Bullet RK4": (0.5, 1)}),
                 ("a", 6): self.verdict(6, "programs", **{"Bullet RK4": (1.6, 1)}),
                 ("b", 3): self.verdict(4, "programs", **{"ODE Euler": (2, 1)}), ("b", 6): self.verdict(6, "programs")}
        self.assertEqual(results.in_words(results.ahead(cells, 1)), "a (Bullet): 2.00 at 1e-3")
        self.assertEqual(results.in_words(results.ahead(cells, 0.5, 1)), "a (Bullet): 0.62 at 1e-6")
        self.assertEqual(results.tally(cells, 0.5), (1, 3, 1))
        self.assertEqual(results.in_words([("a", "ODE", [(3, 1.5), (4, 1.2), (5, 2)]), ("b", "ODE", [(3, 1.5), (6, float("inf"))])]),
                         "a (ODE): 1.20 to 2.00 at 1e-3 to 1e-5; b (ODE): 1.50 to not reached at 1e-3, 1e-6")


class Excesses(unittest.TestCase):
    """Scenes of 10 s whose rounding moves the end by 1e-10, by the error of auto at a tolerance of 1e-6."""

    @staticmethod
    def excess(name, error, tolerance="1e-6"):
        row = {"engine": "planar_chain", "method": "auto", "setting": tolerance, "error_theta": str(error), "error_omega": "0", "outcome": "ok"}
        return [(each.is_explained, round(each.ratio, 6)) for each in results.excesses({name: {"rows": [row], "floor": 1e-10, "end_s": "10"}})]

    def test_an_excess_needs_a_reason_and_a_reason_an_excess(self):
        self.assertEqual(self.excess("triple", 9e-6), [])
        self.assertEqual(self.excess("triple", 2e-5), [(False, 2)])
        self.assertEqual(self.excess("double", 2e-5), [(True, 2)])
        self.assertEqual(self.excess("double", 9e-6), [(False, 0.9)])
        self.assertEqual(self.excess("double", 1e2), [(False, 1e7)])  # more than a rounding grows
        self.assertEqual(self.excess("triple", 2e-10, "1e-11"), [(True, 2)])  # rounding


class Short(unittest.TestCase):
    def test_tables_have_no_needless_characters(self):
        self.assertEqual(report.shorter("a 1.25,1.23456789e-05,nan,0.50,1000000.4,nan\n12,1.6.0\n"), "a 1.25,1.23457e-5,,0.5,1e+6,\n12,1.6.0\n")

    def test_fits_are_in_ten_lines(self):
        short = list(results.fits_in_short(results.read_table(COMMITTED / "fits.csv")))
        self.assertLessEqual(len(short), 10)
        self.assertEqual(short[0][:4], ("single", "authors'", 5, "0.081"))  # the median of 0.2231, 0.147, 0.081, 0.0147, 0.0205
        self.assertRegex(short[-1][-1], r"^friction \(N m\): 0.168 ± 0.01, 0.192 ± 0.008; com")

    def test_effects_are_named_without_their_number(self):
        rows = [{"scene": scene, "without": without, "seconds": seconds}
                for scene, without, seconds in (("a", "nothing", "10"), ("a", "1 rotor", "9"), ("b", "nothing", "10"), ("b", "3 rotors", "4"))]
        self.assertEqual(list(results.effects_in_short(rows)), [("rotors", 2, 10, 60, "b")])


class Pictures(unittest.TestCase):
    def test_the_verdict_has_one_scale_without_jumps_and_a_legend(self):
        scenes = [f"scene{k}" for k in range(60)]
        ratio = {name: 0.3 * 1.04**k for k, name in enumerate(scenes)}  # to 3
        figure = figures.verdict({(name, level): results.Cell("slower", ("odeint", "any"), ratio[name], 1, "")
                                  for name in scenes for level in results.LEVELS}, scenes, "method", 1)
        figure.canvas.draw()
        axes = figure.axes[0]
        rows = axes.collections[0].get_facecolors().reshape(len(scenes), len(results.LEVELS), 4)
        for one, next_one in zip(rows, rows[1:]):
            self.assertLess(abs(one - next_one).max(), 0.05)
        self.assertGreater(abs(rows[0] - rows[-1]).max(), 0.4)
        words = " ".join(text.get_text() for text in axes.get_legend().get_texts())
        for word in ("alone", "not reached", "–"):
            self.assertIn(word, words)

    @staticmethod
    def scene(*runs):
        """Of (engine, method, seconds, outcome), all with an error of 1e-5."""
        return figures.scene("title", [{"engine": engine, "method": method, "cpu_seconds": seconds, "error_theta": "1e-5", "outcome": outcome}
                                       for engine, method, seconds, outcome in runs], 1e-12).axes

    def test_no_plot_has_more_than_ten_series(self):
        own = ("auto", "rk4", "dopri5", "dop853", "rodas5p", "radau13", "taylor", "ros34pw2", "ros34pw2_fixed")
        others = [name for name in figures.COLOURS if name not in own]
        panels = self.scene(*[("planar_chain", method, "1", "ok") for method in own],
                            *[(other, method, "1", "ok") for other in others for method in "ab"])
        series = [[line for line in axes.lines if not line.get_label().startswith("_")] for axes in panels]
        self.assertEqual([len(each) for each in series], [10, 3, 9])

    def test_a_scene_says_above_the_curves_what_they_are(self):
        panels = self.scene(*[(engine, "auto", "1", "ok") for engine in ("planar_chain", "ODE", "SUNDIALS", "odeint")])
        self.assertEqual([axes.get_title() for axes in panels],
                         ["against other programs", "SUNDIALS and odeint\nunder our equations", "against its own methods"])
        drawn = [[line.get_label() for line in axes.lines if not line.get_label().startswith("_")] for axes in panels]
        self.assertEqual(drawn, [["auto", "ODE: auto"], ["auto", "SUNDIALS:\nauto", "odeint:\nauto"], ["auto"]])

    def test_a_scene_marks_the_slowest_failure_of_each_and_names_what_it_shows(self):
        _, own = self.scene(*[("planar_chain", method, seconds, outcome) for method in ("auto", "rk4")
                              for seconds, outcome in (("1e-5", "diverged"), ("1e-4", "diverged"), ("1e-3", "ok"))])
        marks = [line for line in own.lines if line.get_marker() == "x"]
        self.assertEqual([list(line.get_xdata()) for line in marks], [[1e-4], [1e-4]])
        self.assertEqual([text.get_text() for text in own.get_legend().get_texts()], ["auto", "rk4", "rounding", "diverged"])
        orders = {line.get_label(): line.get_zorder() for line in own.lines}
        self.assertLess(orders["auto"], orders["rk4"])

    def test_all_panels_of_a_scene_share_the_scale(self):
        left, right = self.scene(("planar_chain", "auto", "1e-3", "ok"), ("planar_chain", "rk4", "1e-5", "ok"), ("ODE", "Euler", "10", "ok"))
        self.assertEqual((left.get_xlim(), left.get_ylim()), (right.get_xlim(), right.get_ylim()))

    def test_each_program_has_a_colour_of_its_own(self):
        engines = {row["engine"] for row in results.read_table(COMMITTED / "work_precision.csv")} - {"planar_chain"}
        self.assertLessEqual(engines, set(figures.COLOURS))
        self.assertLessEqual(engines, set(figures.MARKS))
        colours = [matplotlib.colors.to_rgb(colour) for colour in figures.COLOURS.values()]
        for k, colour in enumerate(colours):
            for other in colours[:k]:
                self.assertGreater(max(abs(a - b) for a, b in zip(colour, other)), 0.1)

    def test_only_scenes_above_the_tolerance_are_named(self):
        scenes = {name: {"rows": [{"engine": "planar_chain", "method": "auto", "setting": "1e-6", "error_theta": error, "error_omega": error,
                                   "outcome": "ok"}], "floor": 1e-10, "end_s": "1"} for name, error in (("double", "1e-5"), ("triple", "1e-7"))}
        axes = figures.asked_and_got(scenes).axes[0]
        self.assertEqual([text.get_text() for text in axes.get_legend().get_texts()], ["double", "the other scenes"])

    def test_a_palette_keeps_even_areas(self):
        figure = figures.plt.figure(figsize=(4, 4), dpi=100)
        even = ["#%02x%02x%02x" % (96 + 4 * k, 174, 97) for k in range(40)]  # a scale
        for k, colour in enumerate(even):
            figure.add_artist(figures.plt.Rectangle((k / 40, 0.98), 1 / 40, 0.01, color=colour, linewidth=0, antialiased=False))
        for k in range(30):
            figure.text(0, 0.03 * k, "words whose edges have many shades, each more frequent", fontsize=7 + 0.1 * k, alpha=1 - 0.01 * k)
        figure.canvas.draw()
        drawn = PIL.Image.fromarray(np.asarray(figure.canvas.buffer_rgba())).convert("RGB")
        kept = {colour for _, colour in render.with_palette(drawn).convert("RGB").getcolors()}
        for colour in even:
            self.assertIn(tuple(round(255 * part) for part in matplotlib.colors.to_rgb(colour)), kept)


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
