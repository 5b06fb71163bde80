#!/usr/bin/python3
"""The Python module beside NumPy 2 of PyPI, in a virtual environment: refused where a pybind11 built it that does not know
NumPy 2; built with PyPI's pybind11, the same numbers as beside the NumPy of this system.

    numpy2_test.py FOLDER PACKAGES PYBIND11 CORE [unittest options]       FOLDER: for the environment and a second build;
        PACKAGES: the folder of the module; PYBIND11: the version that built it; CORE: the library of the core
"""
import json
import os
import subprocess
import sys
import unittest

FOLDER, PACKAGES, PYBIND11, CORE = (sys.argv.pop(1) for _ in range(4))
ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../..")
PYTHON = os.path.join(FOLDER, "venv/bin/python")
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


def done(*command):
    result = run(*command)
    assert result.returncode == 0, f"{command}\n{result.stdout}"


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


def setUpModule():
    for command in ([sys.executable, "-m", "venv", os.path.dirname(os.path.dirname(PYTHON))],
                    [PYTHON, "-m", "pip", "-q", "--retries", "1", "install", "numpy==2.*", "pybind11==3.*"]):
        result = run(*command)
        if result.returncode != 0:
            print(f"{result.stdout}NumPy 2 cannot be had from PyPI: skipped")
            sys.exit(77)


class NumPy2(unittest.TestCase):
    def test_a_module_of_an_older_pybind11_is_refused(self):
        if tuple(map(int, PYBIND11.split(".")[:2])) >= (2, 12):
            self.skipTest(f"pybind11 {PYBIND11} built the module")
        status, text = printed_by(PYTHON, PACKAGES)
        self.assertEqual(status, 1)
        for words in (f"ImportError: planar_chain was built with pybind11 {'.'.join(PYBIND11.split('.')[:2])}, ",
                      'pip install "numpy<2"', 'pip install "pybind11>=2.12"', "cmake build -Dpybind11_DIR="):
            self.assertIn(words, text)

    def test_a_module_of_a_newer_pybind11_gives_the_numbers_of_numpy_1(self):
        known = numbers_of(sys.executable, PACKAGES)[1]
        self.assertEqual(known[:3], [Q, QD, Q + QD])
        packages = self.built()
        self.assertEqual(numbers_of(PYTHON, packages), (2, known))
        self.assertEqual(numbers_of(sys.executable, packages)[1], known)

    def built(self):
        """Builds the module alone, without optimization, on the core that is built already. Returns its folder."""
        shared = CORE.endswith(".so")
        place = os.path.join(BUILD, "devel/lib" if shared else "", os.path.basename(CORE))
        os.makedirs(os.path.dirname(place), exist_ok=True)
        if not os.path.lexists(place):
            os.symlink(CORE, place)
        pybind11 = run(PYTHON, "-m", "pybind11", "--cmakedir").stdout.strip()
        done("cmake", "-S", ROOT, "-B", BUILD, "-G", "Unix Makefiles", "-DPLANAR_CHAIN_ROS=OFF", f"-DBUILD_SHARED_LIBS={shared}",
             f"-DPYTHON_EXECUTABLE={sys.executable}", f"-Dpybind11_DIR={pybind11}", "-DCMAKE_BUILD_TYPE=None", "-DPLANAR_CHAIN_WERROR=ON",
             "-DAVX512_COMPILES=OFF", "-DCMAKE_DISABLE_FIND_PACKAGE_GTest=ON")
        done("make", "-C", BUILD, "-j2", "planar_chain_python/fast")
        return os.path.join(BUILD, "devel/lib/python3/dist-packages")


if __name__ == "__main__":
    unittest.main()
