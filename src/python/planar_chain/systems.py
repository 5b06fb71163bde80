"""A, B, C, D of a chain with inputs and outputs by name: state_space().

Outputs are functions of the base's displacement and q, z = (x, y, φ, q), and of ż and z̈. Their gradients are complex steps, exact to
rounding, all directions at once. What acts is brought to the joints by Jacobians: a force F at P is J_Pᵀ F; a base that
accelerates acts on the links with −m a at their centres of mass, and −I α."""

import difflib
import functools

import numpy as np

from planar_chain import equations, linearize
from planar_chain.user_input import read_number

STEP = 1e-30   # of complex steps
BASE = "x", "y", "angle"
FORCES = "force_x", "force_y", "moment"
OF_JOINTS = "position", "velocity", "acceleration"
OF_POINTS = {"x": (0, 0), "y": (0, 1), "angle": (0, 2), "velocity_x": (1, 0), "velocity_y": (1, 1), "rate": (1, 2),
             "acceleration_x": (2, 0), "acceleration_y": (2, 1)}  # derivative, and x, y or angle
PIN_FORCES = "pin_force_x", "pin_force_y"
OF_IMUS = "gyro", "accelerometer_x", "accelerometer_y"


def state_space(scene, inputs, outputs, q=None, qd=None, t=0.0):
    """Returns A, B, C, D of ẋ = A x + B u, y = C x + D u near a state: arrays as scipy.signal and python-control take them.

    x = (δq, δq̇), then for each base input the displacement of the base and its rate. Default state: as of linearize().

    inputs     "JOINT": torque, N m (prismatic: N). "LINK/force_x", "LINK/force_y", "LINK/moment": on a link, N, N m.
               "base/x", "base/y", "base/angle": acceleration of the base, m/s², rad/s²
    outputs    "JOINT/position", "…/velocity", "…/acceleration". "LINK/x", "…/y", "…/angle", "…/velocity_x", "…/velocity_y", "…/rate",
               "…/acceleration_x", "…/acceleration_y": against the ground. "LINK/pin_force_x", "…_y": on the link at its inner pin.
               "SENSOR/JOINT" of an encoder; "SENSOR/gyro", "…/accelerometer_x", "…/accelerometer_y", without delays and errors

    A LINK's point is its centre of mass. "LINK,0.4,0" is another one, in the axes of the link; "tip" the outer pin of the last link."""
    plant = Plant(scene, q, qd, t)
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


def turned(angle, vector):
    """A vector that turns with an angle. angle: 3 × directions; returns 3 × directions × 2."""
    theta, omega, alpha = (part[..., np.newaxis] for part in angle)
    x, y = vector
    c, s = np.cos(theta[..., 0]), np.sin(theta[..., 0])
    along = np.stack([c * x - s * y, s * x + c * y], axis=-1)
    across = np.stack([-along[..., 1], along[..., 0]], axis=-1)
    return np.stack([along, omega * across, alpha * across - omega ** 2 * along])


def times(s, d):
    """s d with its derivatives."""
    s = s[..., np.newaxis]
    return np.stack([s[0] * d[0], s[1] * d[0] + s[0] * d[1], s[2] * d[0] + 2 * s[1] * d[1] + s[0] * d[2]])


def link_frames(scene, z):
    """Yields origin and angle of each link. z: 3 × directions × (3 + n)."""
    place, angle = z[..., :2], z[..., 2]
    for i, (is_prismatic, axis, pin) in enumerate(zip(scene.prismatic, scene.axes, scene.pins), 3):
        if is_prismatic:
            place = place + times(z[..., i], turned(angle, axis))
        else:
            angle = angle + z[..., i]
        yield place, angle
        place = place + turned(angle, pin)


