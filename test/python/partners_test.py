#!/usr/bin/python3
"""The Python module with its partners of PyPI: formulas under jax and casadi, environments under Gymnasium, state_space() with
python-control, a notebook. They are in a virtual environment that is made once; where that cannot be, the test is skipped.

    partners_test.py FOLDER MODULES [unittest options]       FOLDER: of the environment; MODULES: the folder of planar_chain
"""
import functools
import os
import re
import shutil
import subprocess
import sys
import unittest
import urllib.request

FOLDER, MODULES = map(os.path.abspath, sys.argv[1:3])
PYTHON = os.path.join(FOLDER, "bin/python")
PARTNERS = ("casadi==3.8.2", "control==0.10.2", "gymnasium==1.4.0", "ipykernel==7.4.0", "jax==0.7.1", "matplotlib==3.11.2",
            "nbclient==0.11.0", "nbconvert==7.17.2", "numpy==1.26.4", "sympy==1.14.0")  # NumPy 1: the module may be of pybind11 2.10


def install():
    made, wanted = os.path.join(FOLDER, "made_of"), "\n".join([sys.version, *PARTNERS])
    if os.path.exists(made):
        with open(made, encoding="utf-8") as file:
            if file.read() == wanted:
                return
    for command in ([sys.executable, "-m", "venv", "--clear", FOLDER], [PYTHON, "-m", "pip", "-q", "--retries", "1", "install", *PARTNERS]):
        run = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True, check=False)
        if run.returncode != 0:
            last_line = run.stdout.strip().rpartition("\n")[2]
            print(f"The partners cannot be had from PyPI ({last_line}): skipped")
            sys.exit(77)
    with open(made, "w", encoding="utf-8") as file:
        file.write(wanted)


if os.path.realpath(sys.prefix) != os.path.realpath(FOLDER):
    install()
    os.execve(PYTHON, [PYTHON, *sys.argv], {"HOME": FOLDER, "PATH": os.environ["PATH"], "PYTHONPATH": MODULES})  # no settings of a user

import control  # noqa: E402
import gymnasium  # noqa: E402
import nbclient  # noqa: E402
import nbconvert  # noqa: E402
import nbformat  # noqa: E402
import numpy as np  # noqa: E402
from gymnasium.utils.env_checker import check_env  # noqa: E402

del sys.argv[1:3]
from formulas_scenes import State, random_scene, shipped  # noqa: E402
from planar_chain import Scene, Simulation, linearize, state_space  # noqa: E402
from planar_chain.symbolic.code_python import python_code  # noqa: E402
from python_environment_test import Rest, Spin  # noqa: E402
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../support"))
from browser import browser  # noqa: E402
from in_folder import InFolder  # noqa: E402

PAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../src/python/README.md")


class Environments(unittest.TestCase):
    def test_gymnasium_accepts_one(self):
        gymnasium.register("Spin-v0", lambda **more: Spin({"rod_joint": 1.0}, **more))
        check_env(gymnasium.make("Spin-v0", render_mode="rgb_array").unwrapped)

    def test_an_action_beyond_is_clipped_by_its_wrapper(self):
        clipped, plain = gymnasium.wrappers.ClipAction(Spin({"rod_joint": 1.0})), Spin({"rod_joint": 1.0})
        for env in (clipped, plain):
            env.reset()
        self.assertEqual(clipped.step(np.array([3.0]))[0].tolist(), plain.step([1])[0].tolist())

    def test_several_at_once_move_as_each_alone(self):
        alone, actions = [Rest() for _ in range(2)], np.random.default_rng(1).uniform(-1, 1, (20, 2, 1))
        expected = [[env.reset(seed=seed)[0] for seed, env in enumerate(alone)]]
        expected += [[env.step(action)[0] for env, action in zip(alone, both)] for both in actions]
        for vector in (gymnasium.vector.SyncVectorEnv, gymnasium.vector.AsyncVectorEnv):
            envs = vector([Rest, Rest])
            self.addCleanup(envs.close)
            found = [envs.reset(seed=[0, 1])[0]]
            for both in actions:
                observations, _, _, truncated, _ = envs.step(both)
                found.append(observations.copy())
            np.testing.assert_array_equal(found, expected)
            self.assertTrue(truncated.all())
            first = envs.step(actions[0])[0]  # of the next episode
            np.testing.assert_array_equal(first[:, 4:], 0)
            self.assertNotEqual(first[0, 0], expected[0][0][0])


