"""What is drawn of a chain, and where it is at given states. Points of the plane are complex numbers, x + iy, in m."""

import numpy as np

ASIDE = 0.02  # in units of the reach; a centre of mass further from its link gets a line of its own


def complex_of(pairs):
    return np.array([complex(*pair) for pair in pairs], dtype=complex)


class Body:
    """chain: of a scene, as `equations --chain` prints it.

    names, joints: of links and joints. pin, com: of each link. axis: of a prismatic joint in the frame of the link before; 0 of others.
    leading: how many prismatic joints are first. carts: the same, or 0 for a free chain. inner: the prismatic joints further on.
    limits: lower and upper ones, m, NaN if there is none. moves: the base does. pinned: the tip is. reach: of the stretched chain, m.
    aside: links whose centre of mass does not lie on the line from pin to pin. stiff: joints with springs.
    springs: those to the ground. loads: dicts with the keys of a scene. frames: link and point of each, by name."""

    def __init__(self, chain):
        links = chain["links"]
        joints = [link["joint"] for link in links]
        self.names, self.joints = [link["name"] for link in links], [joint["name"] for joint in joints]
        self.moves, self.pinned = "base" in chain, "pin" in chain.get("tip", ())
        self.axis = complex_of([joint.get("axis", (0, 0)) for joint in joints])
        self.leading = int(np.argmax(np.append(self.axis, 0) == 0))
        self.inner = np.flatnonzero(self.axis[self.leading:]) + self.leading
        self.limits = np.array([[joint.get(key) for key in ("lower", "upper")] for joint in joints], dtype=float)
        is_free = self.names[:2] == [name + axis for name in self.names[2:3] for axis in ("_x", "_y")]
        self.carts = 0 if is_free else self.leading
        self.pin, self.com = (complex_of([link[key] for link in links]) for key in ("pin", "com"))
        self.reach = np.sum(abs(self.pin)) or 1.0
        along = np.clip((self.com * self.pin.conj()).real / np.maximum(abs(self.pin) ** 2, 1e-300), 0, 1)
        self.aside = np.flatnonzero(abs(self.com - along * self.pin) > ASIDE * self.reach)
        self.stiff = np.flatnonzero([joint.get("stiffness", 0) for joint in joints])
        self.springs = Springs(list(chain.get("springs", {}).values()), self.names)
        self.loads = list(chain.get("loads", {}).values())
        self.frames = {name: (self.names.index(frame["link"]), complex(*frame["point"])) for name, frame in chain.get("frames", {}).items()}
        gravity = complex(*chain["gravity"])
        self.down = gravity / abs(gravity) if gravity else -1j

    def point(self, name, at=None):
        """Number of a link and a point of it: of a link, by default its outer pin; of a frame; or of the tip."""
        if at is None and name in self.frames:
            return self.frames[name]
        link = len(self.names) - 1 if name == "tip" else self.names.index(name)
        return link, self.pin[link] if at is None else complex(*at)


class Springs:
    """link, point, ground, rest, slack: arrays, of each spring to the ground."""

    def __init__(self, springs, names):
        self.link = np.array([names.index(spring["link"]) for spring in springs], dtype=int)
        self.point, self.ground = (complex_of([spring[key] for spring in springs]) for key in ("point", "ground"))
        self.rest = np.array([spring["rest_length"] for spring in springs], dtype=float)
        self.slack = np.array([spring["slack"] for spring in springs], dtype=bool)


def most_of(load):
    """The largest factor of a load."""
    return max(map(abs, load["values"])) if "times" in load else 1.0


def factor_at(load, t):
    """The factor of a load at the times t, s. NaN, that of an unknown time, is 0."""
    factor = np.ones(len(t))
    if "frequency" in load:
        factor = np.sin(2 * np.pi * load["frequency"] * t + load.get("phase", 0))
    elif "times" in load:
        factor = np.interp(t, load["times"], load["values"])
    stop = load.get("stop")
    return np.where((t >= load.get("start", 0)) & (t < (np.inf if stop is None else stop)), factor, 0.0)


class Places:
    """Where a body is at instants, one row for each.

    base: x, y (m) and angle (rad) of the ground pin. q: of all joints. t: times of the scene, s, for its loads; NaN: unknown.
    spans: from where to where the axis of each prismatic joint is drawn, as of spans_of(). shift: is added to all places, m.

    rotation: exp(iθ) of each link. outer: the base and the outer pins. own: the inner pins, of links with prismatic joints their own
    points. coms: the centres of mass. points: the inner pin of the first link that turns and all outer pins from there on."""

    def __init__(self, body, base, q, t=None, spans=None, shift=0.0):
        self.body, self.q, self.t = body, q, np.full(len(q), np.nan) if t is None else t
        self.base_turn = np.exp(1j * base[:, 2:])
        self.rotation = self.base_turn * np.exp(1j * np.cumsum(np.where(body.axis == 0, q, 0), axis=1))
        ground = (base[:, 0] + 1j * base[:, 1])[:, np.newaxis] + np.reshape(shift, (-1, 1))
        steps = self.rotation * (q * body.axis + body.pin)
        self.outer = np.concatenate([ground, ground + np.cumsum(steps, axis=1)], axis=1)
        self.own = self.outer[:, :-1] + self.rotation * q * body.axis
        self.coms = self.own + self.rotation * body.com
        self.points = self.outer[:, body.leading:]
        self.shift = np.reshape(shift, (-1, 1))
        self.spans = spans_of(body, q) if spans is None else spans

    def of(self, link, at):
        """The place of a point of a link at each instant."""
        return self.own[:, link] + self.rotation[:, link] * at

    def axes(self, joints):
        """The ends of the axes of prismatic joints: instants × joints × 2."""
        direction = (self.rotation * self.body.axis)[:, joints]
        zero = self.own[:, joints] - direction * self.q[:, joints]
        return zero[..., np.newaxis] + direction[..., np.newaxis] * self.spans[joints]

    def spring_ends(self):
        """The ground's and the link's end of each spring to the ground: two arrays, instants × springs."""
        springs = self.body.springs
        ends = self.own[:, springs.link] + self.rotation[:, springs.link] * springs.point
        return springs.ground + np.zeros_like(ends) + self.shift, ends


def spans_of(body, q):
    """The range of each joint: to its limits, but not far beyond those of the motion; without limits, that of the motion."""
    low, high = np.minimum(q.min(axis=0), 0), np.maximum(q.max(axis=0), 0)
    limits = np.where(np.isnan(body.limits), np.column_stack([low, high]), body.limits)
    return np.clip(limits, (low - body.reach)[:, np.newaxis], (high + body.reach)[:, np.newaxis])


def base_under(body, first, at, q):
    """x, y (m) and angle (rad) of the ground pin: columns. first: those of the point `at` of the first link."""
    angle = first[:, 2]
    pin = first[:, 0] + 1j * first[:, 1] - np.exp(1j * angle) * (at + q[:, 0] * body.axis[0])
    return np.column_stack([pin.real, pin.imag, angle - q[:, 0] * (body.axis[0] == 0)])
