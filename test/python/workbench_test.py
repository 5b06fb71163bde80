#!/usr/bin/python3
"""What a control engineer does from Python: states that are taken and put back, linear models about torques, places of points.

    workbench_test.py BIN [unittest options]       BIN: the folder that holds the tools; PYTHONPATH finds planar_chain
"""
import copy
import json
import os
import pickle
import subprocess
import sys
import unittest
import warnings

try:
    import numpy as np
except ImportError:
    print("numpy not found: skipped")
    sys.exit(77)

from planar_chain import (NotReached, Refused, Scene, Simulation, inverse_dynamics, inverse_kinematics,
                          linearize, simulate)

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../support"))
from in_folder import InFolder  # noqa: E402

BIN = ""
ROD = {"mass": 1, "inertia": 1 / 12, "com": [0.5, 0], "pin": [1, 0]}
RODS = {"chain": ["upper", "lower"], "links": {"upper": ROD, "lower": ROD}}
STILL = np.zeros(2)
MOTOR = {"motor": {"time_constant": 0.05, "no_load_speed": 30}, "effort_limit": 40, "command_delay": 0.01}
MACHINE = {"chain": ["cart", "arm", "hand"], "links": {
    "cart": {"mass": 2, "pin": [0, 0], "joint": {"type": "prismatic", "axis": [1, 0], "friction": 1, "lower": -0.3, "upper": 0.3,
                                                 **MOTOR}},
    "arm": {**ROD, "joint": MOTOR, "initial": {"angle": -1}}, "hand": {**ROD, "joint": {"friction": 0.1}}},
    "sensors": {"angles": {"joints": "all", "rate": 100, "noise": 1e-3, "delay": 0.02}}}


def run(simulation, k):
    simulation.hold_torques([5 * (-1) ** k, 3, 0.2])
    simulation.advance_to(simulation.time + 0.03)
    return simulation.state.tolist(), [one.values.tolist() for one in simulation.measure()], str(simulation.statistics())


def messages(call):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        call()
    return " ".join(str(one.message) for one in caught)


def riccati(A, B, R):
    """K of the LQR with Q = 1 and R = R 1, by the stable subspace of the Hamiltonian."""
    n = len(A)
    values, vectors = np.linalg.eig(np.block([[A, -B @ B.T / R], [-np.eye(n), -A.T]]))
    stable = vectors[:, values.real < 0]
    P = np.real(stable[n:] @ np.linalg.inv(stable[:n]))
    return B.T @ P / R


def held(scene, pose, tau, off=0.0):
    simulation = Simulation(scene)
    simulation.set_state(np.add(pose, off), STILL)
    simulation.hold_torques(tau)
    return simulation


def linearize_without_words(scene, pose):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return linearize(scene, pose, STILL)


