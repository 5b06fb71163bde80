#!/usr/bin/python3
"""The environment to learn on: its episodes, its actions, its motors.

    python_environment_test.py BIN [unittest options]        BIN is not used; PYTHONPATH finds planar_chain
"""
import os
import re
import subprocess
import sys
import unittest

try:
    import numpy as np
except ImportError:
    print("numpy not found: skipped")
    sys.exit(77)

import planar_chain
from planar_chain import Scene, Simulation

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../support"))
from in_folder import URDF  # noqa: E402

SCENES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../config/scenes")
ROD = {"mass": 1, "inertia": 0, "com": [1, 0], "pin": [1, 0]}
PENDULUM = {"chain": ["rod"], "links": {"rod": ROD}, "gravity": [0, 0]}


def double_pendulum():
    return Scene.from_file(os.path.join(SCENES, "double_pendulum.yaml"))


class Rest(planar_chain.Environment):
    """The double pendulum, rewarded for rest."""

    def __init__(self, motors=None):
        super().__init__(double_pendulum(), motors or {"lower_joint": 2.0}, period=0.1, longest=20)

    def first_state(self, random):
        return random.normal(size=2), [0, 0]

    def reward(self, q, qd, action):
        return -abs(qd).sum()


class Spin(planar_chain.Environment):
    """A rod without gravity."""

    def __init__(self, motors, scene=PENDULUM, **more):  # pylint: disable=dangerous-default-value
        super().__init__(scene, motors, **more)

    def reward(self, q, qd, action):
        return float(qd[0])


