"""The tool sweep for its tests. The first argument is BIN, the folder that holds the tools; PYTHONPATH finds planar_chain."""
import os
import signal
import subprocess
import sys
import time

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../support"))
from in_folder import InFolder  # noqa: E402

BIN = sys.argv.pop(1) if len(sys.argv) > 1 else ""  # a worker of Dask imports the test again
TOOLS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../src/tools")
SCENE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../config/scenes/double_pendulum.yaml")
MASS, ANGLE = "links/lower/mass", "links/upper/initial/angle"
VARIED = ("--vary", MASS + "=0.5:2:20", "--vary", ANGLE + "=normal(0.3,0.01)", "--seed", "7")
LIMIT = 120  # s


class SweepTool(InFolder):
    def command(self, *arguments, output=("runs.csv",)):
        return [sys.executable, os.path.join(BIN, "sweep"), SCENE, *arguments, "--output", *map(self.path, output)]

    def sweep(self, *arguments, status=0, output=("runs.csv",)):
        run = subprocess.run(self.command(*arguments, output=output), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                             universal_newlines=True, timeout=LIMIT, check=False)
        self.assertEqual(run.returncode, status, run.stderr)
        return run.stdout + run.stderr

    def text(self, name):
        with open(self.path(name), encoding="utf-8") as file:
            return file.read()

    def wait_for_chunks(self, count, process):
        folder, end = self.path("runs.csv.parts"), time.monotonic() + LIMIT
        while sum(name.endswith(".npz") for name in os.listdir(folder) if os.path.isdir(folder)) < count:
            self.assertIsNone(process.poll())
            self.assertLess(time.monotonic(), end)
            time.sleep(0.01)

    def killed(self, *arguments, output=("runs.csv", "runs.npz"), at="sweep.WRITERS['.npz']"):
        """A sweep that is killed, by kill -9, where it would call `at`: before it writes an .npz."""
        script = f"import os, shutil, sweep\n{at} = lambda *_: os.kill(os.getpid(), 9)\nsweep.main()"
        run = subprocess.run([sys.executable, "-c", script, *self.command(*arguments, output=output)[2:]], timeout=LIMIT, check=False,
                             env={**os.environ, "PYTHONPATH": f"{TOOLS}:{os.environ['PYTHONPATH']}"})
        self.assertEqual(run.returncode, -signal.SIGKILL)
