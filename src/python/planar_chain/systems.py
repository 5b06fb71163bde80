"""A, B, C, D of a chain with inputs and outputs by name: state_space().

Outputs are functions of the base's displacement and q, z = (x, y, φ, q), and of ż and z̈. A small change of z_j turns all outer links
about a pin O, or shifts them along an axis d. So the point P of an outer link has ∂P/∂z_j = G = k̂ × (P − O) or d, and as this holds at all times

    ∂Ṗ/∂z_j = Ġ        ∂P̈/∂z_j = G̈        ∂P̈/∂ż_j = 2 Ġ        ∂Ṗ/∂ż_j = ∂P̈/∂z̈_j = G

What acts is brought to the joints by Jacobians: a force F at P is J_Pᵀ F; a base that accelerates acts on the links with −m a at
their centres of mass, and −I α."""

import difflib
import functools
import math
import warnings

import numpy as np

from planar_chain import equations
from planar_chain._core import _operating_point
from planar_chain.described import described
from planar_chain.user_input import read_number

BASE = "x", "y", "angle"
FORCES = "force_x", "force_y", "moment"
OF_JOINTS = "position", "velocity", "acceleration"
OF_POINTS = {"x": (0, 0), "y": (0, 1), "angle": (0, 2), "velocity_x": (1, 0), "velocity_y": (1, 1), "rate": (1, 2),
             "acceleration_x": (2, 0), "acceleration_y": (2, 1)}  # derivative, and x, y or angle
PIN_FORCES = "pin_force_x", "pin_force_y"
OF_IMUS = "gyro", "accelerometer_x", "accelerometer_y"


def state_space(scene, inputs, outputs, q=None, qd=None, t=0.0, tau=None, friction="acts", motors=False):
    """Returns A, B, C, D of ẋ = A x + B u, y = C x + D u near a state: arrays as scipy.signal and python-control take them.

    q, qd, t, tau, friction, motors: as of linearize(). Torques tau, n or "holding", act at the state.
    x = (δq, δq̇), with motors=True then the torques that lag, in chain order. Behind them are the displacements of the base inputs, then their rates.

    Inputs:
        JOINT                                       torque, N m; force of a prismatic joint, N; with motors=True as commanded
        LINK/force_x, LINK/force_y, LINK/moment     on a link, along the axes of the base, N, N m
        base/x, base/y, base/angle                  acceleration of the base, m/s², rad/s²
    Outputs:
        JOINT/position, …/velocity, …/acceleration  relative
        JOINT/torque                                of a motor that lags, with motors=True
        LINK/x, …/y, …/angle, …/velocity_x, …/velocity_y, …/rate, …/acceleration_x, …/acceleration_y
                                                    of a point, against the ground
        LINK/pin_force_x, LINK/pin_force_y          on the link at its inner pin, N
        SENSOR/JOINT                                of an encoder, without delay and errors
        SENSOR/gyro, SENSOR/accelerometer_x, SENSOR/accelerometer_y    of an IMU, too

    The point of a LINK is its centre of mass. "LINK,0.4,0" is another point, m, in the axes of the link. "tip" is the outer pin of the last
    link. A frame of the scene stands for its point, as in "gripper/x"."""
    plant = Plant(scene, q, qd, t, tau, friction, motors)
    return plant.system([plant.input(f"inputs/{k}", name) for k, name in enumerate(names_of("inputs", inputs))],
                        [plant.output(f"outputs/{k}", name) for k, name in enumerate(names_of("outputs", outputs))])


def names_of(what, given):
    """A list of names, each once."""
    if isinstance(given, str) or not all(isinstance(name, str) for name in given):
        raise ValueError(f"{what}: expected a list of names, got {given!r}")
    for name in given:
        if list(given).count(name) > 1:
            raise ValueError(f"{what}: expected each name once, got {name!r} again")
    return given


def listed(names):
    return ", ".join(names[:12]) + (" …" if len(names) > 12 else "")


