#!/usr/bin/python3
"""The program of cpp_example finds planar_chain by find_package, where it is built and where it is installed, and prints
the motion of pendulum.csv, which comes from elliptic functions.

    cpp_example_test.py BUILD DEVEL [unittest options]        BUILD: a finished build; DEVEL: its devel space
"""
import csv
import os
import re
import subprocess
import sys
import unittest

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../support"))
from in_folder import InFolder  # noqa: E402

TEST = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
BUILD, DEVEL = sys.argv.pop(1), sys.argv.pop(1)


def run(*command):
    result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True, check=False,
                            timeout=250)
    assert result.returncode == 0, f"{command}\n{result.stdout}"
    return result.stdout


class Example(InFolder):
    def check(self, prefix):
        with open(os.path.join(TEST, "reference/pendulum.csv"), encoding="utf-8", newline="") as file:
            known = {(row["quantity"], row["t"]): float(row["value"]) for row in csv.DictReader(file)
                     if row["motion"] == "horizontal"}
        build = self.path("build")
        run("cmake", "-S", os.path.join(TEST, "cpp_example"), "-B", build, f"-DCMAKE_PREFIX_PATH={prefix}",
            "-DCMAKE_CXX_FLAGS=-Wall -Wextra -Wpedantic -Werror", "-DPYTHON_EXECUTABLE=/usr/bin/python3")
        with open(os.path.join(build, "CMakeCache.txt"), encoding="utf-8") as file:
            self.assertIn(f"planar_chain_DIR:PATH={prefix}/share/planar_chain/cmake\n", file.read())
        run("cmake", "--build", build)
        lines = re.findall(r"(\S+) s: (\S+) rad, (\S+) rad/s\n", run(os.path.join(build, "swing")))
        self.assertEqual([t for t, _, _ in lines], ["0.25", "0.5", "1"])
        for t, q, qd in lines:
            self.assertLess(abs(float(q) - known["q", t]), 1e-5)  # six digits are printed
            self.assertLess(abs(float(qd) - known["qd", t]), 1e-5)

    def test_where_it_is_built(self):
        self.check(DEVEL)

    def test_where_it_is_installed(self):
        prefix = self.path("install")
        run("cmake", "--install", BUILD, "--prefix", prefix)
        self.check(prefix)


if __name__ == "__main__":
    unittest.main()
