#!/usr/bin/python3
"""Random machines with everything at once, by four methods against each other and against formulas of this test.

    differential_test.py BIN [COUNT [FIRST]]     BIN is not used; PYTHONPATH finds planar_chain. By hand: COUNT seeds

fuzz/machines.py makes the machines: prismatic joints anywhere, held tips, moving bases, friction, stops, drag, motors, drives,
loads, springs, commands. Each is checked for

- motion       four methods agree, within the tolerance times the growth of errors, which is measured as in chaos_test.py
- sticking     a stuck joint bears at most its breakaway torque; a sliding one has its friction
- energy       kinetic and potential energy, and the works of loads, motors, drives, base, tip, dampers, drag, stops and
               friction, by numpy from the links' motions; the works by Simpson's rule
- closure      a held tip is at its place, by this test's kinematics
- observing    a simulation that is queried at each sample goes through the same states, bit for bit, as one that is not
"""
import concurrent.futures
import copy
import os
import random
import sys
import warnings

try:
    import numpy as np
except ImportError:
    print("numpy not found: skipped")
    sys.exit(77)

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../fuzz"))
from machines import everything  # noqa: E402
from planar_chain import Failed, Scene, Simulation  # noqa: E402

METHODS = ("auto", "dop853", "rodas5p", "radau13")
SEEDS = [*range(200), 295, 791, 935, 3951, 2049]  # in CI; four in which a joint once stuck for good; the base's moment beside a tip
END = 0.75                # s
SAMPLES = 192, 1536, 12288  # multiples of 4; more where an impact is shorter. Commands start at samples
TIMES = np.linspace(0, END, 9)
AGREED = 1000             # tolerances: what a motion without chaos keeps
BLUR, CHANGES = 30, 4     # as in chaos_test.py
SINGULAR = 1e-4           # closure margin: nearer to a stretched pose, errors grow without bound
G = np.array([0, -9.81])


# ---- Formulas of this test -----------------------------------------------------------------------

def perp(v):
    return np.array([-v[1], v[0]])


def turned(angle, v):
    return np.cos(angle) * np.array(v) + np.sin(angle) * perp(v)


def sine(law, t):
    """Value and rate of a law."""
    w = 2 * np.pi * law.get("frequency", 0)
    angle, size = w * t + law.get("phase", 0), law.get("amplitude", 0)
    return law.get("offset", 0) + size * np.sin(angle), size * w * np.cos(angle)


def factor(load, t):
    if not load.get("start", 0) <= t < load.get("stop", np.inf):
        return 0.0
    if "times" in load:
        return np.interp(t, load["times"], load["values"])
    return np.sin(2 * np.pi * load["frequency"] * t) if "frequency" in load else 1.0


def motor_torque(joint, given, t, rate):
    """The torque of a motor at t from torques that are given at times, in order."""
    delay, lag = joint.get("command_delay", 0), joint.get("motor", {}).get("time_constant", 0)
    limit, speed = joint["effort_limit"], joint.get("motor", {}).get("no_load_speed", np.inf)
    x = u = since = 0.0
    for start, torque in [(start + delay, torque) for start, torque in given if start + delay <= t] + [(t, None)]:
        x = u + (x - u) * (np.exp(-(start - since) / lag) if lag > 0 else 0)
        since, u = start, u if torque is None else np.clip(torque, -limit, limit)
    x = x if lag > 0 else u
    side = np.sign(x)
    return side * min(side * x, max(0.0, limit * (1 - side * rate / speed)))


class Joint:
    """The torque in a joint without friction, drives and motors, its dissipated power and its energy."""

    def __init__(self, made, q, rate):
        self.spring = made.get("stiffness", 0) * (q - made.get("rest_angle", 0))
        self.damper = made.get("damping", 0) * rate + made.get("drag", 0) * abs(rate) * rate
        self.stop = self.in_stop = 0.0
        if "upper" in made:
            side = 1 if q > made["upper"] else -1
            depth = max(q - made["upper"], made["lower"] - q, 0)
            self.in_stop = side * made["stop_stiffness"] * depth
            self.stop = side * max(0.0, side * self.in_stop + made["stop_damping"] * side * rate) if depth > 0 else 0.0
        self.torque = -self.spring - self.damper - self.stop
        self.dissipated = (self.damper + self.stop - self.in_stop) * rate
        self.stored = self.spring ** 2 / 2 / made["stiffness"] if self.spring else 0.0
        self.stored += self.in_stop ** 2 / 2 / made["stop_stiffness"] if self.in_stop else 0.0


