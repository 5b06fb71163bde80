#!/usr/bin/python3
"""formulas: C, MATLAB's code, Python and SymPy give M, f, q̈, A and B of the program, for the scenes that ship and random ones.
Environment variables: FORMULAS_RANDOM, the number of random ones; FORMULAS_PAGES, if set, has the pages of all compiled.

    formulas_test.py BIN [unittest options]        BIN: the folder that holds the tools; PYTHONPATH finds planar_chain
"""
import ctypes
import math
import os
import re
import shutil
import subprocess
import sys
import unittest

try:
    import numpy as np
    import sympy as sp
    from matplotlib import pyplot
except ImportError as missing:
    print(f"{missing}: skipped")
    sys.exit(77)

from formulas_scenes import AGREE, State, random_scene, shipped, states
from planar_chain import NoFormula, Scene, formulas
from planar_chain._core import _operating_point
from planar_chain.symbolic.code import program_of
from planar_chain.symbolic.code_c import c_code
from planar_chain.symbolic.code_matlab import matlab_code
from planar_chain.symbolic.code_python import python_code
from planar_chain.symbolic.document import Document
from planar_chain.symbolic.linear import linear
from planar_chain.symbolic.chain import read
from planar_chain.symbolic.sketch import FEW, draw

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../support"))
from in_folder import InFolder  # noqa: E402

BIN = ""
PAGES = {"double_pendulum", "cart_pole", "driven", "thrown", "four_bar"}  # compiled, but for FORMULAS_PAGES


# ---- The roads -------------------------------------------------------------------------------------


def near(output, tau):
    """The torques, for functions that take them."""
    return {"tau": tau} if output in ("A", "B") else {}