class Plant:
    """A scene near a state. Gradients of a quantity have rows for z, ż and z̈: 3 × (3 + n)."""

    def __init__(self, scene, q, qd, t):
        self.scene, self.n, self.tree = scene, len(scene), scene.to_dict()
        at = equations(scene, q, qd, t)
        A, B = linearize(scene, at["q"], at["qd"], t=t)
        self.A, self.B = A[self.n:], B[self.n:]  # of q̈
        rotation = at["S"][0]
        base_angle = np.arctan2(rotation[0, 1], rotation[0, 0]) - (0 if scene.prismatic[0] else at["q"][0])
        z = np.array([[0, 0, base_angle, *at["q"]], [0, 0, 0, *at["qd"]], [0, 0, 0, *at["qdd"]]])
        steps = np.eye(z.size).reshape(z.size, *z.shape).swapaxes(0, 1)
        self.frames = list(link_frames(scene, z[:, np.newaxis] + 1j * STEP * steps))

    def gradient(self, values):
        return (np.imag(values) / STEP).reshape(3, self.n + 3)

    def at(self, link, point):
        """x, y and angle of a point: 3 × directions × 3."""
        place, angle = self.frames[link]
        return np.concatenate([place + turned(angle, point), angle[..., np.newaxis]], axis=-1)

    def jacobian(self, link, point):
        """Of x, y, angle: 3 × (3 + n)."""
        return np.array([self.gradient(values)[0] for values in self.at(link, point)[0].T])

    @functools.cached_property
    def inertia(self):
        """Of each link: m, m and I; the gradients of its acceleration, x, y, angle."""
        return [(np.array([m, m, I]), np.array([self.gradient(values) for values in self.at(link, com)[2].T]))
                for link, (m, I, com) in enumerate(zip(self.scene.masses, self.scene.inertias, self.scene.coms))]

    # ---- Names

    def point(self, path, name):
        """Link and point of "LINK", "LINK,x,y" or "tip"."""
        link, *given = name.split(",")
        links = self.scene.links
        if name == "tip" and name not in links:
            return self.n - 1, self.scene.pins[-1]
        if link not in links:
            raise ValueError(f"{path}: expected a name of {listed([*links, *self.scene.joints, *self.sensors, 'tip'])}, got {link!r}"
                             + close_to(link, [*links, *self.scene.joints, *self.sensors]))
        k = links.index(link)
        if not given:
            return k, self.scene.coms[k]
        try:
            point = [read_number(number) for number in given]
        except ValueError:
            point = []
        if len(point) != 2 or not np.isfinite(point).all():
            raise ValueError(f'{path}: expected a point as in "{link},0.4,0", got {name!r}')
        return k, point

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
        """What a unit of it adds to the torques, n; its base coordinate or None; (link, x, y) of its force or None."""
        if name in self.scene.joints:
            return np.eye(self.n)[self.scene.joints.index(name)], None, None
        thing, _, what = name.rpartition("/")
        if thing == "base" and what in BASE:
            axis = BASE.index(what)
            self.refuse_beside(path, ["base", "drag", "springs", "tip"] + ["loads"] * (axis == 2))
            return self.carried(2, axis), axis, None
        if what not in FORCES:
            known = [*self.scene.joints, *("base/" + axis for axis in BASE)]
            raise ValueError(f"{path}: expected a joint, base/x, base/y, base/angle, or a link with /force_x, /force_y or /moment, "
                             f"got {name!r}{close_to(name, known)}")
        link, point = self.point(path, thing)
        axis = FORCES.index(what)
        return self.jacobian(link, point)[axis, 3:], None, (link, *np.eye(3)[axis, :2])

    def output(self, path, name):
        """Its gradients, and the link whose pin force it is or None, with the axis."""
        thing, _, what = name.rpartition("/")
        if thing in self.scene.joints and what in OF_JOINTS:
            gradient = np.zeros((3, self.n + 3))
            gradient[OF_JOINTS.index(what), 3 + self.scene.joints.index(thing)] = 1
            return gradient, None
        if thing in self.sensors:
            return self.measured(path, name, thing, what), None
        if what not in (*OF_POINTS, *PIN_FORCES):
            raise ValueError(f"{path}: expected NAME/ and one of {', '.join((*OF_JOINTS, *OF_POINTS, *PIN_FORCES))}, got {name!r}"
                             + close_to(what, [*OF_JOINTS, *OF_POINTS, *PIN_FORCES]))
        self.refuse_beside(path, ["base"])
        link, point = self.point(path, thing)
        if what in OF_POINTS:
            order, axis = OF_POINTS[what]
            return self.gradient(self.at(link, point)[order, :, axis]), None
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
        at = self.at(self.scene.links.index(about["link"]), about.get("point", (0, 0)))
        if what == "gyro":
            return self.gradient(at[1, :, 2])
        angle = at[0, :, 2] + about.get("angle", 0.0)
        axes = {"accelerometer_x": (np.cos(angle), np.sin(angle)), "accelerometer_y": (-np.sin(angle), np.cos(angle))}
        return self.gradient(sum((at[2, :, k] - self.scene.gravity[k]) * axes[what][k] for k in range(2)))

    # ---- The system

    def system(self, inputs, outputs):
        """A, B, C, D of what input() and output() return."""
        n = self.n
        bases = [axis for _, axis, _ in inputs if axis is not None]
        size = 2 * n + 2 * len(bases)
        # z, ż and z̈ of x and of u.
        of_x, of_u = np.zeros((3, n + 3, size)), np.zeros((3, n + 3, len(inputs)))
        of_x[0, 3:, :n] = of_x[1, 3:, n:2 * n] = np.eye(n)
        of_x[2, 3:, :2 * n] = self.A
        for k, axis in enumerate(bases):
            of_x[0, axis, 2 * n + k] = of_x[1, axis, 2 * n + len(bases) + k] = 1
            of_x[2, 3:, 2 * n + k] = self.B @ self.weight(axis)
            of_x[2, 3:, 2 * n + len(bases) + k] = self.B @ self.carried(1, axis)
        for k, (torques, axis, _) in enumerate(inputs):
            of_u[2, 3:, k] = self.B @ torques
            if axis is not None:
                of_u[2, axis, k] = 1
        A, B = np.zeros((size, size)), np.zeros((size, len(inputs)))
        A[:n], A[n:2 * n], B[n:2 * n] = of_x[1, 3:], of_x[2, 3:], of_u[2, 3:]
        for k, axis in enumerate(bases):
            A[2 * n + k] = of_x[1, axis]
            B[2 * n + len(bases) + k] = of_u[2, axis]
        C = np.array([np.tensordot(gradient, of_x) for gradient, _ in outputs]).reshape(len(outputs), size)
        D = np.array([np.tensordot(gradient, of_u) for gradient, _ in outputs]).reshape(len(outputs), len(inputs))
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
