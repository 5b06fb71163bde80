#!/usr/bin/python3
"""Chains of real machines: rotors, drives, dry friction, a moving base, rest.

For the scenes machines/NAME.yaml it writes machines/motions.csv (the state at the end), torques.csv (inverse
dynamics) and rest.csv (static equilibria); README.md explains them.

    ./machines.py

The coordinates are the relative angles q. Points of the plane are complex numbers: with e_j = exp(iθ_j),
θ_j = φ + q_1 + … + q_j on a base at z_0 with angle φ, a point c of body i lies at

    z = z_0 + Σ_{j<i} p_j e_j + c e_i        ∂z/∂θ_j = i p_j e_j (j < i), i c e_i (j = i)

    z̈ = Σ_k ∂z/∂q_k q̈_k + b                   b = z̈_0 + Σ_j ∂z/∂θ_j φ̈ + i Σ_j ∂z/∂θ_j θ̇_j²

and d'Alembert's principle gives M q̈ = f + τ, where τ are the torques of friction and of drives:

    M_kl = Σ_i m_i ∂z_i/∂q_k · ∂z_i/∂q_l + Σ_{i ≥ k,l} I_i + J_k δ_kl
    f_k  = Σ_i m_i ∂z_i/∂q_k · (g − b_i) − Σ_{i ≥ k} I_i φ̈ + loads − stiffness (q_k − rest_k) − damping q̇_k
"""

import csv
import itertools
import math
import pathlib
import random

import mpmath
import numpy as np
import scipy.integrate
import scipy.interpolate
import scipy.optimize

import scene as scenes

FOLDER = pathlib.Path(__file__).parent / "machines"

# How long, s.
DURATIONS = {
    "rotors_2": 2, "drive_2": 2, "spline_3": 2, "rod_1": 2, "falling_2": 3, "stack_5": 2, "slow_3": 3,
    "base_x_1": 2, "base_turns_3": 2, "base_4": 1.5, "shaken_3": 3, "robot_4": 2, "all_5": 2,
    "stuck_1": 2, "given_2": 1.5, "holds_3": 1.5, "hidden_2": 1.5,
}
# Times of the states whose torques are asked for, s.
TORQUES = {"base_4": [0.0, 0.5, 1.25], "stack_5": [0.0, 0.5, 1.25], "falling_2": [0.0, 0.5, 1.25]}
REST = ["rest_1", "rest_3", "rest_5"]

# Tolerance and longest step, s, of the run that counts and of the one that checks it.
FINE, COARSE = (3e-14, 0.01), (1e-12, 0.015)


def dot(a, b):
    return (np.conj(a) * b).real


class Law:
    """A motion given in time. `within`: a time inside the piece that holds, for t at its edge."""

    def __init__(self, kind, *data):
        self.spline = None
        if kind == "spline":
            self.spline = scipy.interpolate.CubicSpline(*data, bc_type="clamped")
            self.edges = list(self.spline.x)
        else:
            self.amplitude, frequency, self.phase, self.offset = data
            self.rate = 2 * math.pi * frequency
            self.edges = []

    def value(self, t, within):
        """The value of the law at t, in any arithmetic."""
        if self.spline is None:
            return self.offset + self.amplitude * mpmath.sin(self.rate * t + self.phase)
        x = self.spline.x
        if not x[0] <= within < x[-1]:
            return float(self.spline(min(max(within, x[0]), x[-1])))
        piece = np.searchsorted(x, within, side="right") - 1
        s = t - float(x[piece])
        c3, c2, c1, c0 = map(float, self.spline.c[:, piece])
        return ((c3 * s + c2) * s + c1) * s + c0

    def at(self, t, within):
        """The value and two derivatives."""
        if self.spline is None:
            a, w, angle = self.amplitude, self.rate, self.rate * t + self.phase
            return np.array([self.offset + a * math.sin(angle), a * w * math.cos(angle), -a * w * w * math.sin(angle)])
        x = self.spline.x
        if not x[0] <= within < x[-1]:
            return np.array([self.spline(min(max(within, x[0]), x[-1])), 0, 0])
        piece = np.searchsorted(x, within, side="right") - 1
        cubic = np.poly1d(self.spline.c[:, piece])
        return np.array([cubic.deriv(k)(t - x[piece]) for k in range(3)])