class Values(InFolder):
    def test_c(self):
        for k, state in enumerate(states()):
            source, library = self.path(f"{k}.c"), self.path(f"{k}.so")
            text = c_code(state.formulas, "it", state.name, True)
            with open(source, "w", encoding="utf-8") as file:
                file.write(text)
            subprocess.run(["gcc", "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror", "-O0", "-fPIC",
                            "-shared", source, "-o", library, "-lm"], check=True)
            state.check(self, self.values_of(ctypes.CDLL(library), state), "C")
            self.assert_lean(text, library, state)

    def test_sines_in_c(self):
        """Sines of near and far angles; compilers that may reorder sums must not break the rounding."""
        with open(self.path("it.c"), "w", encoding="utf-8") as file:
            file.write(c_code(formulas(Scene.from_file("double_pendulum")).with_numbers(), "it", "rods", False))
        rng = np.random.default_rng(1)
        angles = [*rng.normal(size=1000), *(10 ** rng.uniform(0, 9, 1000)), *(np.pi / 2 * np.arange(-100, 100)), 1e6, -1e6, 0.0]
        for option in ("-O0", "-O3", "-Ofast"):
            library = self.path(f"it{option}.so")
            subprocess.run(["gcc", "-std=c99", option, "-fPIC", "-shared", self.path("it.c"), "-o", library, "-lm"], check=True)
            call, still, f = ctypes.CDLL(library).it_f, (ctypes.c_double * 2)(), (ctypes.c_double * 2)()
            for angle in angles:
                call(ctypes.c_double(0), (ctypes.c_double * 2)(0, angle), still, f)
                self.assertLessEqual(abs(f[1] / -4.905 - math.cos(angle)), 4e-16, f"{angle} {option}")

    @staticmethod
    def values_of(library, state):
        values = {}
        address = np.ctypeslib.ndpointer(dtype=float, flags="C_CONTIGUOUS")
        for output in state.outputs:
            values[output] = np.full(state.expected[output].shape, np.nan)
            call, first = getattr(library, "it_" + output), []
            call.restype = None
            if not state.numbers:
                first = [ctypes.addressof(ctypes.c_char.in_dll(library, "it_scene"))]
            states = [state.q, state.qd] + [state.tau] * (output in ("A", "B"))
            call.argtypes = [ctypes.c_void_p] * len(first) + [ctypes.c_double] + [address] * (len(states) + 1)
            call(*first, state.t, *states, values[output])
        return values

    def assert_lean(self, text, library, state):
        """Each angle's sine and cosine once a function; nothing is called but functions of mathematics."""
        n = len(state.q)
        for function in text.split("\nvoid ")[1:]:
            of_angles = re.findall(r"const double (?:cos|sin)_\d+ = (cos|sin)\(", function)
            self.assertLessEqual(max(of_angles.count("cos"), of_angles.count("sin")), n, state.name)
            steps = [line.partition(" = ")[2] for line in function.splitlines() if "cos(" in line or "sin(" in line]
            self.assertEqual(len(steps), len(set(steps)), state.name)
        called = subprocess.run(["nm", "-D", "--undefined-only", library], stdout=subprocess.PIPE, universal_newlines=True, check=True)
        names = {line.split()[-1].partition("@")[0] for line in called.stdout.splitlines() if " U " in line}
        self.assertLessEqual(names, {"cos", "sin", "sincos", "sqrt"}, state.name)

    @unittest.skipUnless(shutil.which("octave"), "octave not found: MATLAB's code is not run")
    def test_matlab(self):
        lines = []
        for k, state in enumerate(states()):
            name = f"it_{k}"
            with open(self.path(name + ".m"), "w", encoding="utf-8") as file:
                file.write(matlab_code(state.formulas, name, state.name, True))
            q, qd, tau = ("[" + "; ".join(map(repr, x.tolist())) + "]" for x in (state.q, state.qd, state.tau))
            letters = "" if state.numbers else f"{name}(), "
            lines += [f"[{', '.join(state.outputs)}] = {name}({state.t!r}, {q}, {qd}, {letters}{tau});"]
            lines += [f"printf('%.17g ', reshape({x}', 1, [])); printf('\\n');" for x in state.outputs]
        with open(self.path("all_of_them.m"), "w", encoding="utf-8") as file:
            file.write("\n".join(lines) + "\n")
        run = subprocess.run(["octave", "--norc", "--quiet", "--no-window-system", "all_of_them.m"], cwd=self.folder, check=True,
                             stdout=subprocess.PIPE, universal_newlines=True)
        numbers = [[float(word) for word in line.split()] for line in run.stdout.splitlines()]
        for state in states():
            state.check(self, {output: numbers.pop(0) for output in state.outputs}, "Octave")

    def test_what_the_random_chains_have(self):
        scenes = [random_scene(seed).to_dict() for seed in range(50)]
        joints = [link["joint"] for scene in scenes for link in scene["links"].values()]
        prismatic = [[i for i, link in enumerate(scene["links"].values()) if link["joint"].get("type") == "prismatic"] for scene in scenes]
        floating = [any(link["joint"].get("type") == "floating" for link in scene["links"].values()) for scene in scenes]
        loads = [load for scene in scenes for load in scene.get("loads", {}).values()]
        counts = {key: sum(key in joint for joint in joints)
                  for key in ("rotor_inertia", "drive", "damping", "stiffness", "friction", "drag", "upper", "motor")}
        counts.update({key: sum(key in load for load in loads) for key in ("frequency", "times", "start", "torque", "force", "moment")})
        inner = [scene["links"][f"link_{i}"]["joint"] for scene, places in zip(scenes, prismatic) for i in places if i != places.index(i)]
        counts.update({f"{key} of a prismatic joint within": sum(key in joint for joint in inner)
                       for key in ("rotor_inertia", "drive", "stiffness", "friction", "drag", "upper")})
        springs = [spring for scene in scenes for spring in scene.get("springs", {}).values()]
        counts.update({"air drag": sum("drag" in link for scene in scenes for link in scene["links"].values()), "springs": len(springs),
                       "slack": sum(spring.get("slack", False) for spring in springs), "linear": sum("rest_length" not in spring for spring in springs)})
        counts.update({"springs and " + key: sum("springs" in scene and key in scene for scene in scenes) for key in ("base", "tip")})
        counts.update({"carts": sum(places[:1] == [0] for places in prismatic), "floating": sum(floating)})
        counts.update({key: sum(key in scene for scene in scenes) for key in ("base", "tip", "gravity")})
        for key in ("base", "tip"):
            counts[f"cart and {key}"] = sum(key in scene and (places[:1] == [0] or f) for scene, places, f in zip(scenes, prismatic, floating))
            counts[f"prismatic joint within and {key}"] = sum(key in scene and places != [] and places[-1] >= len(places)
                                                               for scene, places in zip(scenes, prismatic))
        self.assertGreaterEqual(min(counts.values()), 2, counts)

    def test_python(self):
        for state in states():
            module = {}
            exec(python_code(state.formulas, "it", state.name, True), module)  # pylint: disable=exec-used
            for xp in (np, math):
                values = {output: module[output](xp, state.t, state.q, state.qd, **near(output, state.tau)) for output in state.outputs}
                state.check(self, values, f"Python with {xp.__name__}")
            two = np.column_stack([state.q, state.q]), np.column_stack([state.qd, state.qd])
            both = module["qdd"](np, np.array([state.t, state.t]), *two)  # two states at once
            size = max(abs(state.expected["qdd"]).max(), state.cancels.get("qdd", 0))
            for got, expected in zip(both, state.expected["qdd"]):
                self.assertLessEqual(np.max(abs(got - expected)), AGREE * size)

    def test_python_with_symbols_of_sympy(self):
        """Limits, friction, drag and slack springs have cases that no symbol decides."""
        rod = {"mass": 1.0, "inertia": 0.1, "com": [0.5, 0.0], "pin": [1.0, 0.0], "drag": 0.3,
               "joint": {"lower": -0.5, "upper": 0.5, "friction": 0.2, "drag": 0.1}}
        spring = {"link": "a", "point": [1.0, 0.0], "ground": [0.0, 1.0], "stiffness": 20.0, "rest_length": 1.0, "slack": True}
        state = State("rod", Scene({"chain": ["a"], "links": {"a": rod}, "springs": {"rope": spring}}), 1, False)
        module, symbols = {}, sp.symbols("q qd tau", real=True)
        exec(python_code(state.formulas, "it", state.name, True), module)  # pylint: disable=exec-used
        q, qd, tau = ([symbol] for symbol in symbols)
        of = {output: module[output](sp, state.t, q, qd, **near(output, tau)) for output in state.outputs}
        at = dict(zip(symbols, (state.q[0], state.qd[0], state.tau[0])))
        state.check(self, {output: sp.Matrix(value).subs(at).tolist() for output, value in of.items()}, "Python with symbols")

    def test_sympy(self):
        for state in states():
            of = state.formulas
            given = dict(zip([of.t, *of.q, *of.qd, *program_of(of, True).added], [state.t, *state.q, *state.qd, *state.tau]))
            given.update({symbol: letter.value for symbol, letter in of.letters.items()})
            at = {symbol: sp.Float(float(value)) for symbol, value in given.items()}
            program = program_of(of, True)
            for symbol, expression in program.steps:
                at[symbol] = expression.xreplace(at).evalf()
            values = {name: matrix.xreplace(at).tolist() for name, matrix in program.outputs.items()}
            state.check(self, values, "SymPy's steps")
            self.check_near_a_state(state, at)
            if len(state.q) <= 4:
                self.check_matrices(state, at)

    def check_near_a_state(self, state, at):
        """A and B by M δq̈ = K δq + D δq̇ + δτ, as the document prints it."""
        of, n, T = linear(state.formulas), len(state.q), state.sums
        (A, B), _, qdd = _operating_point(state.scene, state.q, state.qd, state.tau, "acts", state.t, False)
        np.testing.assert_array_equal(A, state.expected["A"])
        np.testing.assert_array_equal(B, state.expected["B"])
        phi = []
        if state.formulas.chain.rows:
            left = state.expected["M"] @ qdd - state.expected["f"] - state.tau
            free = [i for i in range(n) if i not in state.formulas.driven]
            phi = np.linalg.lstsq(state.expected["J_c"].T[free], left[free], rcond=None)[0]
        x, xd, beta = (each @ T for each in (state.q, state.qd, qdd))
        base = [float(sp.sympify(number).xreplace(at)) for number in (state.formulas.chain.phi, state.formulas.chain.phid)]
        at = {**at, **{symbol: sp.Float(float(value)) for symbols, values in (
            (state.formulas.theta, x + base[0]), (state.formulas.omega, xd + base[1])) for i, (symbol, value) in enumerate(zip(symbols, values))
                       if i in state.formulas.chain.coordinates.revolute}}
        at.update({symbol: sp.Float(float(value)) for symbols, values in ((of.beta, beta), (state.formulas.phi, phi))
                   for symbol, value in zip(symbols, values)})

        def number(matrix):
            return np.array(matrix.xreplace(at).evalf().tolist(), dtype=float)

        free = [i for i in range(n) if i not in state.formulas.driven]
        K_theta, D_theta = number(of.K_theta), number(of.D_theta)
        for force, gradients in zip(state.formulas.point_forces, of.points):
            J, W, by_place, by_velocity = map(number, (*gradients, force.by_place, force.by_velocity))
            K_theta += J.T @ (by_place @ J + by_velocity @ W)
            D_theta += J.T @ by_velocity @ J
        change = np.hstack([T @ K_theta @ T.T + number(of.K_tau), T @ D_theta @ T.T + number(of.D_tau), np.eye(n)])
        lower, J_c = np.zeros((n, 3 * n)), state.expected["J_c"][:, free] if state.formulas.chain.rows else np.zeros((0, len(free)))
        of_tip = np.hstack([number(of.K_c) @ T.T, number(of.D_c) @ T.T, np.zeros((len(J_c), n))]) if len(J_c) else np.zeros((0, 3 * n))
        bordered = np.block([[state.expected["M"][np.ix_(free, free)], J_c.T], [J_c, np.zeros((len(J_c), len(J_c)))]])
        lower[free] = np.linalg.solve(bordered, np.vstack([change[free], of_tip]))[:len(free)]
        lower[:, [2 * n + j for j in state.formulas.driven]] = 0
        for got, output in ((lower[:, :2 * n], "A"), (lower[:, 2 * n:], "B")):
            expected = state.expected[output][n:]
            size = max(abs(state.expected[output]).max(), state.cancels.get(output, 0), np.finfo(float).tiny)
            self.assertLessEqual(abs(got - expected).max() / size, 10 * AGREE, f"{state.name}: by K and D")  # numpy's solve rounds too

    def check_matrices(self, state, at):
        """The closed form, and up to three links every matrix of the notes. SymPy takes long for more."""
        of, n = state.formulas, len(state.q)
        at.update({symbol: value.xreplace(of.given).xreplace(at).evalf() for symbol, value in of.absolute.items()})
        at.update({symbol: value.xreplace(at).evalf() for symbol, value in of.given.items()})
        at.update({sp.Symbol(f"tau_{j + 1}"): sp.Float(state.expected["tau"][j]) for j in of.driven})

        def number(matrix):
            return np.array(matrix.xreplace(at).evalf().tolist(), dtype=float)

        pairs = [(of.closed.M, "M"), (of.closed.f, "f")] + ([(of.closed.J_c, "J_c"), (of.closed.c, "c")] if of.chain.rows else [])
        if n <= 3:
            pairs += [(getattr(of, letter), letter) for letter in ("T", "V_pd", "W_pd", "A_1", "A_2", "A_3", "F", "M_ext", "tau", "f_ext",
                                                                  "M", "f")]
            pairs += [(getattr(of, letter), letter) for letter in (("J_c", "c") if of.chain.rows else ())]
        T, largest = state.sums, {"f": abs(state.expected["f"]).max() + abs(state.expected["tau"]).max()}
        pairs += [(sp.Matrix(T) * of.closed.M_theta * sp.Matrix(T.T), "M"), (sp.Matrix(T) * of.closed.f_theta, "f")]
        for matrix, letter in pairs:
            expected = state.expected[letter]
            size = max(largest.get(letter, abs(expected).max()), state.cancels.get("c", 0) if letter == "c" else 0, 1e-300)
            self.assertLessEqual(abs(number(matrix).reshape(expected.shape) - expected).max() / size, AGREE, f"{state.name}: {letter}")


