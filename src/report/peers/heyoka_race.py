#!/usr/bin/env python3
"""heyoka as a contestant of the report: Taylor's method, the step compiled by LLVM for each set of equations and order.

The equations are those that suit it best: of one link, of two and of a pole on a cart the closed form by Cramer's rule; of
more, the articulated recursion, written as expressions.
"""
import json
import math
import pathlib
import statistics
import subprocess
import time

import heyoka as hy
import numpy as np

import contest as contests

LONGEST = 20  # links: the expressions of more take minutes to compile
OWN = pathlib.Path(__file__).with_name("own_batches.py")
COMPILING = 120  # s, at most
LANES = 8
MOST_STEPS = 20000
FIRST = 1e-3  # s, the most that the first step takes: where a motion's first orders vanish, as from rest in line, it would take all


def turned(a, v):
    """A vector of body axes in ground axes, and a quarter turn further."""
    c, s = hy.cos(a), hy.sin(a)
    x, y = (c * v[0], s * v[0]) if v[1] == 0 else (c * v[0] - s * v[1], s * v[0] + c * v[1])
    return np.array([x, y]), np.array([-y, x])


def torques(contest, theta, omega):
    """Of springs and dampers, between each link and the one before; None where there are none."""
    for i, joint in enumerate(contest.joints):
        if joint["stiffness"] == 0 and joint["damping"] == 0:
            yield None
        else:
            q, qd = (x[i] - x[i - 1] if i else x[0] for x in (theta, omega))
            yield -joint["stiffness"] * (q - joint["rest_angle"]) - joint["damping"] * qd


def closed_form(contest, theta, omega):
    """(δ = θ_1 − θ_2; the letters of by_hand.cpp)"""
    (first, second), g = contest.links, -contest.gravity[1]
    length, r1, r2 = first["pin"][0], first["com"][0], second["com"][0]
    a = first["inertia"] + first["mass"] * r1**2 + second["mass"] * length**2
    b, c = second["mass"] * length * r2, second["inertia"] + second["mass"] * r2**2
    delta = theta[0] - theta[1]
    bc, bs = b * hy.cos(delta), b * hy.sin(delta)
    right = (-bs * omega[1]**2 - (first["mass"] * r1 + second["mass"] * length) * g * hy.cos(theta[0]),
             bs * omega[0]**2 - second["mass"] * r2 * g * hy.cos(theta[1]))
    inverse = 1 / (a * c - bc * bc)
    return [(c * right[0] - bc * right[1]) * inverse, (a * right[1] - bc * right[0]) * inverse]


def cart_pole(contest, position, rate):
    """(the letters of race_odeint.cpp)"""
    (cart, pole), g = contest.links, -contest.gravity[1]
    reach = pole["mass"] * pole["com"][0]
    mass, inertia = cart["mass"] + pole["mass"], pole["inertia"] + reach * pole["com"][0]
    c, s = hy.cos(position[1]), hy.sin(position[1])
    b, along, turning = -reach * s, reach * c * rate[1]**2, -reach * g * c
    inverse = 1 / (mass * inertia - b * b)
    return [(inertia * along - b * turning) * inverse, (mass * turning - b * along) * inverse]


def recursion(contest, theta, omega):
    """Inwards f_i = A_i a_i + b_i, the force at the inner pin; outwards α_i = (u_i − h_i·a_i) / D_i, from a_1 = −g."""
    n, tau = len(contest), [*torques(contest, theta, omega), None]
    A, b, terms = None, None, [None] * n
    for i in reversed(range(n)):
        link = contest.links[i]
        C, C90 = turned(theta[i], link["com"])
        P, P90 = turned(theta[i], link["pin"])
        m, ww = link["mass"], omega[i]**2
        D = link["inertia"] + m * (link["com"][0]**2 + link["com"][1]**2)
        u = sum((sign * t for sign, t in ((1, tau[i]), (-1, tau[i + 1])) if t is not None), hy.expression(0.))
        if A is None:
            h, A, b = m * C90, np.zeros((2, 2)), np.zeros(2)
        else:
            b = b - ww * (A @ P)
            AP = A @ P90
            D, h, u = D + P90 @ AP, m * C90 + AP, u - P90 @ b
        terms[i] = D, h, u, P, P90, ww
        hD = h / D
        cross = -h[0] * hD[1]
        A = np.array([[A[0, 0] + m - h[0] * hD[0], A[0, 1] + cross], [A[1, 0] + cross, A[1, 1] + m - h[1] * hD[1]]])
        b = b - m * ww * C + hD * u
    a, alpha = -np.array(contest.gravity), []
    for D, h, u, P, P90, ww in terms:
        alpha.append((u - h @ a) / D)
        a = a + alpha[-1] * P90 - ww * P
    return alpha


def takes(contest):
    return contest.is_plain and len(contest) <= LONGEST


