"""The tool plot for its tests: as a program, and as modules. The first argument is BIN, the folder that holds simulate, equations and plot."""
import os
import subprocess
import sys

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../support"))
from in_folder import InFolder  # noqa: E402

BIN = sys.argv.pop(1)
sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "../../src/tools"))
import chain  # noqa: E402
import plot  # noqa: E402
import plot_panels  # noqa: E402  pylint: disable=unused-import
import plot_read  # noqa: E402  pylint: disable=unused-import
import plot_runs  # noqa: E402  pylint: disable=unused-import
from chain import read_chain  # noqa: E402
from drawing.body import Body  # noqa: E402

chain.EQUATIONS = os.path.join(BIN, "equations")
SCENES = os.path.join(os.path.dirname(os.path.realpath(__file__)), "../../config/scenes")
SCENE = os.path.join(SCENES, "triple.yaml")
JOINTS = ["shoulder_pin", "elbow_pin", "hand_pin"]


def body_of(scene):
    return Body(read_chain(scene))


class PlotTool(InFolder):
    def tearDown(self):
        plot.pyplot.close("all")

    def run_tool(self, name, *arguments):
        return subprocess.run([os.path.join(BIN, name), *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              universal_newlines=True, check=False)

    def simulate(self, *arguments):
        run = self.run_tool("simulate", SCENE, "--duration", "2", *arguments)
        self.assertEqual(run.returncode, 0, run.stderr)

    def refused(self, *arguments):
        run = self.run_tool("plot", *arguments)
        self.assertEqual(run.returncode, 2, run.stdout)
        self.assertNotIn("Traceback", run.stderr)
        return run.stderr