# ---- How they are written ----------------------------------------------------------------------------


class Letters(unittest.TestCase):
    def test_the_double_pendulum_is_that_of_the_textbook(self):
        """M = [[α + 2β c_2, δ + β c_2], [δ + β c_2, δ]], C = [[−β s_2 q̇_2, −β s_2 (q̇_1 + q̇_2)], [β s_2 q̇_1, 0]]: R. M. Murray, Z. Li,
        S. S. Sastry, A Mathematical Introduction to Robotic Manipulation (1994), ch. 4, two-link planar robot. α = M_11 at q_2 = π/2,
        β and δ are defined alike in Murray's Mathematica file of this example (8 July 1991)."""
        of = formulas(Scene.from_file("double_pendulum"))
        letter = {symbol.name: symbol for symbol in of.letters}
        m_1, m_2, I_1, I_2, r_1, r_2, l_1, g = (letter[name] for name in "m_1 m_2 I_1 I_2 r_1 r_2 p_1 g".split())
        alpha, beta, delta = I_1 + I_2 + m_1 * r_1**2 + m_2 * (l_1**2 + r_2**2), m_2 * l_1 * r_2, I_2 + m_2 * r_2**2
        (q_1, q_2), (w_1, w_2) = of.q, of.qd
        c, s = sp.cos(q_2), sp.sin(q_2)
        M = sp.Matrix([[alpha + 2 * beta * c, delta + beta * c], [delta + beta * c, delta]])
        C = beta * s * sp.Matrix([[-w_2, -w_1 - w_2], [w_1, 0]])
        V = g * (m_1 * r_1 * sp.sin(q_1) + m_2 * (l_1 * sp.sin(q_1) + r_2 * sp.sin(q_1 + q_2)))
        f = -C * of.qd - sp.Matrix([sp.diff(V, q) for q in of.q])
        self.assertEqual((of.in_q(of.closed.M) - M).expand(), sp.zeros(2, 2))
        self.assertEqual((of.in_q(of.closed.f) - f).expand(), sp.zeros(2, 1))
        self.assertEqual(sp.simplify(of.in_q(of.M) - M), sp.zeros(2, 2))
        self.assertEqual(sp.simplify(of.in_q(of.f) - f), sp.zeros(2, 1))

    def test_the_double_pendulum_is_that_of_the_platform_of_dfki(self):
        """M, C and G of the page "The Double Pendulum System" of dfki-ric-underactuated-lab/double_pendulum, docs/text/dynamics.rst,
        without its motors; after F. Wiebe et al., Open-Source Dual-Purpose Acrobot and Pendubot Platform. Its inertias are about the
        joints, its q_1 is 0 where the pendulum hangs."""
        of = formulas(Scene.from_file("double_pendulum"))
        letter = {symbol.name: symbol for symbol in of.letters}
        m_1, m_2, r_1, r_2, l_1, g = (letter[name] for name in "m_1 m_2 r_1 r_2 p_1 g".split())
        I_1, I_2 = letter["I_1"] + m_1 * r_1**2, letter["I_2"] + m_2 * r_2**2
        (q_1, q_2), (w_1, w_2) = of.q, of.qd
        c_2, s_2, s_1, s_12 = sp.cos(q_2), sp.sin(q_2), sp.sin(q_1 + sp.pi / 2), sp.sin(q_1 + q_2 + sp.pi / 2)
        M = sp.Matrix([[I_1 + I_2 + l_1**2 * m_2 + 2 * l_1 * m_2 * r_2 * c_2, I_2 + l_1 * m_2 * r_2 * c_2],
                       [I_2 + l_1 * m_2 * r_2 * c_2, I_2]])
        C = l_1 * m_2 * r_2 * s_2 * sp.Matrix([[-2 * w_2, -w_2], [w_1, 0]])
        G = sp.Matrix([-g * m_1 * r_1 * s_1 - g * m_2 * (l_1 * s_1 + r_2 * s_12), -g * m_2 * r_2 * s_12])
        self.assertEqual((of.in_q(of.closed.M) - M).expand(), sp.zeros(2, 2))
        self.assertEqual((of.in_q(of.closed.f) - (G - C * of.qd)).expand(), sp.zeros(2, 1))

    def test_the_telescope_is_the_rp_manipulator_of_the_textbook(self):
        """M, V and G of the RP manipulator of J. J. Craig, Introduction to Robotics: Mechanics and Control, ch. 6: q_2 is the distance of
        the second centre of mass from the first joint."""
        link = {"mass": 1.0, "inertia": 0.1, "com": [0.4, 0.0], "pin": [0.0, 0.0]}
        rod = {**link, "com": [0.0, 0.0], "joint": {"type": "prismatic", "axis": [1, 0], "rotor_inertia": 0.5}}
        of = formulas(Scene({"chain": ["arm", "rod"], "links": {"arm": link, "rod": rod}}))
        letter = {symbol.name: symbol for symbol in of.letters}
        m_1, m_2, I_1, I_2, J_2, r_1, g = (letter[name] for name in "m_1 m_2 I_1 I_2 J_2 r_1 g".split())
        (q_1, d_2), (w_1, v_2) = of.q, of.qd
        M = sp.diag(I_1 + m_1 * r_1**2 + I_2 + m_2 * d_2**2, m_2 + J_2)
        V = sp.Matrix([2 * m_2 * d_2 * w_1 * v_2, -m_2 * d_2 * w_1**2])
        G = sp.Matrix([(m_1 * r_1 + m_2 * d_2) * g * sp.cos(q_1), m_2 * g * sp.sin(q_1)])
        for form in (of.closed, of):
            self.assertEqual(sp.simplify(of.in_q(form.M) - M), sp.zeros(2, 2))
            self.assertEqual(sp.simplify(of.in_q(form.f) + V + G), sp.zeros(2, 1))

    def test_a_page_of_a_prismatic_joint_beside_one_that_is_held(self):
        arm, rod = ({"mass": 1.0, "inertia": 0.1, "com": [0.4, 0.0], "pin": [0.7, 0.0], "joint": joint}
                    for joint in ({"drive": "hold"}, {"type": "prismatic", "axis": [0.6, 0.8]}))
        text = Document(formulas(Scene({"chain": ["arm", "rod", "tool"], "links": {"arm": arm, "rod": rod, "tool": {**arm, "joint": {}}}})),
                        "it", None, True).text()
        for words in (r"& displacement of the prismatic joint 2 (rod\_joint) along its axis", r"$d_{2x}$ & axis of the prismatic joint 2",
                      r"$\theta_i = \sum q_j$ of the revolute joints $j \le i$ is the absolute angle", r"\theta_{3} &= q_{1} + q_{3}",
                      r"2 \omega_i \dot{q}_i\, \hat{k} \times d_i$ is added", r"\ddot{q}_{2}", r"$q_i$ takes the place of $\theta_i$"):
            self.assertIn(words, text)

    def test_the_closed_form_has_no_products_or_sums_of_sines(self):
        for scene in shipped().values():
            of = formulas(scene)
            angles = [*of.theta, *(a - b for a in of.theta for b in of.theta if a != b)]
            for entry in [*of.closed.M_theta, *of.closed.loads_theta]:
                for term in sp.Add.make_args(entry):
                    trig = term.atoms(sp.sin, sp.cos)
                    self.assertTrue(all(function.args[0] in angles for function in trig), term)
                    for product in term.atoms(sp.Mul) | {term}:
                        factors = [x for x in product.args if isinstance(x, (sp.sin, sp.cos))]
                        self.assertLessEqual(len(factors), 1, term)

    def test_a_path_is_no_scene(self):
        with self.assertRaisesRegex(TypeError, "scene: expected a planar_chain.Scene .*, got 'pendulum'"):
            formulas("pendulum")

    def test_what_a_scene_does_not_have_is_not_in_its_formulas(self):
        of = formulas(Scene.from_file("double_pendulum"))
        self.assertEqual({symbol.name for symbol in of.used_letters()}, set("m_1 m_2 I_1 I_2 r_1 r_2 p_1 g".split()))
        self.assertEqual(of.with_numbers().used_letters(), {})
        self.assertFalse(of.given)
        numbers = of.with_numbers().closed
        self.assertEqual(numbers.M_theta.free_symbols | numbers.f_theta.free_symbols, {*of.theta, *of.omega})

    def test_drag_and_springs_are_written_as_on_paper(self):
        """A mass on a spring without rest length, in the air: m q̈ = −m g − k q − c |q̇| q̇."""
        mass = {"mass": 1.0, "drag": 0.5, "joint": {"type": "prismatic", "axis": [0, 1]}}
        of = formulas(Scene({"chain": ["a"], "links": {"a": mass}, "springs": {"s": {"link": "a", "ground": [0, 0], "stiffness": 9}}}))
        letter = {symbol.name: symbol for symbol in of.letters}
        m, c, k, g, q, qd = (*(letter[name] for name in "m_1 ca_1 spring_s_stiffness g".split()), of.q[0], of.qd[0])
        for form in (of.closed, of):
            self.assertEqual(sp.simplify(of.in_q(form.f)[0] - (-m * g - k * q - c * sp.Abs(qd) * qd)), 0)
        text = Document(formulas(Scene.from_file("bungee")), "it", None, True).text()
        for words in (r"S^+_{\mathrm{rope}} &=", r"|v|_{3} &= \sqrt{", r"(\partial F_x/\partial s_y)_{\mathrm{rope}} &=", "G_{3} &="):
            self.assertIn(words, text)

    def test_what_cannot_be_written_is_refused_by_name(self):
        with self.assertRaisesRegex(NoFormula, "chain: expected at most 10 links, got 11.*src/recursion/articulated.h"):
            formulas(Scene.from_file("crane"))
        rod = {"mass": 1, "inertia": 0.1, "com": [0.5, 0], "pin": [1, 0]}
        table = {"times": list(range(101)), "values": [0] * 101}
        for part, path in (({"links": {"rod": {**rod, "joint": {"drive": table}}}}, "links/rod/joint/drive"),
                           ({"links": {"rod": rod}, "base": {"x": table}}, "base/x"),
                           ({"links": {"rod": rod}, "loads": {"push": {"joint": "rod_joint", "torque": 1, **table}}}, "loads/push")):
            with self.assertRaisesRegex(NoFormula, path + ": expected at most 100 times and values, got 101"):
                formulas(Scene({"chain": ["rod"], **part}))