def factor(load, t, within):
    """The factor of a load at t."""
    if not load.start <= within < load.stop:
        return 0.0
    kind, *data = load.law
    if kind == "sine":
        return math.sin(2 * math.pi * data[0] * t + data[1])
    return np.interp(t, *data) if kind == "ramp" else 1.0


class Machine:
    def __init__(self, scene):
        self.scene = scene
        links = scene.links
        self.n = len(links)
        column = lambda name: np.array([getattr(link, name) for link in links])
        self.mass, self.inertia, self.rotor = column("mass"), column("inertia"), column("rotor_inertia")
        self.stiffness, self.damping, self.rest = column("stiffness"), column("damping"), column("rest_angle")
        self.friction, self.breakaway = column("friction"), column("breakaway")
        self.com = [complex(*link.com) for link in links]
        self.pin = [complex(*link.pin) for link in links]
        self.gravity = complex(*scene.gravity)
        self.base = [Law(*law) for law in scene.base]
        self.drives = {i: Law(*link.drive) for i, link in enumerate(links) if link.drive}
        self.edges = {t for law in [*self.base, *self.drives.values()] for t in law.edges}
        for load in scene.loads:
            self.edges |= {load.start, load.stop} | set(load.law[1] if load.law[0] == "ramp" else [])

    # ---- Equations -------------------------------------------------------------------------------

    def equations(self, t, q, v, within):
        """M and f."""
        n = self.n
        (x, _, ax), (y, _, ay), (angle, turn, alpha) = (law.at(t, within) for law in self.base)
        unit = np.exp(1j * (angle + np.cumsum(q)))
        omega = turn + np.cumsum(v)
        from_inner = np.tril(np.ones((n, n)))  # of θ_j by q_k

        def point(i, place):
            """∂z/∂q and the b of z̈ = ∂z/∂q q̈ + b."""
            turned = np.zeros(n, complex)
            turned[:i] = [1j * self.pin[j] * unit[j] for j in range(i)]
            turned[i] = 1j * place * unit[i]
            return turned @ from_inner, ax + 1j * ay + sum(turned) * alpha + 1j * turned @ omega**2

        M = np.diag(self.rotor)
        f = -self.stiffness * (q - self.rest) - self.damping * v
        for i in range(n):
            z, b = point(i, self.com[i])
            M += self.mass[i] * dot(z[:, None], z[None, :]) + self.inertia[i] * np.outer(from_inner[i], from_inner[i])
            f += self.mass[i] * dot(z, self.gravity - b) - self.inertia[i] * alpha * from_inner[i]
        for load in self.scene.loads:
            strength = factor(load, t, within)
            if load.link is not None:
                z, _ = point(load.link, complex(*load.point))
                f += strength * (dot(z, complex(*load.force)) + load.moment * from_inner[load.link])
            if load.joint is not None:
                f[load.joint] += strength * load.torque
        return M, f

    def driven(self, t, q, v, within):
        """q and q̇ with the given angles, and the given accelerations."""
        q, v, a = q.copy(), v.copy(), np.zeros(self.n)
        for i, law in self.drives.items():
            q[i], v[i], a[i] = law.at(t, within)
        return q, v, a

    def solve(self, t, y, within, direction):
        """q̈ and τ. direction[i]: +1, −1: slides so, or has no friction; 0: sticks."""
        q, v, a = self.driven(t, y[:self.n], y[self.n:], within)
        M, f = self.equations(t, q, v, within)
        f = f - self.friction * direction
        given = np.array([i in self.drives or direction[i] == 0 for i in range(self.n)])
        free = ~given
        a[free] = np.linalg.solve(M[np.ix_(free, free)], f[free] - M[np.ix_(free, given)] @ a[given])
        return a, M @ a - f

    # ---- Motion ----------------------------------------------------------------------------------

    def decide(self, t, y, within, direction, resting, forced):
        """Which of the resting joints stick, and where the others go: all combinations are tried. `forced`
        gives some directions. With breakaway > friction several may hold: then what stuck before goes on
        sticking if it can, and so do then the others; a scene in which that does not decide is refused."""
        found = []
        for states in itertools.product((0, 1, -1), repeat=len(resting)):
            trial = list(direction)
            for i, state in zip(resting, states):
                trial[i] = state
            if any(trial[i] != s for i, s in forced.items()):
                continue
            a, tau = self.solve(t, y, within, np.array(trial))
            if all(abs(tau[i]) <= self.breakaway[i] * (1 + 1e-13) if trial[i] == 0 else
                   trial[i] * a[i] > 0 or i in forced for i in resting):
                found.append(trial)
        before = {i for i in resting if direction[i] == 0}
        stuck = lambda trial: {i for i in resting if trial[i] == 0}
        most = max((stuck(trial) & before for trial in found), key=len)
        found = [trial for trial in found if stuck(trial) & before == most]
        (decided,) = [trial for trial in found if all(stuck(trial) >= stuck(other) for other in found)]
        return decided

    def motion(self, duration, steps, log=None):
        """q and q̇ at the end."""
        n = self.n
        y = np.array([link.angle for link in self.scene.links] + [link.velocity for link in self.scene.links])
        rubs = [i for i in range(n) if self.friction[i] > 0]
        direction = [int(math.copysign(1, y[n + i])) if i in rubs else 1 for i in range(n)]
        stops = [0.0, *sorted(t for t in self.edges if 0 < t < duration), float(duration)]
        for start, stop in zip(stops, stops[1:]):
            within = (start + stop) / 2
            t, forced = start, {}
            while t < stop:
                resting = [i for i in rubs if y[n + i] == 0]
                direction = self.decide(t, y, within, direction, resting, forced)
                if log is not None:
                    log.append((t, *(direction[i] for i in rubs)))
                t, y, forced = self.smooth(t, y, stop, within, direction, rubs, steps)
        q, v, _ = self.driven(duration, y[:n], y[n:], within)
        return np.concatenate([q, v])

    def smooth(self, t, y, stop, within, direction, rubs, steps):
        """Integrates to the next change of a direction, or `stop`. Returns time, state, and the direction of a joint
        that breaks loose."""
        n = self.n
        signs = np.array(direction)

        def rates(time, state):
            a, _ = self.solve(time, state, within, signs)
            moves = np.array([i not in self.drives and direction[i] != 0 for i in range(n)])
            return np.concatenate([state[n:] * moves, a * moves])

        def margins(time, state):
            """Negative past the change of each joint with friction."""
            _, tau = self.solve(time, state, within, signs)
            return np.array([direction[i] * state[n + i] if direction[i] else self.breakaway[i] - abs(tau[i])
                             for i in rubs])

        def runner(time, state, end):
            return scipy.integrate.DOP853(rates, time, state, end, rtol=steps[0], atol=steps[0], max_step=steps[1])

        def reach(time, state, end):
            run = runner(time, state, end)
            while run.status == "running":
                run.step()
            return run.y

        run = runner(t, y, stop)
        before = t, y
        while run.status == "running":
            run.step()
            passed = [k for k, margin in enumerate(margins(run.t, run.y)) if margin < 0]
            if passed:
                edge = lambda end, k: (margins(end, reach(*before, end)) if end > before[0] else
                                       margins(*before))[k]
                time, k = min((scipy.optimize.brentq(edge, before[0], run.t, args=(k,), xtol=1e-15, rtol=1e-15), k)
                              for k in passed)
                state, i = reach(*before, time), rubs[k]
                if direction[i]:
                    state[n + i] = 0
                    return time, state, {}
                _, tau = self.solve(time, state, within, signs)
                return time, state, {i: -int(np.sign(tau[i]))}
            before = run.t, run.y
        return stop, run.y, {}

    # ---- Inverse dynamics ------------------------------------------------------------------------

    def torques(self, t, q, v, a):
        M, f = self.equations(t, q, v, t)
        return M @ a - f + self.friction * np.sign(v)

    def torques_of_positions(self, t, q, v, a):
        """torques() with 40 digits from the positions alone, which mpmath differentiates by time and angles."""
        links, loads = self.scene.links, self.scene.loads
        number = mpmath.mpf

        def place(body, point, s, shift):
            """The position of a point at t + s, with angles q_k larger by shift[k]."""
            x, y, angle = (law.value(number(t) + s, t) for law in self.base)
            z = mpmath.mpc(x, y)
            for j in range(body + 1):
                angle += number(q[j]) + number(v[j]) * s + number(a[j]) * s * s / 2 + shift[j]
                z += (self.pin[j] if j < body else point) * mpmath.expj(angle)
            return z, angle

        still = [0] * self.n
        def along(body, point, k, force, moment):
            """force · ∂z/∂q_k + moment ∂θ/∂q_k"""
            shifted = lambda d: place(body, point, 0, [d if j == k else 0 for j in range(self.n)])[0]
            z = mpmath.diff(shifted, 0)
            return z.real * force.real + z.imag * force.imag + (moment if k <= body else 0)

        def torque(k):
            link = links[k]
            result = (number(link.rotor_inertia) * number(a[k]) + number(link.damping) * number(v[k])
                      + number(link.stiffness) * (number(q[k]) - number(link.rest_angle))
                      + number(link.friction) * mpmath.sign(v[k]))
            for i in range(self.n):
                inertial = self.mass[i] * (mpmath.diff(lambda s: place(i, self.com[i], s, still)[0], 0, 2) - self.gravity)
                turning = self.inertia[i] * mpmath.diff(lambda s: place(i, 0, s, still)[1], 0, 2)
                result += along(i, self.com[i], k, inertial, turning)
            for load in loads:
                strength = number(factor(load, t, t))
                if load.link is not None:
                    result -= strength * along(load.link, complex(*load.point), k, mpmath.mpc(*load.force), load.moment)
                if load.joint == k:
                    result -= strength * load.torque
            return result

        with mpmath.workdps(40):
            return np.array([float(torque(k)) for k in range(self.n)])

    # ---- Rest ------------------------------------------------------------------------------------

    def equilibrium(self):
        """Downhill from the initial angles, q̇ = f(q); then by Newton's method. And the least eigenvalue of
        −∂f/∂q, which is positive where it is stable."""
        still = np.zeros(self.n)
        f = lambda q: self.equations(0, q, still, 0)[1]
        q = np.array([link.angle for link in self.scene.links])
        q = scipy.integrate.solve_ivp(lambda _, q: f(q), (0, 100), q, method="Radau", rtol=1e-8, atol=1e-10).y[:, -1]
        q = scipy.optimize.fsolve(f, q, xtol=1e-15)
        step = 1e-6 * np.eye(self.n)
        slope = np.array([(f(q - d) - f(q + d)) / 2e-6 for d in step])
        return q, np.abs(f(q)).max(), np.linalg.eigvalsh((slope + slope.T) / 2)[0]