class Formulas(unittest.TestCase):
    """jax is imported here: processes that fork should not have its threads."""

    @staticmethod
    def functions(state):
        module = {}
        exec(python_code(state.formulas, "it", state.name, True), module)  # pylint: disable=exec-used
        return lambda xp, t, q, qd, tau: {output: module[output](xp, t, q, qd, **({"tau": tau} if output in "AB" else {}))
                                          for output in state.outputs}

    def test_casadi(self):
        import casadi
        states = [State(name, scene, k, k % 2 == 0) for k, (name, scene) in enumerate(shipped().items())]
        for state in states + [State(f"random {seed}", random_scene(seed), seed, seed % 2 == 0) for seed in range(10)]:
            n = len(state.q)
            for kind in (casadi.SX, casadi.MX):
                given = [kind.sym("t"), *(kind.sym(name, n) for name in ("q", "qd", "tau"))]
                found = [casadi.vertcat(*(casadi.horzcat(*np.atleast_1d(np.array(row, dtype=object))) for row in value))
                         for value in self.functions(state)(casadi, *given).values()]
                values = casadi.Function("it", given, found)(state.t, state.q, state.qd, state.tau)
                state.check(self, dict(zip(state.outputs, values)), f"casadi.{kind.__name__}")

    def test_jax(self):
        import jax
        jax.config.update("jax_enable_x64", True)
        scenes = shipped()
        for k, name in enumerate(("bungee", "cart_pole", "double_pendulum", "finger", "robot_arm", "slider_crank", "telescope")):
            state = State(name, scenes[name], k, k % 2 == 0)
            functions, n = functools.partial(self.functions(state), jax.numpy), len(state.q)
            state.check(self, jax.jit(functions)(state.t, state.q, state.qd, state.tau), "jax.jit")

            def rates(x, functions=functions, t=state.t, n=n):
                return jax.numpy.array(functions(t, x[:n], x[n:], [0.0] * n)["qdd"])
            A, _ = linearize(state.scene, state.q, state.qd, t=state.t, tau=np.zeros(n))
            found = jax.jit(jax.jacfwd(rates))(np.concatenate([state.q, state.qd]))
            self.assertLessEqual(abs(found - A[n:]).max() / abs(A).max(), 1e-12, name)


class Systems(unittest.TestCase):
    inputs, outputs = ["cart_joint"], ["tip/x", "pole_joint/position"]

    def system(self, q):
        return control.ss(*state_space(Scene.from_file("cart_pole"), self.inputs, self.outputs, q, np.zeros(2)), inputs=self.inputs,
                          outputs=self.outputs)

    def test_its_response_is_that_of_the_plant(self):
        q, times, force = np.array([0.0, -np.pi / 2]), 0.02 * np.arange(101), 1e-5
        found = control.forced_response(self.system(q), times, np.full(101, force)).outputs
        plant, expected = Simulation(Scene.from_file("cart_pole")), []
        plant.set_state(q, [0, 0])
        plant.hold_torque("cart_joint", force)
        for t in times:
            plant.advance_to(t)
            expected.append([plant.motion("tip").position[0], plant.q[1] - q[1]])
        np.testing.assert_allclose(found, np.transpose(expected), atol=1e-4 * abs(found).max())  # the plant is linear to 1e-5 of it

    def test_its_lqr_balances_the_plant(self):
        q = np.array([0.0, np.pi / 2])
        gain, *_ = control.lqr(self.system(q), np.eye(4), np.eye(1))
        for factor, low, high in ((1, 0, 1e-3), (0, 0.5, np.inf)):
            plant = Simulation(Scene.from_file("cart_pole"))
            plant.set_state(q + [0.1, 0.1], [0, 0])
            for k in range(1, 1001):
                plant.hold_torque("cart_joint", -factor * (gain @ (plant.state - [*q, 0, 0])).item())
                plant.advance_to(0.01 * k)
            self.assertTrue(low <= abs(plant.q - q).max() < high, plant.q)


class Notebook(InFolder):
    def test_the_lines_of_the_page(self):
        with open(PAGE, encoding="utf-8") as file:
            blocks = re.findall(r"^```python\n(.*?)^```", file.read(), re.MULTILINE | re.DOTALL)
        cells = [block for words in ("import numpy", "\npendulum = ", "import animate", "import fit") for block in blocks if words in block]
        self.assertEqual(len(cells), 4)
        notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in [*cells, "result", "movie"]])
        nbclient.NotebookClient(notebook, kernel_name="python3", resources={"metadata": {"path": self.folder}}).execute()
        fitted, shown = (cell.outputs[-1].data for cell in notebook.cells[-2:])
        self.assertRegex(notebook.cells[3].outputs[-1].text, r"links/lower/mass +(0\.999|1\.000)")
        self.assertIn("links/lower/mass", fitted["text/plain"])
        self.assertTrue(shown["text/html"].startswith("<iframe srcdoc="))
        if shutil.which("chromedriver") is None:
            self.skipTest("Debian's chromium and chromium-driver are not installed")
        with open(self.path("notebook.html"), "w", encoding="utf-8") as file:
            page = nbconvert.HTMLExporter().from_notebook_node(notebook)[0]
            file.write(re.sub(r'<script src="https?:[^>]*></script>', "", page))  # Chromium would wait for them
        with browser() as call:
            call("POST", "/url", url="file://" + urllib.request.pathname2url(self.path("notebook.html")))
            call("POST", "/execute/sync", script="document.querySelector('iframe').scrollIntoView()", args=[])
            call("POST", "/frame", id=0)
            seen = set()
            while len(seen) < 3:  # it plays
                seen.add(call("POST", "/execute/sync", script="return shown", args=[]))


if __name__ == "__main__":
    unittest.main()
