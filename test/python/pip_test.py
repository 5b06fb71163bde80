#!/usr/bin/python3
"""`pip install .` in a virtual environment with NumPy 2 of PyPI: every tool is a command, finds scenes by name, and the module gives
the same numbers as beside the NumPy of this system. A module built by a pybind11 that does not know NumPy 2 is refused there.

    pip_test.py FOLDER PACKAGES PYBIND11 CORE [unittest options]       FOLDER: for the environment and the build;
        PACKAGES: the folder of the module; PYBIND11: the version that built it; CORE: the library of the core
"""
import json
import os
import re
import shutil
import subprocess
import sys
import unittest

FOLDER, PACKAGES, PYBIND11, CORE = (sys.argv.pop(1) for _ in range(4))
ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../..")
BIN = os.path.join(FOLDER, "venv/bin")
PYTHON = os.path.join(BIN, "python")
BUILD = os.path.join(FOLDER, "build")
Q, QD = [0.1, 0.7], [0.3, -0.2]
NUMBERS = f"""
import json
import numpy as np
from planar_chain import Scene, Simulation, equations, simulate, simulate_many
rod = {{"mass": 1.0, "inertia": np.float64(0.1), "com": np.array([0.5, 0]), "pin": [1, 0]}}
scene = Scene({{"chain": ["a", "b"], "links": {{"a": rod, "b": {{**rod, "initial": {{"angle": 0.5}}}}}}}})
simulation = Simulation(scene)
simulation.set_state(np.array({Q}), np.array({QD}))
states = [simulation.q, simulation.qd, simulation.state]
simulation.hold_torques(np.array([1.0, -1.0]))
simulation.advance_to(0.5)
motions = simulation.link_motions()
found = [*states, simulation.state, *(motions[name] for name in motions.dtype.names), scene.pins, simulate(scene, np.array([0, 0.5])),
         equations(scene, np.array({Q}))["M"], *simulation.linearize(),
         simulate_many(scene, np.array([0.5]), initial=np.array([{Q + QD}, {QD + Q}])).states]
print(json.dumps([np.__version__, [np.asarray(one).tolist() for one in found]]))
"""


def run(*command, **more):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True, check=False,
                          timeout=900, **more)


def printed_by(python, packages):
    """What NUMBERS prints with the module in this folder: the status and the text."""
    result = run(python, "-c", NUMBERS, env={"PATH": os.defpath, "PYTHONPATH": packages})
    return result.returncode, result.stdout


def numbers_of(python, packages):
    """The major version of NumPy, and the numbers."""
    status, text = printed_by(python, packages)
    assert status == 0, text
    version, numbers = json.loads(text)
    return int(version.split(".")[0]), numbers


def pip(*arguments, **more):
    return run(PYTHON, "-m", "pip", "-q", "--retries", "1", "install", *arguments, **more)


def setting(pattern):
    """What this pattern finds in pyproject.toml."""
    with open(os.path.join(ROOT, "pyproject.toml"), encoding="utf-8") as file:
        return re.findall(pattern, file.read(), re.MULTILINE)


def install():
    """Builds without optimization, on the core that is built already. A second time pip finds what it built: therefore not in an
    environment of its own. Returns what pip says."""
    shared = CORE.endswith(".so")
    place = os.path.join(BUILD, "devel/lib" if shared else "", os.path.basename(CORE))
    os.makedirs(os.path.dirname(place), exist_ok=True)
    shutil.copy2(CORE, place)
    targets = ";".join(f"planar_chain_{name}/fast" for name in ("python", "tools", "equations", "simulate"))
    return pip("--no-build-isolation", ROOT, env={**os.environ, "CMAKE_GENERATOR": "Unix Makefiles", "CMAKE_BUILD_PARALLEL_LEVEL": "2", "SKBUILD_BUILD_DIR": BUILD,
                          "SKBUILD_BUILD_TARGETS": targets, "SKBUILD_CMAKE_BUILD_TYPE": "None",
                          "SKBUILD_CMAKE_DEFINE": f"BUILD_SHARED_LIBS={shared};PLANAR_CHAIN_WERROR=ON;AVX512_COMPILES=OFF"})


def setUpModule():
    required = re.findall('"(.*?)"', setting(r"^requires = \[(.*)\]")[0])
    for result in (run(sys.executable, "-m", "venv", os.path.dirname(BIN)), pip("pip>=21.3", "numpy==2.*", *required)):
        if result.returncode != 0:
            print(f"{result.stdout}NumPy 2 cannot be had from PyPI: skipped")
            sys.exit(77)
    result = install()
    assert result.returncode == 0, result.stdout


class Pip(unittest.TestCase):
    def test_a_module_of_an_older_pybind11_is_refused(self):
        if tuple(map(int, PYBIND11.split(".")[:2])) >= (2, 12):
            self.skipTest(f"pybind11 {PYBIND11} built the module")
        status, text = printed_by(PYTHON, PACKAGES)
        self.assertEqual(status, 1)
        for words in (f"ImportError: planar_chain was built with pybind11 {'.'.join(PYBIND11.split('.')[:2])}, ",
                      'pip install "numpy<2"', 'pip install "pybind11>=2.12"', "cmake build -Dpybind11_DIR="):
            self.assertIn(words, text)

    def test_the_numbers_are_those_beside_numpy_1(self):
        known = numbers_of(sys.executable, PACKAGES)[1]
        self.assertEqual(known[:3], [Q, QD, Q + QD])
        self.assertEqual(numbers_of(PYTHON, ""), (2, known))

    def ran(self, *command, status=0):
        """Output of a command of the environment alone, in FOLDER."""
        result = run(os.path.join(BIN, command[0]), *command[1:], env={"PATH": os.defpath}, cwd=FOLDER)
        self.assertEqual(result.returncode, status, result.stdout)
        return result.stdout

    def test_every_tool_is_a_command(self):
        package = os.path.dirname(self.ran("python", "-c", "import planar_chain; print(planar_chain.__file__)").strip())
        tools = os.path.join(package, "lib/planar_chain")
        names = sorted(name for name in os.listdir(tools)
                       if os.path.isfile(os.path.join(tools, name)) and os.access(os.path.join(tools, name), os.X_OK))
        self.assertEqual(names, setting(r'^(\w+) = "planar_chain.console:start"$'))
        for name in names:
            self.assertIn("usage", self.ran(name, "--help").lower())

    def test_scenes_are_found_by_name(self):
        self.ran("simulate", "double_pendulum", "--duration", "0.1", "--csv", "double.csv")
        self.ran("plot", "double.csv", "--scene", "double_pendulum", "--movie", "double.gif")
        self.assertIn("Hz", self.ran("modes", "double_pendulum"))
        self.assertIn("void", self.ran("formulas", "pendulum", "--format", "c"))
        self.assertEqual(self.ran("python", "-c", "from planar_chain import Scene; print(Scene.from_file('rope').links[0])"), "rope_1\n")

    def test_exit_statuses_are_those_of_the_tools(self):
        for command in (("simulate", "rop", "--duration", "1"), ("modes", "rop")):
            self.assertIn("did you mean rope?", self.ran(*command, status=2))

    def test_the_version_is_that_of_the_packages(self):
        version = self.ran("python", "-c", "from importlib.metadata import version; print(version('planar_chain'))").strip()
        for package in ("package.xml", "ros_control/package.xml"):
            with open(os.path.join(ROOT, package), encoding="utf-8") as file:
                self.assertIn(f"<version>{version}</version>", file.read())


if __name__ == "__main__":
    unittest.main()