# ---- Files ---------------------------------------------------------------------------------------

def write(name, rows):
    with open(FOLDER / name, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["scene", "t", "quantity", "index", "value", "uncertainty"])
        writer.writerows(rows)


def of_state(name, t, uncertainty, **quantities):
    return [(name, t, quantity, i, f"{x:.15g}", f"{uncertainty:.1g}")
            for quantity, values in quantities.items() for i, x in enumerate(values)]


def motions():
    for name, duration in DURATIONS.items():
        machine = Machine(scenes.read(FOLDER / f"{name}.yaml"))
        log = []
        y = machine.motion(duration, FINE, log)
        uncertainty = np.abs(y - machine.motion(duration, COARSE)).max()
        print(name, "uncertainty", uncertainty, "directions", *log, sep="\n  ", flush=True)
        assert uncertainty < 1e-10, name
        yield from of_state(name, duration, uncertainty, q=y[:machine.n], qd=y[machine.n:])


def torques():
    draw = random.Random(1)
    for name, times in TORQUES.items():
        machine = Machine(scenes.read(FOLDER / f"{name}.yaml"))
        for t in times:
            q, v, a = np.array([[draw.randint(-192, 192) / 64 for _ in range(machine.n)] for _ in range(3)])
            tau = machine.torques(t, q, v, a)
            uncertainty = np.abs(tau - machine.torques_of_positions(t, q, v, a)).max()
            print(name, t, "uncertainty", uncertainty)
            assert uncertainty < 1e-12 * np.abs(tau).max(), name
            yield from of_state(name, t, uncertainty, q=q, qd=v, qdd=a, tau=tau)


def rest():
    for name in REST:
        machine = Machine(scenes.read(FOLDER / f"{name}.yaml"))
        q, residual, stiffness = machine.equilibrium()
        uncertainty = math.sqrt(machine.n) * residual / stiffness
        print(name, "residual", residual, "least stiffness", stiffness)
        assert stiffness > 0 and uncertainty < 1e-12, name
        yield from of_state(name, 0, uncertainty, q=q)


def main():
    write("rest.csv", rest())
    write("torques.csv", torques())
    write("motions.csv", motions())


if __name__ == "__main__":
    main()
