#!/usr/bin/python3
"""stability --quick: what it measures agrees with the theory of linear stability.

    stability_test.py BIN [unittest options]        BIN: the folder that holds it
"""
import csv
import os
import subprocess
import sys
import unittest

BIN = ""
CLOSE_TO_REST = ("stiff", "stiff_damped", "heavy_tip", "long")


def run(*arguments):
    return subprocess.run([os.path.join(BIN, "stability"), *arguments], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, universal_newlines=True, timeout=200)


class Tool(unittest.TestCase):
    @unittest.skipUnless(os.path.exists("/dev/full"), "no /dev/full")
    def test_output_that_cannot_be_written_fails_the_run(self):
        with open("/dev/full", "w") as full:
            result = subprocess.run([os.path.join(BIN, "stability"), "--help"], stdout=full, stderr=subprocess.PIPE,
                                    universal_newlines=True, timeout=60)
        self.assertEqual((result.returncode, result.stderr),
                         (1, "stability: cannot write standard output: No space left on device\n"))

    def test_arguments_without_options_are_refused(self):
        result = run("more")
        self.assertEqual(result.returncode, 2)
        self.assertIn("expected options alone, got arguments without --\n", result.stderr)


class Measured(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.result = run("--quick", "--csv", "-")
        cls.all_rows = list(csv.DictReader(cls.result.stdout.splitlines()))

    def rows(self, method, *families):
        found = [row for row in self.all_rows if row["method"] == method and row["family"] in families]
        self.assertGreaterEqual(len(found), 2 * len(families))
        return found

    def test_it_runs(self):
        self.assertEqual(self.result.returncode, 0, self.result.stderr)
        self.assertEqual({row["method"] for row in self.all_rows},
                         {"rk4", "dopri5", "dop853", "rodas5p", "ros34pw2", "radau13", "taylor", "auto"})

    def test_rk4_goes_as_far_as_theory_says(self):
        for row in self.rows("rk4", "stiff"):
            theory = 2.828427 / float(row["largest_eigenvalue"])
            self.assertLess(abs(float(row["largest_stable_s"]) / theory - 1), 0.15, row)

    def test_so_do_damped_chains_and_long_ones(self):
        for method in ("rk4", "dop853"):
            for row in self.rows(method, *CLOSE_TO_REST):
                theory = float(row["predicted_s"])
                if row["largest_stable_s"]:
                    self.assertLess(abs(float(row["largest_stable_s"]) / theory - 1), 0.15, row)
                else:
                    self.assertLess(theory, 2e-8, row)  # beyond what is tried

    def test_frequencies_follow_the_root_of_the_stiffness(self):
        frequency = {float(row["value"]): float(row["largest_eigenvalue"]) for row in self.rows("rk4", "stiff")}
        self.assertLess(abs(frequency[1e9] / frequency[1e6] / 1000**0.5 - 1), 1e-2)

    def test_explicit_methods_blow_up_beyond(self):
        for method in ("rk4", "dopri5", "dop853"):
            for row in self.rows(method, *CLOSE_TO_REST):
                self.assertIn(row["how"], ("grows", "not finite"), row)

    def test_implicit_methods_bear_every_step_close_to_rest(self):
        for method in ("rodas5p", "ros34pw2"):
            for row in self.rows(method, *CLOSE_TO_REST):
                self.assertEqual((float(row["largest_stable_s"]), row["unstable_s"]), (1, ""), row)

    def test_radau13_ends_where_its_stages_are_not_found(self):
        for row in self.rows("radau13", *CLOSE_TO_REST):
            self.assertIn(row["how"], ("", "not finite"), row)

    def test_what_spins_faster_bears_shorter_steps(self):
        # Without gravity the rate is the only time there is.
        for method in ("rk4", "dop853"):
            angle = [float(row["value"]) * float(row["largest_stable_s"]) for row in self.rows(method, "spin")]
            self.assertLess(max(angle) / min(angle), 1.15, angle)
            self.assertLess(max(angle), 1, angle)

    def test_but_not_on_a_whip(self):
        with_limit = [row for row in self.all_rows if row["family"] == "whip" and row["method"] != "auto"]
        self.assertEqual(len(with_limit), 7)
        for row in with_limit:
            self.assertNotEqual(row["unstable_s"], "", row)


class Arguments(unittest.TestCase):
    def test_wrong_ones_are_refused(self):
        for arguments in (["--fast"], ["scene.yaml"], ["--quick", "--csv", "/no/such/folder/out.csv"]):
            result = run(*arguments)
            self.assertEqual((result.returncode, result.stdout), (2, ""), result.stderr)

    def test_a_full_disk_is_a_failure(self):
        result = run("--quick", "--csv", "/dev/full")
        self.assertEqual((result.returncode, result.stdout, result.stderr), (1, "", "stability: cannot write /dev/full: No space left on device\n"))


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    BIN = sys.argv.pop(1)
    unittest.main()