class Sample:
    """Energies and powers of a simulation at its present state, and what is wrong with it."""

    def __init__(self, machine, simulation, commands):
        scene, t, self.wrong = machine, simulation.time, []
        q, rates, tau = simulation.q, simulation.qd, simulation.joint_torques()
        motions, wrench, tip = simulation.link_motions(), simulation.base_wrench(), np.array(simulation.tip_force())
        base = {axis: sine(scene.get("base", {}).get(axis, {}), t) for axis in ("x", "y", "angle")}
        self.supplied = -sum(force * base[axis][1] for force, axis in zip(wrench, ("x", "y", "angle")))
        self.energy = self.dissipated = 0.0
        for i, name in enumerate(scene["chain"]):
            link, body = scene["links"][name], motions[i]
            made, v = link["joint"], body["velocity"]
            self.energy += link["mass"] * (v @ v / 2 - G @ body["com"]) + link["inertia"] * body["omega"] ** 2 / 2
            self.energy += made.get("rotor_inertia", 0) * rates[i] ** 2 / 2
            for force, point in self.forces(scene, name, commands, t):
                arm = turned(body["angle"], np.array(point or link["com"]) - link["com"])
                self.supplied += force @ (v + body["omega"] * perp(arm))
            if "drive" in made:
                self.supplied += tau[i] * rates[i]
                continue
            own = Joint(made, q[i], rates[i])
            self.energy += own.stored
            friction = tau[i] - own.torque
            if "effort_limit" in made:
                motor = motor_torque(made, [(s, u) for s, joint, u in commands if joint == name + "_joint"], t, rates[i])
                self.supplied += motor * rates[i]
                friction -= motor
            self.dissipated += own.dissipated + made.get("friction", 0) * abs(rates[i])
            self.judge(name, made, rates[i], friction, abs(tau[i]) + abs(own.torque))
        if "tip" in scene:
            self.close(scene["tip"], simulation, turned(motions[-1]["angle"], link["pin"]) + motions[-1]["inner_pin"], tip)

    @staticmethod
    def forces(scene, name, commands, t):
        """Force and point of each that acts on a link."""
        for load in scene["loads"].values():
            if load["link"] == name:
                yield factor(load, t) * np.array(load["force"]), load.get("point")
        held = [force for start, link, force in commands if link == name and start <= t]
        if held:
            yield np.array(held[-1]), None

    def judge(self, name, made, rate, friction, size):
        """friction: the torque that remains for it."""
        rounding = 1e-9 * (1 + size)
        sliding, sticking = made.get("friction", 0), made.get("breakaway", made.get("friction", 0))
        if rate == 0:
            if abs(friction) > 1.001 * sticking + rounding:
                self.wrong.append(f"{name} sticks under {friction:.3g} N m with a breakaway of {sticking:.3g}")
        elif abs(rate) > 1e-6 and abs(friction + np.sign(rate) * sliding) > rounding:
            self.wrong.append(f"{name} slides at {rate:.3g} under {friction:.3g} N m with a friction of {sliding:.3g}")

    def close(self, held, simulation, place, force):
        t = simulation.time
        if "line" in held:
            normal = perp(np.array(held["line"]["direction"]) / np.hypot(*held["line"]["direction"]))
            gap = abs(normal @ (place - held["line"]["point"]))
        else:
            gap = max(abs(place[k] - sine(held["pin"][axis], t)[0]) for k, axis in enumerate("xy"))
            self.supplied += sum(force[k] * sine(held["pin"][axis], t)[1] for k, axis in enumerate("xy"))
        if gap > 1e-11 or simulation.closure_error() > 1e-11:
            self.wrong.append(f"the tip is {gap:.1e} m from its place")


# ---- Motions -------------------------------------------------------------------------------------

def give(simulation, commands):
    """Gives the commands of the present time."""
    for start, what, value in commands:
        if start == simulation.time:
            simulation.hold_force(what, value) if isinstance(value, list) else simulation.hold_torque(what, value)


def motion(machine, commands, times, queried=None):
    """The states at times, and why there are no more, unless a stretched pose ends it. queried(simulation): called at each."""
    simulation = Simulation(Scene(machine), commands=100)
    states = []
    starts = [command[0] for command in commands]
    for t in sorted({*times, *starts}):
        try:
            simulation.advance_to(t, most_steps=200000)
        except Failed as failed:
            return np.array(states), str(failed)[:100] if simulation.closure_margin() > SINGULAR else None
        if t in times:
            states.append(simulation.state)
        give(simulation, commands)
        if queried and t in times:
            queried(simulation)
    return np.array(states), None


def apart(a, b):
    """How far two motions are apart at each time, up to then."""
    return np.maximum.accumulate((abs(a - b) / np.maximum(1, abs(a))).max(axis=1))


def effect(machine, commands, ours, seed):
    """The effect of errors of the tolerance's size at the start, at each time."""
    chance, most = random.Random(seed), np.zeros(len(ours))
    for _ in range(CHANGES):
        other = copy.deepcopy(machine)
        for link in other["links"].values():
            for key in link.get("initial", {}):
                link["initial"][key] += machine["integrator"]["tolerance"] * chance.choice((-1, 1))
        theirs, _ = motion(other, commands, TIMES)
        most[:len(theirs)] = np.maximum(most[:len(theirs)], apart(ours[:len(theirs)], theirs))
        most[len(theirs):] = np.inf
    return most