def system(contest):
    n = len(contest)
    x, v = (hy.make_vars(*(f"{letter}{i}" for i in range(n))) for letter in "xv")
    x, v = ([x], [v]) if n == 1 else (x, v)
    is_flat = all(link[key][1] == 0 for link in contest.links for key in ("com", "pin"))
    right = (cart_pole if contest.has_cart else closed_form if n == 2 and is_flat and not contest.has_springs else
             recursion)(contest, x, v)
    return [*zip(x, v), *zip(v, right)]


def start_of(contest):
    return np.array(contest.absolute(contest.q) + contest.absolute(contest.qd))


class Run:
    def __init__(self, contest, tolerance):
        self.end, self.first = contest.end, start_of(contest)
        began = time.perf_counter()
        self.method = hy.taylor_adaptive(system(contest), self.first, tol=tolerance, compact_mode=False)
        self.compiled_in = time.perf_counter() - began

    def start(self):
        self.method.time = 0.
        self.method.state[:] = self.first

    def go(self):
        self.method.step(FIRST)
        outcome, _, _, self.steps, *_ = self.method.propagate_until(self.end, max_steps=MOST_STEPS)
        return outcome == hy.taylor_outcome.time_limit

    def read(self):
        theta, omega = np.split(self.method.state, 2)
        return theta, omega, 0, self.steps, 0


# ---- Beside the race ---------------------------------------------------------------------------

def compiling(contest):
    """What compiling a step takes, without heyoka's cache of earlier ones on disk."""
    hy.llvm_state.set_diskcache_enabled(False)
    for k in (3, 6, 9):
        yield f"1e-{k}", Run(contest, 10.0**-k).compiled_in, math.nan


def starts_near(contest, runs):
    """Within 0.1 rad and rad/s of the scene's own start, relative coordinates."""
    return np.array(contest.q + contest.qd) + np.random.default_rng(1).uniform(-0.1, 0.1, (runs, 2 * len(contest)))


def in_batches(contest, starts, tolerance, repetitions=1):
    """The angles at the end of each start, by batches of eight, and the median time of a run."""
    first = np.hstack([np.cumsum(part, axis=1) for part in np.split(starts, 2, axis=1)])
    method = hy.taylor_adaptive_batch(system(contest), np.zeros((first.shape[1], LANES)), tol=tolerance, compact_mode=False)
    taken = []
    for _ in range(repetitions):
        ends, seconds = [], 0
        for k in range(0, len(first), LANES):
            method.set_time(np.zeros(LANES))
            method.state[:] = first[k:k + LANES].T
            began = time.process_time()
            method.propagate_until(np.full(LANES, contest.end))
            seconds += time.process_time() - began
            ends.append(method.state.T[:, :len(contest)].copy())
        taken.append(seconds)
    return np.vstack(ends), statistics.median(taken) / len(starts)


def by_simulate_many(contest, starts, tolerance, repetitions):
    batch = {"path": str(contest.path), "tolerance": tolerance, "starts": starts.tolist(), "end": contest.end, "repetitions": repetitions}
    result = json.loads(subprocess.run([OWN], input=json.dumps(batch), stdout=subprocess.PIPE, universal_newlines=True, check=True).stdout)
    return np.cumsum(np.array(result["states"])[:, :len(contest)], axis=1), statistics.median(result["seconds"]) / len(starts)


def batches(contest, quick):
    """(program, tolerance, s a run, the median run's error) on one core; errors against heyoka's own at 1e-18."""
    starts = starts_near(contest, 16 if quick else 128)
    exact = in_batches(contest, starts, 1e-18)[0]
    for k in (6, 9, 12) if quick else range(3, 14):
        for name, way in (("heyoka", in_batches), ("planar_chain", by_simulate_many)):
            ends, seconds = way(contest, starts, 10.0**-k, 3 if quick else 15)
            yield name, f"1e-{k}", seconds, np.median(np.abs(ends - exact).max(axis=1))


def finished(lines):
    """Those that a process of its own yields before it crashes or a line takes too long."""
    return (line for line in contests.lines_of(lambda: lines, COMPILING) if not isinstance(line, str))


def beside(contest, quick):
    """Rows of peers.csv."""
    if takes(contest):
        for setting, seconds, error in finished(compiling(contest)):
            print(contest.name, "heyoka", "compile a step", setting, f"{seconds:.3e}", error, sep=",")
    if contest.name == "double":
        for name, setting, seconds, error in finished(batches(contest, quick)):
            print(contest.name, name, "a run in a batch on one core", setting, f"{seconds:.3e}", f"{error:.2e}", sep=",", flush=True)


METHODS = [contests.Method("Taylor", False, takes, Run, lambda contest: 1 + len(contest) // 10)]  # longer chains compile for seconds each

if __name__ == "__main__":
    contests.main("heyoka", METHODS, COMPILING, {"peers": beside})
