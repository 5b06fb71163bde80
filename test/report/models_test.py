#!/usr/bin/python3
"""The study of models that others published: its figures are theirs and ours, and it notices a wrong one.

    models_test.py BIN [unittest options]        BIN is not used; PYTHONPATH finds planar_chain
"""
import csv
import io
import pathlib
import sys
import unittest

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).absolute().parent / "../.."
sys.path.insert(0, str(ROOT / "src/report"))
import models  # noqa: E402  pylint: disable=wrong-import-position

FILE = ROOT / "test/reference/models/models.json"
# Which is right, and how much the figures may differ: what DASSL errs at a tolerance of 1e-6, the last digit of a figure, rounding.
EXPECTED = {"PlanarMechanics.Pendulum": ("ours", 2e-5), "PlanarMechanics.DoublePendulum": ("ours", 2e-3),
            "PlanarMechanics.CraneCrab": ("ours", 1e-6), "Modelica.MultiBody.DoublePendulum": ("ours", 5e-5),
            "IFToMM A02, one loop": ("both", 1e-10), "walker, long: start of a step": ("both", 1e-13),
            "walker, long: multipliers": ("both", 5e-5), "walker, short: start of a step": ("both", 1e-13),
            "walker, short: multipliers": ("both", 5e-5)}


def rows_of(some):
    return [dict(zip(models.COLUMNS, row)) for model in some for row in models.rows_of(model)]


class Models(unittest.TestCase):
    def test_figures_and_ours_differ_by_what_is_expected(self):
        text = FILE.read_text(encoding="utf-8")
        rows = rows_of([*models.from_file(text), *models.walkers()])
        self.assertEqual(list(dict.fromkeys(row["model"] for row in rows)), list(EXPECTED))
        for row in rows:
            right, most = EXPECTED[row["model"]]
            self.assertEqual(row["right"], right, row)
            self.assertLess(float(row["difference"]), most, row)
        for row in [row for k, row in enumerate(rows) if k == 0 or rows[k - 1]["model"] != row["model"]]:
            self.assertRegex(row["source"], r".+, .+, (19|20)\d\d; .+")  # author, title, year; where

    def test_a_wrong_figure_or_scene_is_noticed(self):
        text = FILE.read_text(encoding="utf-8")
        for name, right, wrong, finding in (("IFToMM A02, one loop", "-30.3439449710", "-30.3439449810", "figure"),
                                            ("PlanarMechanics.Pendulum", "-0.39917297469010476", "-0.398", "open"),
                                            ("Modelica.MultiBody.DoublePendulum", '"mass": 13.86', '"mass": 13.87', "open")):
            self.assertIn(right, text)
            one = next(model for model in models.from_file(text.replace(right, wrong, 1)) if model.name == name)
            self.assertIn(finding, [row["right"] for row in rows_of([one])], name)

    def test_the_table_can_be_read(self):
        header, *rows = csv.reader(io.StringIO(models.measure(ROOT, [FILE])))
        self.assertEqual(header, models.COLUMNS)
        self.assertEqual({len(row) for row in rows}, {len(header)})


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    if models.why_not():
        print(f"{models.why_not()}: skipped")
        sys.exit(77)
    sys.argv.pop(1)
    unittest.main()