class Environments(unittest.TestCase):
    def test_the_position_of_a_cart_is_no_angle(self):
        class Cart(planar_chain.Environment):
            def reward(self, q, qd, action):
                return 0

        env = Cart(Scene.from_file(os.path.join(SCENES, "cart_pole.yaml")), {"cart_joint": 5})
        env.reset()
        observation, _, _, _, info = env.step([1])
        (x, angle), qd = info["q"], info["qd"]
        self.assertGreater(x, 0)
        self.assertEqual(observation.tolist(), [x, np.sin(angle), np.cos(angle), *qd])
        self.assertTrue(env.observation_space.contains(observation))
        self.assertEqual(env.observation_space.high.tolist(), [np.inf, 1, 1, np.inf, np.inf])

    def test_a_telescope_is_pushed_and_seen_in_m(self):
        rod = {"mass": 1, "inertia": 0.1, "com": [0.5, 0], "pin": [0.5, 0]}
        along = {"type": "prismatic", "axis": [1, 0], "effort_limit": 50.0}
        env = Spin({"out_joint": 50}, Scene({"chain": ["arm", "out", "tool"], "gravity": [0, 0],
                                             "links": {"arm": rod, "out": {**rod, "joint": along}, "tool": rod}}), render_mode="rgb_array")
        env.reset()
        observation, _, _, _, info = env.step([1])
        (arm, out, tool), qd = info["q"], info["qd"]
        self.assertAlmostEqual(out, 0.5 * 50 / 2 * 0.05 ** 2, delta=1e-9)  # of two masses, without a turn
        self.assertEqual(observation.tolist(), [out, np.sin(arm), np.sin(tool), np.cos(arm), np.cos(tool), *qd])
        self.assertEqual(env.observation_space.high.tolist(), [np.inf, 1, 1, 1, 1, np.inf, np.inf, np.inf])
        self.assertTrue(env.observation_space.contains(observation))
        for _ in range(40):
            env.step([1])
        picture = env.render(100)  # it goes to the edge, however long it is
        self.assertTrue((picture[50, 90] != 255).any())

    def episode(self, seed):
        env = Rest()
        env.action_space.seed(seed)
        observations, over = [env.reset(seed=seed)[0]], False
        while not over:
            action = env.action_space.sample()
            self.assertTrue(env.action_space.contains(action))
            observation, reward, terminated, over, info = env.step(action)
            self.assertTrue(env.observation_space.contains(observation))
            np.testing.assert_array_equal(observation, [*np.sin(info["q"]), *np.cos(info["q"]), *info["qd"]])
            self.assertEqual((reward, terminated), (-abs(info["qd"]).sum(), False))
            observations.append(observation)
        self.assertEqual(len(observations), 21)
        return np.array(observations)

    def test_an_episode_is_repeated_by_its_seed(self):
        first = self.episode(1)
        self.assertEqual(self.episode(1).tolist(), first.tolist())
        self.assertNotEqual(self.episode(2).tolist(), first.tolist())

    def test_an_action_is_held_as_a_torque_of_its_motor(self):
        env, simulation = Rest(), Simulation(double_pendulum())
        env.reset(seed=3)
        simulation.set_state(np.random.default_rng(3).normal(size=2), [0, 0])
        for k, action in enumerate((0.5, -1), 1):
            simulation.hold_torques([0, 2 * action])
            simulation.advance_to(0.1 * k)
            self.assertEqual(env.step([action])[4]["q"].tolist(), simulation.q.tolist())

    def test_an_action_outside_of_its_space_is_refused(self):
        env = Rest({"upper_joint": 1.0, "lower_joint": 2.0})
        env.reset(seed=3)
        for wrong, got in ((-1.5, "-1.5"), (np.nextafter(1, 2), "1.0000000000000002"), (np.nan, "nan"), (np.inf, "inf"),
                           (np.ma.masked_array(0.5, True), "nan")):
            with self.assertRaisesRegex(ValueError, rf"^action\[1\], of lower_joint: expected a number from -1 to 1, got {got}$"):
                env.step(np.ma.stack([0.0, wrong]))
        for wrong in ([0.5], [True, False], [0.5, True], ["0.5", "1"], [0.5, 1j], [0.5, None], [[0.5], [1]], np.ones(2, dtype=bool)):
            with self.assertRaisesRegex(ValueError, "^action: expected 2 numbers from -1 to 1, got"):
                env.step(wrong)
        self.assertEqual(env.step([0, 1])[4]["q"].shape, (2,))  # nothing was counted

    def test_an_unknown_motor_is_refused(self):
        for motors in ({"elbow": 1.0}, {}, "rod_joint", ["rod_joint"], None, {"rod_joint": "1"}, {"rod_joint": True}, {"rod_joint": np.ones(2)}):
            with self.assertRaisesRegex(ValueError, r"motors: expected joints of \['rod_joint'\] with .*, such as {'rod_joint': 5.0}, got"):
                Spin(motors)
        for more in ({"period": "1"}, {"period": 1j}, {"longest": None}, {"longest": np.nan}):
            with self.assertRaisesRegex(ValueError, "expected period > 0 s and longest >= 1 step"):
                Spin({"rod_joint": 1.0}, **more)

    def test_a_motor_gives_at_most_its_effort_limit(self):
        weak = {**PENDULUM, "links": {"rod": {**ROD, "joint": {"effort_limit": 2}}}}
        for scene in (weak, {"robot_description": URDF.replace("<axis", '<limit effort="2" velocity="9"/><axis')}):
            joint = Scene(scene).joints[0]
            with self.assertRaisesRegex(ValueError, f"^motors: expected at most the effort_limit of {joint}, 2 N m, got 5$"):
                Spin({joint: 5}, scene)
            self.assertEqual(Scene(scene).effort_limits.tolist(), [2])
            env = Spin({joint: 2}, scene)
            env.reset()
            self.assertNotEqual(env.step([1])[1], 0)
        with self.assertRaisesRegex(ValueError, "^motors: expected at most the effort_limit of cart_joint, 20 N, got 25$"):
            Spin({"cart_joint": 25}, Scene.from_file(os.path.join(SCENES, "cart_pole.yaml")))

    def test_a_first_state_is_two_arrays(self):
        env = Rest()
        for wrong in (np.zeros(4), np.zeros(2), [0, 1.5], ([0.0], [0.0, 1.0]), ([0.0], [0.0]), None, 3.0, "ab", ([0.0, np.nan], [0.0, 0.0])):
            env.first_state = lambda random, wrong=wrong: wrong
            with self.assertRaisesRegex(ValueError, r"^first_state: expected two arrays, q and qd, of 2 numbers, got .* \(.*\)$"):
                env.reset()

    def test_a_reward_is_a_finite_number(self):
        env = Spin({"rod_joint": 1.0})
        for wrong in (np.nan, -np.inf, None, "high", np.ones(2), 1j):
            env.reset()
            env.reward = lambda q, qd, action, wrong=wrong: wrong
            with self.assertRaisesRegex(ValueError, "^reward: expected a finite number, got "):
                env.step([0])
        for name, right, wrong in (("reward", "q, qd, action", "q, qd"), ("is_over", "q, qd", "q, qd, action"), ("first_state", "random", "")):
            scope = {}
            exec(f"def {name}(self, {wrong}): pass", scope)  # pylint: disable=exec-used
            with self.assertRaisesRegex(TypeError, rf"^{name}: expected a function of {right}, got one of \({wrong}\)$"):
                type("Wrong", (Spin,), {name: scope[name]})({"rod_joint": 1.0})

    def test_what_a_reward_does_to_its_arrays_is_its_own(self):
        env = Spin({"rod_joint": 1.0})

        def reward(q, qd, action):
            q[:] = qd[:] = action[:] = 9
            return 0

        def is_over(q, qd):
            over = q[0] == 9
            q[:] = qd[:] = 7
            return over
        env.reward, env.is_over = reward, is_over
        env.reset()
        _, _, over, _, info = env.step([1])
        self.assertFalse(over)
        self.assertTrue(0 < info["q"][0] < 1 and 0 < info["qd"][0] < 1, info)

    def test_a_step_needs_a_reset(self):
        with self.assertRaisesRegex(ValueError, "step: expected a reset"):
            Rest().step([0])

    def test_a_driven_joint_has_no_motor(self):
        driven = {**PENDULUM, "links": {"rod": {**PENDULUM["links"]["rod"], "joint": {"drive": {"offset": 0.0}}}}}
        with self.assertRaisesRegex(ValueError, r"torques/0: expected 0 N m in a driven joint"):
            Spin({"rod_joint": 1.0}, driven)

    def test_a_reward_is_asked_for_in_words(self):
        with self.assertRaisesRegex(TypeError, r"Environment: expected a class derived from .* that defines reward\(self"):
            planar_chain.Environment(PENDULUM, {"rod_joint": 1.0})

    def test_a_controller_that_diverges_ends_with_a_reason(self):
        env = Rest({"lower_joint": 1e12})
        env.reset(seed=1)
        with self.assertRaisesRegex(planar_chain.Failed, "the rate of lower_joint is .* rad/s, the torque in lower_joint 1e.12 N m"):
            env.step([1])

    def test_a_picture_shows_the_chain(self):
        env = Spin({"rod_joint": 1.0}, render_mode="rgb_array")
        env.reset()
        picture = env.render(101)
        self.assertEqual((picture.shape, picture.dtype), ((101, 101, 3), np.uint8))
        # A rod of 1 m along +x, in a view of 1.1 m to each side: nothing to the left, above or below.
        rows, columns = np.nonzero((picture != 255).any(axis=2))
        self.assertLess(abs(rows - 50).max(), 4)
        self.assertTrue(45 < columns.min() < 50 and 95 < columns.max() < 99, (columns.min(), columns.max()))
        with self.assertRaisesRegex(ValueError, r'^render: expected Spin\(…, render_mode="rgb_array"\), got one without a render_mode$'):
            Spin({"rod_joint": 1.0}).render()
        with self.assertRaisesRegex(ValueError, "render_mode: expected None or rgb_array, got 'human'"):
            Spin({"rod_joint": 1.0}, render_mode="human")

    def test_a_picture_shows_the_cart_on_its_rail(self):
        env = Spin({"cart_joint": 20}, Scene.from_file(os.path.join(SCENES, "cart_pole.yaml")), render_mode="rgb_array")
        env.reset()
        middles, grey = [], []
        for action in (1, 1, 1, -1, -1, -1, -1, -1, -1):
            info = env.step([action])[4]
            picture = env.render(200).astype(int)
            rows, columns = np.nonzero(abs(picture - (0, 114, 178)).max(axis=2) < 40)  # cart and pole
            metre = 100 / 1.1 / max(env._half, 1e-9)
            middles.append(abs(columns - 100 - info["q"][0] * metre).min())
            grey.append(np.count_nonzero(np.ptp(picture, axis=2)[100] == 0) > np.count_nonzero((picture[100] == 255).all(axis=1)))
        self.assertLess(max(middles), 8)  # half of the cart
        self.assertTrue(all(grey))