def balance_faults(samples, h, tolerance):
    """Checks energies and works by Simpson's rule, with half the samples too. The difference bounds the error."""
    wrong, balances = [], [sample.balance for sample in samples]
    energy = np.array([sample.energy for sample in samples])
    off = abs(energy - [balance.now.total for balance in balances]) / (1 + abs(energy))
    if off.max() > 1e-10:
        wrong.append(f"kinetic and potential energy are {off.max():.1e} apart")
    size = 1 + abs(energy).max()
    for key in ("supplied", "dissipated"):
        power = np.array([getattr(sample, key) for sample in samples])
        p = np.array([power[k::4][:len(power) // 4] for k in range(5)])
        fine = h / 3 * (p[0] + 4 * p[1] + 2 * p[2] + 4 * p[3] + p[4])
        coarse = 2 * h / 3 * (p[0] + 4 * p[2] + p[4])
        size += abs(fine).sum()
        error = 4 * np.cumsum(abs(fine - coarse)) + 1e-6 * size
        off = abs(np.cumsum(fine) - [getattr(balance, key) for balance in balances[4::4]]) - error
        if off.max() > 0:
            wrong.append(f"energy {key}: {off.max():.1e} J off, beside the quadrature's error, of {size:.1e} J")
    residual = max(abs(balance.residual) for balance in balances)
    if residual > AGREED * tolerance * size:
        wrong.append(f"the balance leaves {residual:.1e} of {size:.1e} J")
    return wrong


# ---- A machine -----------------------------------------------------------------------------------

def query(machine, simulation, commands):
    sample = Sample(machine, simulation, commands)
    sample.balance = simulation.energy_balance()
    sample.wrong = [f"t = {simulation.time:.4f} s: {one}" for one in sample.wrong]
    return sample


def observed(machine, commands):
    """What is wrong with a motion that is queried at each sample."""
    for count in SAMPLES:
        times, samples = np.linspace(0, END, count + 1), []
        states, _ = motion(machine, commands, times, lambda of: samples.append(query(machine, of, commands)))
        wrong = [one for sample in samples for one in sample.wrong][:1]
        off = []
        if len(samples) == len(times):  # before a stretched pose no samples are close enough
            off = balance_faults(samples, times[1], machine["integrator"]["tolerance"])
        alone, _ = motion(machine, commands, times)
        if states.shape != alone.shape or (states != alone).any():
            wrong.append("queries change the motion")
        if wrong or not off:
            return wrong
    return off


def faults(seed):
    machine, commands = everything(seed)
    chance = random.Random(seed)
    tolerance = 10.0 ** -chance.choice((6, 7, 8, 9))
    found, motions = [], {}
    for method in METHODS:
        machine["integrator"] = {"method": method, "tolerance": tolerance}
        times, samples = sorted({*TIMES, *(chance.uniform(0, END) for _ in range(3))}), []
        states, reason = motion(machine, commands, times, lambda of: samples.append(query(machine, of, commands)))
        motions[method] = np.array([state for t, state in zip(times, states) if t in TIMES])
        found += [f"{method}, {one}" for sample in samples for one in sample.wrong][:1]
        if reason:
            found.append(f"{method}: {reason}")
    machine["integrator"] = {"method": chance.choice(METHODS), "tolerance": tolerance}
    found += [f"{machine['integrator']['method']}, {one}" for one in observed(machine, commands)]

    machine["integrator"] = {"method": "auto", "tolerance": tolerance}
    for method, theirs in motions.items():
        ours = motions["auto"][:len(theirs)]
        difference = apart(ours, theirs[:len(ours)])
        allowed = AGREED * tolerance
        if (difference > allowed).any():
            allowed = np.maximum(allowed, BLUR * effect(machine, commands, ours, seed))
        if (difference > allowed).any():
            k = int(np.argmax(difference > allowed))
            found.append(f"{method} and auto are {difference[k]:.1e} apart at t = {TIMES[k]:.2f} s, {allowed[k]:.1e} allowed")
    return [f"seed {seed}, {tolerance}: {one}" for one in found]


def main():
    if not 2 <= len(sys.argv) <= 4:
        sys.exit(__doc__)
    warnings.simplefilter("ignore")  # notes on the scenes
    count, first = (int(number) for number in (sys.argv[2:] + [0, 0])[:2])
    seeds, found = range(first, first + count) if count else SEEDS, 0
    with concurrent.futures.ProcessPoolExecutor(os.cpu_count() if count else 1) as pool:
        for lines in pool.map(faults, seeds):
            found += len(lines) > 0
            for line in lines:
                print(line, flush=True)
    print(f"{found} of {len(seeds)} machines are wrong")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
