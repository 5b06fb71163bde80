"""Gaits of the simplest walker: Newton's method on a step, with events and derivatives of the motion.

The equations and their words: src/python/examples/walker.md. Two legs of length 1, the hip's mass 1, g = 1.
"""
import numpy as np

SLOPE, FOOT = 0.009, 1e-15  # rad; a foot's mass over the hip's, which the authors let go to 0
NUMBERS = ("θ⁺", "θ̇⁺", "Re λ₁", "Im λ₁", "Re λ₂", "Im λ₂")
GUESSES = {"long": (0.2, -0.2), "short": (0.194, -0.204)}


def scene(method, tolerance):
    leg = {"inertia": 0, "com": [1, 0], "pin": [1, 0]}
    return {"chain": ["stance", "swing"], "gravity": [np.sin(SLOPE), -np.cos(SLOPE)],
            "links": {"stance": {**leg, "mass": 1}, "swing": {**leg, "mass": FOOT}},
            "integrator": {"method": method, "tolerance": tolerance}}


def heel(_, q, __):
    return -2 * q[0] - q[1]


heel.terminal, heel.direction = True, 1


def step(simulation, start):
    """Returns the start of the next step, and its derivative by this one, 2 × 2."""
    theta, rate = start
    s, c = np.sin(2 * theta), np.cos(2 * theta)
    simulation.reset()
    simulation.set_state([np.pi / 2 + theta, -np.pi - 2 * theta], [rate, (c - 1) * rate])
    by_start = np.array([[1, 0], [-2, 0], [0, 1], [-2 * s * rate, c - 1]])
    saved = simulation.save()
    if simulation.advance_to(10, events=[heel]) is None:
        raise ValueError("the walker has fallen")
    end, theta, rate = simulation.time, simulation.q[0] - np.pi / 2, simulation.qd[0]
    f = np.concatenate([simulation.qd, simulation.accelerations()])
    simulation.restore(saved)
    at_end = simulation.transition(end)[0] @ by_start
    n = np.array([-2, -1, 0, 0])
    at_strike = at_end - np.outer(f, n @ at_end) / (n @ f)
    s, c = np.sin(2 * theta), np.cos(2 * theta)
    return np.array([-theta, c * rate]), np.array([[-1, 0, 0, 0], [-2 * s * rate, 0, c, 0]]) @ at_strike


def gait(name, method, tolerance):
    """Returns the values of NUMBERS: where a step ends as it began, and the eigenvalues of its derivative."""
    from planar_chain import Scene, Simulation  # pylint: disable=import-outside-toplevel
    simulation, start = Simulation(Scene(scene(method, tolerance))), np.array(GUESSES[name])
    for _ in range(6):  # the fourth is exact to rounding
        after, derivative = step(simulation, start)
        start = start + np.linalg.solve(np.eye(2) - derivative, after - start)
    first, second = sorted(np.linalg.eigvals(derivative), key=lambda value: (-value.real, -value.imag))
    return np.array([*start, first.real, first.imag, second.real, second.imag])