class States(unittest.TestCase):
    def test_motions_have_derivatives(self):
        scene, times, mass = Scene(RODS), [0.2, 0.5], "links/lower/mass"
        motion = simulate(scene, times, derivatives=["state", mass, "torques"])
        self.assertEqual(motion.states.tolist(), simulate(scene, times).tolist())
        self.assertEqual(motion.derivatives["torques"].shape, (2, 4, 2))
        simulation = Simulation(scene)
        Phi, Gamma = simulation.transition(0.5)
        self.assertEqual(simulation.state.tolist(), simulate(scene, [0.5])[0].tolist())
        np.testing.assert_allclose(motion.derivatives["state"][1], Phi, rtol=0, atol=1e-7)
        np.testing.assert_allclose(motion.derivatives["torques"][1], Gamma, rtol=0, atol=1e-7)
        more, less = (simulate(scene.with_values({mass: 1 + by}), times) for by in (1e-3, -1e-3))
        np.testing.assert_allclose(motion.derivatives[mass][:, :, 0], (more - less) / 2e-3, rtol=0, atol=1e-4)  # differences' error
        with self.assertRaisesRegex(Refused, "links/lower/weight"):
            simulate(scene, times, derivatives=["links/lower/weight"])

    def test_transitions_through_motors_that_lag_chain(self):
        # The rod turns by J q̈ = x, T ẋ = u − x: the matrix exponential of its (A, B) is in closed form. With e = exp(−t/T), x after
        # T (1 − e) adds T (1 − e)/J to q̇ and T (t − T (1 − e))/J to q.
        T, J, step = 0.1, 0.35, 0.1
        rod = Scene({"chain": ["rod"], "gravity": [0, 0], "links": {"rod": {**ROD, "inertia": 0.1, "joint": {"motor": {"time_constant": T}}}}})
        e = np.exp(-step / T)
        Phi = np.array([[1, step, T * (step - T * (1 - e)) / J], [0, 1, T * (1 - e) / J], [0, 0, e]])
        Gamma = np.array([[step ** 2 / 2 / J - Phi[0, 2]], [step / J - Phi[1, 2]], [1 - e]])
        simulation, chained = Simulation(rod), np.zeros((3, 0))
        for k, u in enumerate([1.0, 2.0], 1):
            simulation.hold_torques([u])
            F, G = simulation.transition(k * step, motors=True)
            np.testing.assert_allclose(np.hstack([F, G]), np.hstack([Phi, Gamma]), rtol=0, atol=1e-8)
            chained = np.hstack([F @ chained, G])

        def end(u):
            whole = Simulation(rod)
            for k, held in enumerate(u, 1):
                whole.hold_torques([held])
                whole.advance_to(k * step)
            return np.append(whole.state, whole.motor_torques)
        difference = (end([2.0, 2.0]) - end([0.0, 2.0])) / 2  # the motion is linear
        np.testing.assert_allclose(chained[:, 0], difference, rtol=0, atol=1e-7)
        self.assertIn("leave out the lagged torques of rod_joint: with motors=True they are states",
                      messages(lambda: simulation.transition(0.3)))
        self.assertEqual(messages(lambda: simulation.transition(0.4, motors=True)), "")
        sliding = Scene({"chain": ["rod"], "links": {"rod": {**ROD, "joint": {"friction": 0.5}}}})
        self.assertIn("rod_joint starts to slip at t = 0 s", messages(lambda: simulate(sliding, [0, 0.1], derivatives=["state"])))
        self.assertEqual(messages(lambda: simulate(sliding, [0.1], derivatives=["links/rod/mass"])), "")

    def test_a_run_begins_in_a_pose_that_motors_hold(self):
        arm = Scene({**RODS, "links": {"upper": {**ROD, "joint": {"motor": {"time_constant": 0.2}}}, "lower": ROD}})
        pose = [0.4, 0.6]
        tau = inverse_dynamics(arm, STILL, pose, STILL)
        plant = held(arm, pose, tau)
        self.assertEqual(plant.motor_torques.tolist(), [0, tau[1]])
        plant.motor_torques = tau
        saved = plant.save()
        plant.advance_to(0.1)
        np.testing.assert_allclose(plant.state, [*pose, 0, 0], rtol=0, atol=1e-9)
        plant.restore(saved)
        self.assertEqual(plant.motor_torques.tolist(), tau.tolist())
        with self.assertRaisesRegex(Refused, "motor_torques/1: expected .* N m, as commanded: lower_joint has no lag, got 0"):
            plant.motor_torques = STILL

    def test_a_restored_simulation_goes_on_bit_for_bit(self):
        simulation = Simulation(Scene(MACHINE))
        for k in range(5):
            run(simulation, k)
        saved = simulation.save()
        twin = copy.deepcopy(simulation)
        other = Simulation(Scene(MACHINE))
        other.restore(pickle.loads(pickle.dumps(saved)))
        after = [run(simulation, k) for k in range(10)]
        self.assertEqual([run(twin, k) for k in range(10)], after)
        self.assertEqual([run(other, k) for k in range(10)], after)
        simulation.restore(saved)
        self.assertEqual([run(simulation, k) for k in range(10)], after)

    def test_states_of_something_else_are_refused(self):
        simulation = Simulation(Scene(MACHINE))
        saved = simulation.save()
        for other in (Simulation(Scene(MACHINE), commands=3), Simulation(Scene(RODS)),
                      Simulation(Scene(MACHINE).with_values({"links/hand/mass": 1.5}))):
            with self.assertRaisesRegex(Refused, "saved: expected a state of the same scene"):
                other.restore(saved)
        with self.assertRaises(TypeError):
            simulation.restore(b"")