class ClosedChains(unittest.TestCase):
    def test_the_gain_of_its_page_balances_one(self):
        rod = {"mass": 1, "inertia": 1 / 12, "com": [0.5, 0], "pin": [1, 0]}
        q = np.array([np.pi / 2, -np.pi / 2, -np.pi / 2])  # on top of its circle
        links = {name: {**rod, "initial": {"angle": angle}} for name, angle in zip(("crank", "coupler", "rocker"), q)}
        bar = Scene({"chain": list(links), "links": links, "tip": {"pin": [1, 0]}})
        with open(os.path.join(SCENES, "../../src/python/README.md"), encoding="utf-8") as file:
            lines = re.search(r"^A, B = linearize\(bar.*?^```", file.read(), re.MULTILINE | re.DOTALL).group()[:-3]
        scope = {"bar": bar, "q": q, "np": np, **{name: getattr(planar_chain, name) for name in planar_chain.__all__}}
        exec(lines, scope)  # pylint: disable=exec-used
        A, B, T = scope["A"], scope["B"][:, :1], scope["T"]
        self.assertEqual(A.shape, (2, 2))
        np.testing.assert_allclose(planar_chain.linearize(bar, q, np.zeros(3))[0] @ T, T @ A, atol=1e-12)  # exact: no motion is lost
        self.assertGreater(max(np.linalg.eigvals(A).real), 3)
        # LQR for Q = 1, R = 1: P from the stable half of the Hamiltonian matrix.
        values, vectors = np.linalg.eig(np.block([[A, -B @ B.T], [-np.eye(2), -A.T]]))
        stable = vectors[:, values.real < 0]
        gain = B.T @ np.real(stable[2:] @ np.linalg.inv(stable[:2])) @ T.T
        for factor, ticks, low, high in ((1, 500, 0, 1e-3), (0, 50, 0.2, 0.4)):
            simulation = Simulation(bar)
            simulation.set_state(q + [0.1, -0.1, 0.1], [0, 0, 0])
            for k in range(1, ticks + 1):
                simulation.hold_torque("crank_joint", -factor * (gain @ (simulation.state - [*q, 0, 0, 0])).item())
                simulation.advance_to(0.01 * k)
            self.assertTrue(low <= abs(simulation.q - q).max() < high, simulation.q)


class Examples(unittest.TestCase):
    def run_example(self, name, most_lines=45):
        example = os.path.join(SCENES, "../../src/python/examples", name)
        with open(example, encoding="utf-8") as file:
            self.assertLessEqual(len(file.readlines()), most_lines)
        return subprocess.run([sys.executable, example], check=True, stdout=subprocess.PIPE, universal_newlines=True).stdout

    def test_random_search_gets_the_acrobot_up(self):
        self.assertIn("up after", self.run_example("acrobot.py"))

    def test_swing_up_ends_upright(self):
        self.assertEqual(self.run_example("swing_up.py"), "after 20 s: 0.000000 rad from upright, return 582\n")

    def test_the_filter_halves_the_error_of_the_encoder(self):
        errors = re.findall(r"[0-9.]+(?= rad)", self.run_example("filter.py", 65))
        encoder, angle, rate = map(float, errors)
        self.assertAlmostEqual(encoder, 0.02 / 12 ** 0.5, 4)  # of rounding
        self.assertLess(angle, encoder / 2)
        self.assertLess(rate, 0.02)


if __name__ == "__main__":
    sys.argv.pop(1)
    unittest.main()
