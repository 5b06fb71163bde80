#!/usr/bin/python3
"""The pages of src/python/examples: their code runs, and finds what is known from elsewhere.

    example_pages_test.py BIN [unittest options]        BIN is not used; PYTHONPATH finds planar_chain
"""
import importlib.util
import os
import re
import subprocess
import sys
import unittest

try:
    import matplotlib  # noqa: F401  pylint: disable=unused-import
    import numpy as np
    import scipy  # noqa: F401  pylint: disable=unused-import
    import yaml
except ImportError:
    print("numpy, scipy, matplotlib or yaml not found: skipped")
    sys.exit(77)

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../..")
sys.path += [os.path.join(ROOT, "test/support"), os.path.join(ROOT, "test/node")]
from in_folder import InFolder  # noqa: E402


class Pages(InFolder):
    @staticmethod
    def text_of(page):
        with open(os.path.join(ROOT, "src/python/examples", page + ".md"), encoding="utf-8") as file:
            return file.read()

    def names_of(self, page):
        """Runs the code of a page in a folder of its own. Returns its names; its picture is there."""
        text = self.text_of(page)
        names, before = {"__name__": page}, os.getcwd()
        os.chdir(self.path("."))
        try:
            exec("".join(re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)), names)  # pylint: disable=exec-used
        finally:
            os.chdir(before)
        for picture in re.findall(r"!\[[^]]*\]\(([^)]*)\)", text):
            self.assertTrue(os.path.exists(self.path(picture)), picture)
        return names

    def test_the_walker_has_the_published_gaits(self):
        names = self.names_of("walker")
        # Garcia, Chatterjee, Ruina, Coleman 1998; the tolerance is their error: feet have no mass at all, ours 1e-9
        start, multipliers, _ = names["gait"]([0.2, -0.2])
        np.testing.assert_allclose(start, [0.200310900544287, -0.199832473004977], rtol=0, atol=1e-9)
        np.testing.assert_allclose(sorted(multipliers, key=np.imag), [-0.1901 - 0.5576j, -0.1901 + 0.5576j], rtol=0, atol=5e-5)
        _, multipliers, _ = names["gait"]([0.194, -0.204])
        np.testing.assert_allclose(sorted(multipliers), [0.4596, 4.0039], rtol=0, atol=5e-5)
        self.assertEqual([len(starts) for starts in names["walks"].values()], [16, 7, 4])

    def test_ilqr_gets_the_acrobot_up_and_lqr_holds_it(self):
        names = self.names_of("ilqr")
        self.assertLess(abs(names["states"][-1] - names["TOP"]).max(), 0.04)   # rad, rad/s: as the page says
        self.assertLess(abs(np.array(names["used"])).max(), 1.75)              # N m
        # The slowest of the poles at the top, 0.937 a period, leaves 1e-11 of an error in the last 8 s.
        self.assertLess(abs(names["plant"].state - names["TOP"]).max(), 1e-6)
        self.assertGreater(min(names["acrobot"].position("tip", x[:2])[1] for x in names["motion"][names["N"]:]), 0.45)  # m
        if importlib.util.find_spec("rospy"):
            self.assertRegex(self.said_in_the_node("balance.py"), r"\n10 s: off by .0\.000000 and .0\.000000 rad\n$")

    def said_in_the_node(self, controller):
        from own_master import Master  # pylint: disable=import-outside-toplevel
        with Master(), open(self.path("acrobot.yaml"), encoding="utf-8") as scene:
            from ros_node import Node  # pylint: disable=import-outside-toplevel
            with Node(yaml.safe_load(scene)):
                script = re.search("`" + controller + r"`:\n\n```py\n(.*?)^```$", self.text_of("ilqr"), re.MULTILINE | re.DOTALL).group(1)
                return subprocess.run([sys.executable, "-c", script], cwd=self.folder, stdout=subprocess.PIPE, universal_newlines=True,
                                      check=True, timeout=100).stdout

    def test_rollouts_from_the_whole_state_balance_the_pole_and_others_do_not(self):
        names = self.names_of("mpc")
        low = {name: 1 - np.sin(log[-20:, 2]).min() for name, log in names["runs"].items()}
        self.assertLess(low["whole state"], 0.01)   # other random numbers leave 0.0009 to 0.0014
        self.assertGreater(low["angles and rates alone"], 0.5)


if __name__ == "__main__":
    sys.argv.pop(1)
    unittest.main()