class LinearModels(InFolder):
    def test_an_lqr_at_a_pose_that_torques_hold_is_stable_on_the_plant(self):
        scene, pose = Scene(RODS), [0.5, 1.2]
        tau = inverse_dynamics(scene, STILL, pose, STILL)
        A, B = linearize(scene, pose, STILL, tau=tau)
        for other in linearize(scene, pose, STILL, tau="holding"), held(scene, pose, tau).linearize():
            np.testing.assert_allclose(other[0], A, rtol=0, atol=1e-12)
            np.testing.assert_allclose(other[1], B, rtol=0, atol=1e-13)
        blind = linearize_without_words(scene, pose)
        growth = {}
        for name, (its_A, its_B) in {"held": (A, B), "blind": blind}.items():
            K = riccati(its_A, its_B, 1e4)
            self.assertLess(np.linalg.eigvals(its_A - its_B @ K).real.max(), 0)  # on its own model
            growth[name] = np.linalg.eigvals(A - B @ K).real.max()
            plant = held(scene, pose, tau, 1e-3)
            for k in range(1, 601):
                plant.hold_torques(tau - K @ (plant.state - [*pose, 0, 0]))
                plant.advance_to(k * 0.01)
            growth[name + " plant"] = np.abs(plant.q - pose).max()
        self.assertLess(growth["held"], -0.01)
        self.assertLess(growth["held plant"], 1e-3)
        self.assertGreater(growth["blind"], 0.01)        # what the torques are for
        self.assertGreater(growth["blind plant"], 1e-2)

    def test_what_a_model_does_not_say_is_a_warning(self):
        scene = Scene(RODS)
        self.assertRegex(messages(lambda: linearize(scene, [0, 0], STILL)), "The torques tau = 19.62,4.905 would hold it")
        self.assertEqual(messages(lambda: linearize(scene, [0, 0], STILL, tau="holding")), "")
        machine = Scene(MACHINE)
        at_rest = [0, -np.pi / 2, 0], [0, 0, 0]
        words = messages(lambda: linearize(machine, *at_rest))
        self.assertRegex(words, "cart_joint and hand_joint stick: ")
        self.assertRegex(words, r"of cart_joint \(command_delay 0.01 s\)")
        self.assertNotRegex(messages(lambda: linearize(machine, *at_rest, friction="slips")), "stick")
        weak = Scene({**RODS, "links": {"upper": {**ROD, "joint": {"effort_limit": 10}}, "lower": ROD}})
        self.assertEqual(messages(lambda: linearize(weak, [0, 0], STILL, tau="holding")),
                         "tau: 19.62 N m in upper_joint is beyond its effort_limit, 10 N m: no command gives it")
        for wrong in ({"tau": "held"}, {"tau": [1]}, {"tau": [1, np.nan]}, {"friction": "none"}):
            with self.assertRaisesRegex(Refused, list(wrong)[0] + ": expected"):
                linearize(scene, [0, 0], STILL, **wrong)

    def test_lags_of_motors_are_states(self):
        simulation = Simulation(Scene(MACHINE))
        simulation.hold_torques([3, 10, 0])
        simulation.advance_to(0.1)
        A, B = simulation.linearize(motors=True)
        plain = simulation.linearize()
        self.assertEqual((A.shape, B.shape), ((8, 8), (8, 3)))   # x and torques of two motors
        np.testing.assert_array_equal(A[:6, :6], plain[0])
        np.testing.assert_array_equal(A[:6, 6:], plain[1][:, :2])
        np.testing.assert_array_equal(A[6:, 6:], -20 * np.eye(2))
        np.testing.assert_array_equal(B[6:, :2], 20 * np.eye(2))
        np.testing.assert_array_equal(B[:6], [[0, 0, b] for b in plain[1][:, 2]])

    def test_the_tool_is_the_same(self):
        with open(self.path("rods.json"), "w", encoding="utf-8") as file:
            json.dump(RODS, file)
        told = subprocess.run([os.path.join(BIN, "equations"), file.name, "--linearize", "--q", "0.5,1.2", "--qd", "0,0", "--tau",
                               "holding", "--json"], check=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        A, B = linearize(Scene(RODS), [0.5, 1.2], STILL, tau="holding")
        found = json.loads(told.stdout)
        self.assertEqual((found["A"], found["B"], told.stderr), (A.tolist(), B.tolist(), b""))
        point = subprocess.run([os.path.join(BIN, "equations"), file.name, "--point", "lower,0.4,0", "--q", "0.5,1.2", "--qd", "1,2",
                                "--json"], check=True, stdout=subprocess.PIPE)
        found, at = json.loads(point.stdout), Scene(RODS).motion("lower", [0.4, 0], [0.5, 1.2], [1, 2])
        self.assertEqual((found["position"], found["velocity"], found["Jdot_qd"]), (
            [*at.position, at.angle], [*at.velocity, at.rate], [*at.acceleration, at.angular_acceleration]))
        self.assertEqual(found["J"], Scene(RODS).jacobian("lower", [0.4, 0], [0.5, 1.2], with_angle=True).tolist())

class Places(unittest.TestCase):
    SCENE = Scene({**RODS, "frames": {"gripper": {"link": "lower", "point": [0.4, 0.1], "angle": 0.5}}})

    def test_of_links_frames_and_the_tip(self):
        scene, q = self.SCENE, [0.3, 0.5]
        tip = [np.cos(0.3) + np.cos(0.8), np.sin(0.3) + np.sin(0.8)]
        for of in (("tip", q), ("tip", None, q), ("lower", [1, 0], q), (1, [1, 0], q)):
            np.testing.assert_allclose(scene.position(*of), tip, rtol=1e-15)
        np.testing.assert_allclose(scene.position("gripper", q, with_angle=True), [
            *scene.position("lower", [0.4, 0.1], q), 1.3], rtol=1e-15)
        self.assertEqual(scene.position("lower").tolist(), [1, 0])  # the inner pin, in the first state
        J = scene.jacobian("gripper", q)
        self.assertEqual(J.shape, (2, 2))
        at = scene.motion("gripper", q, qd=[1, 2])
        np.testing.assert_allclose(at.velocity, J @ [1, 2], rtol=1e-14)
        for wrong in (("gripper", [0, 0], q), ("griper", q), ("lower", [0, 0, 0], q), ("tip", [1, 2, 3]), (2, [0, 0])):
            self.assertRaises(Refused, scene.position, *wrong)

    def test_of_a_simulation(self):
        simulation = Simulation(self.SCENE)
        simulation.advance_to(0.4)
        exact = self.SCENE.motion("gripper", simulation.q, qd=simulation.qd, qdd=simulation.accelerations())
        now = simulation.motion("gripper")
        for name in ("position", "angle", "velocity", "rate", "acceleration", "angular_acceleration"):
            np.testing.assert_allclose(getattr(now, name), getattr(exact, name), rtol=1e-12, err_msg=name)

    def test_joint_angles_for_a_place(self):
        q = inverse_kinematics(self.SCENE, "gripper", [0.7, 0.9], start=[0, 0.1])
        np.testing.assert_allclose(self.SCENE.position("gripper", q), [0.7, 0.9], atol=3e-12)
        q = inverse_kinematics(self.SCENE, "lower", [0.7, 0.9], point=[1, 0])
        np.testing.assert_allclose(self.SCENE.position("tip", q), [0.7, 0.9], atol=3e-12)
        with self.assertRaises(NotReached) as missed:
            inverse_kinematics(self.SCENE, "tip", [0, 2.5])
        self.assertAlmostEqual(missed.exception.distance, 0.5, 12)
        np.testing.assert_allclose(missed.exception.q, [np.pi / 2, 0], atol=1e-5)


if __name__ == "__main__":
    BIN = sys.argv.pop(1)
    unittest.main()