def close_to(name, known):
    near = difflib.get_close_matches(name, known, 1)
    return f" (did you mean {near[0]}?)" if near else ""


# ---- Motions: of each quantity the value, first and second derivative ----------------------------


def across(vectors):
    """k̂ × v"""
    return np.stack([-vectors[..., 1], vectors[..., 0]], axis=-1)


def times(s, d):
    """s d with its derivatives. s: 3; d: 3 × 2."""
    return np.array([s[0] * d[0], s[1] * d[0] + s[0] * d[1], s[2] * d[0] + 2 * s[1] * d[1] + s[0] * d[2]])


class Plant:
    """A scene near a state. Gradients of a quantity have rows for z, ż and z̈: 3 × (3 + n)."""

    def __init__(self, scene, q, qd, t, tau, friction, motors):
        self.scene, self.n, self.tree = scene, len(scene), scene.to_dict()
        at = equations(scene, q, qd, t)
        (A, B), _, qdd = _operating_point(scene, at["q"], at["qd"], tau, friction, t, motors)
        self.A, self.commanded = A[self.n:], B[self.n:]  # of q̈, and of torques that lag
        self.acting = self.commanded                     # by torques that act
        self.lags = []                                   # joints whose torques lag
        if motors:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                (_, B), *_ = _operating_point(scene, at["q"], at["qd"], tau, friction, t, False)
            self.acting = np.zeros_like(self.commanded)
            self.acting[:self.n] = B[self.n:]
            joints = [link["joint"] for link in described(scene)["links"]]
            self.lags = [joint["name"] for joint in joints if joint.get("motor", {}).get("time_constant")]
        self.state = {"q": at["q"], "qd": at["qd"], "qdd": qdd, "t": t}
        self.ways = self._ways()

    def _ways(self):
        """For the base's angle and each joint, the first link that it moves; O or None; d or None."""
        origins = [self.motion(i, [0, 0])[..., :2] for i in range(self.n)]
        ways = []
        for i, (is_prismatic, axis) in enumerate(zip(self.scene.prismatic, self.scene.axes)):
            along = self.motion(i, axis)[..., :2] - origins[i]
            ways.append((i, None, along) if is_prismatic else (i, origins[i], None))
        q = [self.state[name][0] for name in ("q", "qd", "qdd")]
        ground = origins[0] - (times(q, ways[0][2]) if self.scene.prismatic[0] else 0)
        return [(0, ground, None), *ways]

    def motion(self, link, point=None):
        """x, y and angle of a point or a frame: 3 × 3."""
        of = self.scene.motion(link, point, **self.state)
        return np.array([[*of.position, of.angle], [*of.velocity, of.rate], [*of.acceleration, of.angular_acceleration]])

    def at(self, link, *place):
        """The motion of a point of a link or of a frame on it; and its G of x, y, angle, with derivatives: 3 × 3 × (3 + n)."""
        motion = self.motion(*(place or (link,)))
        G = np.zeros((3, 3, self.n + 3))
        G[0, 0, 0] = G[0, 1, 1] = 1
        for j, (first, origin, along) in enumerate(self.ways, 2):
            if first <= link:
                G[:, :2, j] = across(motion[:, :2] - origin) if along is None else along
                G[0, 2, j] = along is None
        return motion, G

    @staticmethod
    def gradient(G, order, axis):
        """The gradients of a derivative of x, y or angle."""
        return np.array([math.comb(order, k) * G[order - k, axis] if k <= order else 0 * G[0, axis] for k in range(3)])

    @functools.cached_property
    def inertia(self):
        """For each link m, m and I; the gradients of its acceleration, x, y, angle."""
        return [(np.array([m, m, I]), np.array([self.gradient(self.at(link, link, com)[1], 2, axis) for axis in range(3)]))
                for link, (m, I, com) in enumerate(zip(self.scene.masses, self.scene.inertias, self.scene.coms))]

    # ---- Names

    def point(self, path, name):
        """Link and place, as of at(), of "LINK", "LINK,x,y", a frame or "tip"."""
        link, *given = name.split(",")
        links, frames = self.scene.links, self.tree.get("frames", {})
        if name in frames:
            return links.index(frames[name]["link"]), name
        if name == "tip" and name not in links:
            return self.n - 1, name
        if link not in links:
            known = [*links, *self.scene.joints, *self.sensors, *frames]
            raise ValueError(f"{path}: expected a name of {listed([*known, 'tip'])}, got {link!r}" + close_to(link, known))
        k = links.index(link)
        if not given:
            return k, k, self.scene.coms[k]
        try:
            point = [read_number(number) for number in given]
        except ValueError:
            point = []
        if len(point) != 2 or not np.isfinite(point).all():
            raise ValueError(f'{path}: expected a point as in "{link},0.4,0", got {name!r}')
        return k, k, point

    @property
    def sensors(self):
        return self.tree.get("sensors", {})

    def refuse_beside(self, path, keys):
        """Raises ValueError if the scene has one of these keys, whose forces depend on what the names' formulas do not know."""
        there = {key for key in keys if key in self.tree}
        if "drag" in keys and any(isinstance(link, dict) and "drag" in link for link in self.tree.get("links", {}).values()):
            there.add("links/…/drag")
        if "loads" in there and not any("link" in load for load in self.tree["loads"].values()):
            there.remove("loads")
        if "base" in there and "angle" not in self.tree["base"]:
            there.remove("base")
        if there:
            raise ValueError(f"{path}: expected none beside {' and '.join(sorted(there))} of the scene, got one")

    def input(self, path, name):
        """What a unit of it adds to q̈, and to the rates of torques that lag; its base coordinate or None; (link, x, y) of its force or
        None."""
        if name in self.scene.joints:
            return self.commanded[:, self.scene.joints.index(name)], None, None
        thing, _, what = name.rpartition("/")
        if thing == "base" and what in BASE:
            axis = BASE.index(what)
            self.refuse_beside(path, ["base", "drag", "springs", "tip"] + ["loads"] * (axis == 2))
            return self.acting @ self.carried(2, axis), axis, None
        if what not in FORCES:
            known = [*self.scene.joints, *("base/" + axis for axis in BASE)]
            raise ValueError(f"{path}: expected a joint, base/x, base/y, base/angle, or a link with /force_x, /force_y or /moment, "
                             f"got {name!r}{close_to(name, known)}")
        link, *place = self.point(path, thing)
        axis = FORCES.index(what)
        return self.acting @ self.at(link, *place)[1][0, axis, 3:], None, (link, *np.eye(3)[axis, :2])

    def output(self, path, name):
        """Its gradients, and the link whose pin force it is or None, with the axis."""
        thing, _, what = name.rpartition("/")
        if thing in self.scene.joints and what in OF_JOINTS:
            gradient = np.zeros((3, self.n + 3))
            gradient[OF_JOINTS.index(what), 3 + self.scene.joints.index(thing)] = 1
            return gradient, None
        if what == "torque" and thing in self.scene.joints:
            if thing not in self.lags:
                raise ValueError(f"{path}: expected a joint whose motor lags, with motors=True, got {name!r}")
            return np.eye(3)[:, :1] * (np.arange(self.n + 3 + len(self.lags)) == self.n + 3 + self.lags.index(thing)), None
        if thing in self.sensors:
            return self.measured(path, name, thing, what), None
        if what not in (*OF_POINTS, *PIN_FORCES):
            raise ValueError(f"{path}: expected NAME/ and one of {', '.join((*OF_JOINTS, *OF_POINTS, *PIN_FORCES))}, got {name!r}"
                             + close_to(what, [*OF_JOINTS, *OF_POINTS, *PIN_FORCES]))
        self.refuse_beside(path, ["base"])
        link, *place = self.point(path, thing)
        if what in OF_POINTS:
            return self.gradient(self.at(link, *place)[1], *OF_POINTS[what]), None
        self.refuse_beside(path, ["drag", "springs", "tip"])
        axis = PIN_FORCES.index(what)
        return sum(I[axis] * a[axis] for I, a in self.inertia[link:]), (link, axis)

    def measured(self, path, name, sensor, what):
        about = self.sensors[sensor]
        joints = about.get("joints", [])
        joints = self.scene.joints if joints == "all" else joints
        if what in joints:
            return self.output(path, what + "/position")[0]
        if "link" not in about or what not in OF_IMUS:
            raise ValueError(f"{path}: expected {sensor}/ and one of {listed(OF_IMUS if 'link' in about else joints)}, got {name!r}")
        self.refuse_beside(path, ["base"])
        link = self.scene.links.index(about["link"])
        motion, G = self.at(link, link, about.get("point", (0, 0)))
        if what == "gyro":
            return self.gradient(G, 1, 2)
        angle = motion[0, 2] + about.get("angle", 0.0)
        axis = np.array([np.cos(angle), np.sin(angle)])
        axis = axis if what == "accelerometer_x" else across(axis)
        force = motion[2, :2] - self.scene.gravity  # per mass
        return sum(axis[k] * self.gradient(G, 2, k) for k in range(2)) + across(axis) @ force * self.gradient(G, 0, 2)

    # ---- The system

    def system(self, inputs, outputs):
        """A, B, C, D of what input() and output() return. Behind z, gradients may have columns of the torques that lag."""
        n, m = self.n, self.n + len(self.A)
        bases = [axis for _, axis, _ in inputs if axis is not None]
        moved, size = m + len(bases), m + 2 * len(bases)
        # z, ż and z̈ of x and of u.
        of_x, of_u = np.zeros((3, n + 3 + m - 2 * n, size)), np.zeros((3, n + 3, len(inputs)))
        A, B = np.zeros((size, size)), np.zeros((size, len(inputs)))
        A[:n, n:2 * n] = np.eye(n)
        A[n:m, :m] = self.A
        for k, axis in enumerate(bases):
            of_x[0, axis, m + k] = of_x[1, axis, moved + k] = A[m + k, moved + k] = 1
            A[n:m, m + k], A[n:m, moved + k] = self.acting @ self.weight(axis), self.acting @ self.carried(1, axis)
        for k, (column, axis, _) in enumerate(inputs):
            B[n:m, k] = column
            if axis is not None:
                of_u[2, axis, k] = B[moved + bases.index(axis), k] = 1
        of_x[0, 3:n + 3, :n] = of_x[1, 3:n + 3, n:2 * n] = np.eye(n)
        of_x[2, 3:n + 3], of_u[2, 3:] = A[n:2 * n], B[n:2 * n]
        of_x[0, n + 3:, 2 * n:m] = np.eye(m - 2 * n)
        C = np.array([np.tensordot(gradient, of_x[:, :gradient.shape[1]]) for gradient, _ in outputs]).reshape(len(outputs), size)
        D = np.array([np.tensordot(gradient[:, :n + 3], of_u) for gradient, _ in outputs]).reshape(len(outputs), len(inputs))
        for i, (_, pin) in enumerate(outputs):
            for j, (_, _, force) in enumerate(inputs):
                if pin and force and force[0] >= pin[0]:
                    D[i, j] -= force[1 + pin[1]]
        return A, B, C, D

    def carried(self, order, axis):
        """The torques of the inertia of a base that moves: by a unit of its velocity (1) or acceleration (2)."""
        return -sum(I @ (a[:, 2, 3:] * a[:, order, axis:axis + 1]) for I, a in self.inertia)

    def weight(self, axis):
        """The torques of weights by which a base that is displaced changes those in the joints: only if it turns."""
        if axis < 2:
            return np.zeros(self.n)
        x, y = self.scene.gravity
        return sum(I[0] * (x * -a[1, 2, 3:] + y * a[0, 2, 3:]) for I, a in self.inertia)