class Tool(InFolder):
    def tool(self, *arguments, status=0):
        run = subprocess.run([os.path.join(BIN, "formulas"), *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                             universal_newlines=True, check=False, cwd=self.folder)
        self.assertEqual(run.returncode, status, run.stderr)
        return run.stdout + run.stderr

    def test_code_in_c_has_a_header_for_c_and_cpp(self):
        for more, argument in (((), "&two_scene, "), (("--numbers",), "")):
            self.assertEqual(self.tool("double_pendulum", "--format", "c", "--linearize", "--output", "two.c", *more), "written to two.c and two.h\n")
            with open(self.path("main.cpp"), "w", encoding="ascii") as file:
                file.write('#include "two.h"\n#include "two.h"\nint main() {\n  double q[2] = {1, 2}, qd[2] = {}, tau[2] = {}, M[2][2], A[4][4];\n'
                           f"  two_M({argument}0, q, qd, M);\n  two_A({argument}0, q, qd, tau, A);\n  return M[0][1] == M[1][0] && A[0][2] == 1 ? 7 : 1;\n}}\n")
            for command in (["gcc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-include", "two.h", "-c", "-o", "alone.o", "-x", "c", "/dev/null"],
                            ["gcc", "-std=c99", "-c", "two.c"], ["g++", "-Wall", "-Wextra", "-Werror", "main.cpp", "two.o", "-o", "two", "-lm"]):
                subprocess.run(command, check=True, cwd=self.folder)
            self.assertEqual(subprocess.run([self.path("two")], check=False).returncode, 7)
        with open(self.path("own.h"), "w", encoding="ascii") as file:
            file.write("int own;\n")
        self.assertIn("--output: expected no file own.h, which would be the header of own.c, got one",
                      self.tool("double_pendulum", "--format", "c", "--output", "own.c", status=2))

    def test_code_is_named_after_its_file(self):
        self.tool("double_pendulum", "--format", "c", "--linearize", "--output", "two.c")
        with open(self.path("two.c"), encoding="utf-8") as file:
            text = file.read()
        for name in ("M", "f", "qdd", "A", "B"):
            self.assertIn(f"void two_{name}(const struct two_parameters *p, double t,", text)
        self.assertIn("of the scene double_pendulum.", text)
        self.assertIn("kg m^2", text)
        self.assertNotIn("p->", self.tool("double_pendulum", "--format", "c", "--numbers"))
        self.assertIn("function [M, f, qdd] = double_pendulum(t, q, qd, p)", self.tool("double_pendulum", "--format", "matlab", "--output", "-"))
        self.assertIn("[M, f, qdd, A, B] = double_pendulum(t, q, qd, p, tau)", self.tool("double_pendulum", "--format", "matlab", "--linearize"))
        self.assertIn("def A(xp, t, q, qd, tau=None):", self.tool("double_pendulum", "--format", "python", "--numbers", "--linearize"))
        self.assertIn("def qdd(xp, t, q, qd):", self.tool("double_pendulum", "--format", "python", "--numbers"))

    def test_a_urdf_is_a_scene(self):
        self.assertIn("of the scene robot.urdf.", self.tool(self.robot(), "--format", "c"))

    def test_bad_arguments(self):
        self.assertIn("expected at most 10 links, got 100", self.tool("rope", "--format", "c", status=2))
        self.assertIn("no_such_scene", self.tool("no_such_scene", "--format", "c", status=2))
        for name in ("it.txt", "end.m"):
            self.assertIn("ends in .m", self.tool("pendulum", "--format", "matlab", "--output", name, status=2))
        self.assertIn("No such file", self.tool("pendulum", "--format", "c", "--output", "none/it.c", status=2))
        with open(self.path("bad.yaml"), "w", encoding="utf-8") as file:
            file.write("chain: [a]\nlinks: {a: {mass: heavy}}\n")
        self.assertIn("links/a/mass: expected", self.tool("bad.yaml", "--format", "c", status=2))
        self.assertIn("expected a file that can be written, got : No such", self.tool("pendulum", "--format", "c", "--output", "", status=2))
        self.assertIn("expected a file that is not another of the run's", self.tool("bad.yaml", "--format", "c", "--output", "./bad.yaml", status=2))

    def test_outputs_that_are_full_or_pipes(self):
        self.assertEqual(self.tool("pendulum", "--format", "c", "--output", "/dev/full", status=1),
                         "formulas: cannot write /dev/full: No space left on device\n")
        os.mkfifo(self.path("pipe"))
        with subprocess.Popen(["cat", self.path("pipe")], stdout=subprocess.PIPE, universal_newlines=True) as reader:
            try:
                self.tool("pendulum", "--format", "latex", "--output", self.path("pipe"))
                self.assertIn("{pipe_chain.pdf}", reader.stdout.read())
            finally:
                reader.kill()

    def test_latex(self):
        self.tool("double_pendulum", "--format", "latex", "--output", "it.tex")
        with open(self.path("it.tex"), encoding="utf-8") as file:
            text = file.read()
        self.assertIn(r"\includegraphics[width=\textwidth,height=75mm,keepaspectratio]{it_chain.pdf}", text)
        self.assertTrue(os.path.getsize(self.path("it_chain.pdf")) > 1000)
        self.assertIn(r"$\theta_i = q_{1} + \dots + q_i$ is the absolute angle", text)
        self.assertIn(r"M_{11} &= I_{1} + I_{2} + m_{1} r_{1}^{2} + 2 m_{2} p_{1} r_{2} \cos {q_{2}} + "
                      r"m_{2} \left(p_{1}^{2} + r_{2}^{2}\right)", text)

    def test_the_sketch_has_every_letter_of_the_bodies(self):
        for name, scene in shipped().items():
            if len(scene) > FEW:
                continue
            drawn = {text.get_text() for text in draw(read(scene)).axes[0].texts}
            letters = {letter for words in drawn for letter in re.findall(r"([a-zA-Z]+)_\{(\d)\}", words)}
            needed = {tuple(re.match(r"(\w)_(\d)[xy]?$", str(symbol)).groups()) for symbol in formulas(scene).used_letters()
                      if re.match(r"[mIpr]_\d[xy]?$", str(symbol))}
            needed |= {("q", str(i)) for i in range(1, len(scene) + 1)}
            self.assertLessEqual(needed, letters, name)
            pyplot.close("all")

    def test_a_picture_of_something_else_is_left_alone(self):
        for page in (None, "of something else"):
            for name, text in (("it_chain.pdf", "mine"), ("it.tex", page)):
                if text is not None:
                    with open(self.path(name), "w", encoding="utf-8") as file:
                        file.write(text)
            self.assertIn("--output: expected no file it_chain.pdf, which would be the picture of it.tex, got one",
                          self.tool("pendulum", "--format", "latex", "--output", "it.tex", status=2))
            with open(self.path("it_chain.pdf"), encoding="utf-8") as file:
                self.assertEqual(file.read(), "mine")
            self.assertEqual(os.path.exists(self.path("it.tex")), page is not None)
        for _ in range(2):  # its own is replaced
            self.tool("pendulum", "--format", "latex", "--output", "other.tex")

    @unittest.skipUnless(shutil.which("pdflatex"), "pdflatex not found: LaTeX is not compiled")
    def test_latex_compiles(self):
        for name, scene in shipped().items():
            if name not in PAGES and "FORMULAS_PAGES" not in os.environ:
                continue
            for more in ([], ["--numbers"]) if len(name) < 6 else (["--linearize"] if len(scene) < 5 else [],):
                with open(self.path("it.tex"), "w", encoding="utf-8") as file:
                    file.write(self.tool(name, "--format", "latex", *more))
                run = subprocess.run(["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "it.tex"], cwd=self.folder, check=False,
                                     stdout=subprocess.PIPE, stdin=subprocess.DEVNULL)
                self.assertEqual(run.returncode, 0, run.stdout.decode(errors="replace")[-2000:])


if __name__ == "__main__":
    BIN = os.path.abspath(sys.argv.pop(1))
    unittest.main()
