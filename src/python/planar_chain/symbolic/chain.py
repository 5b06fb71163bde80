"""A chain in letters: its links, forces and torques, and given motions."""

import sympy as sp
from planar_chain.described import described

from . import laws, point_forces
from .coordinates import NONE, Coordinates
from .letters import LATEX, Letters, NoFormula, exact, roman, state_symbols
from .linear import slope

MOST_LINKS = 10
KNOWN = {  # keys that the formulas have; effort_limit, motor, command_delay and velocity_limit concern commands and counts
    "": {"gravity", "q", "qd", "links", "loads", "springs", "frames", "base", "tip"},
    "links": {"name", "mass", "inertia", "com", "pin", "joint", "drag"},
    "drag": {"coefficient", "point"},
    "springs": {"link", "point", "ground", "stiffness", "damping", "rest_length", "slack"},
    "joint": {"name", "stiffness", "damping", "rest_angle", "lower", "upper", "stop_stiffness", "stop_damping", "friction",
              "breakaway", "drag", "rotor_inertia", "effort_limit", "velocity_limit", "motor", "command_delay", "drive", "type",
              "axis"},
    "loads": {"link", "force", "point", "moment", "joint", "torque", "frequency", "phase", "times", "values", "start", "stop"},
    "base": {"x", "y", "angle"},
    "tip": {"pin", "line"},
}


def require_known(path, part, kind):
    for key in part:
        if key not in KNOWN[kind]:
            raise NoFormula(f"{path}{key}: expected keys that formulas have ({', '.join(sorted(KNOWN[kind]))}), got this one")


def require_few_links(n):
    if n > MOST_LINKS:
        raise NoFormula(f"chain: expected at most {MOST_LINKS} links, got {n}. A closed form has of the order of n² terms and its "
                        "solution n³; for longer chains use the recursion: src/recursion/articulated.h, explained under "
                        "“q̈ in O(n)” on the page of theory in include/planar_chain")


def read(scene):
    """The chain of a Scene with all defaults written out, as `equations --chain` prints it."""
    require_few_links(len(scene))
    try:
        return described(scene)
    except RuntimeError as problem:
        raise NoFormula(str(problem)) from None


class ChainInLetters:
    """m, I, J: lists. r, p: 2-vectors. F: 2n, of which `weights`; M, tau: n; as functions of theta, q, qd and `given`.

    coordinates, x, xd: see coordinates.py. theta and omega: of each body, those of the joint that turns it or of the base.
    axes, turned_axes, displacement: of prismatic joints d in body axes, d in ground axes, q d in body axes; 0 of others.
    rows: 2-vectors c_j along which the tip is held, with the acceleration tip_acceleration; none where it is free.

    point_forces: of air drag and springs to the ground. Their symbols are in F and M.
    given: {symbol: expression in t} of the base, the tip, driven joints and factors of loads. driven: numbers of joints, from 0 on.
    tau holds a symbol tau_j where a drive acts."""

    def __init__(self, chain):
        require_known("", chain, "")
        self.links, self.n = [link["name"] for link in chain["links"]], len(chain["links"])
        self.joints = [link["joint"]["name"] for link in chain["links"]]
        require_few_links(self.n)
        self.coordinates = Coordinates([link["joint"].get("type") == "prismatic" for link in chain["links"]])
        self.letters, self.given, self.driven = Letters(), {}, []
        self.q, self.qd, self.qdd, self.theta, self.omega = (
            state_symbols(name, self.n) for name in ("q", "qd", "qdd", "theta", "omega"))
        self._bodies(chain["links"], "tip" in chain)
        self._axes(chain["links"])
        self._gravity(chain["gravity"])
        self._joints(chain["links"])
        self._base(chain.get("base"))
        for i, k in enumerate(self.coordinates.turner):
            self.theta[i], self.omega[i] = (self.theta[k], self.omega[k]) if k != NONE else (self.phi, self.phid)
        self.S = [sp.Matrix([[sp.cos(angle), sp.sin(angle)], [-sp.sin(angle), sp.cos(angle)]]) for angle in self.theta]
        self.turned_axes = [S.T * axis for S, axis in zip(self.S, self.axes)]
        self.x, self.xd = self.theta.copy(), self.omega.copy()
        for i in self.coordinates.prismatic:
            self.x[i], self.xd[i] = self.q[i], self.qd[i]
        self._tip(chain.get("tip", {}))
        self.M = sp.zeros(self.n, 1)
        for name, load in chain.get("loads", {}).items():
            self._load(name, load)
        self._point_forces(chain)

    def define(self, name, expression):
        """A symbol for a function of time; 0 if there is none."""
        if expression == 0:
            return sp.Integer(0)
        symbol = sp.Symbol(name)
        self.given[symbol] = expression
        return symbol

    def _bodies(self, links, holds_tip):
        self.m, self.I, self.r, self.p = [], [], [], []
        self.com = [link["com"] for link in links]
        for i, link in enumerate(links, 1):
            require_known(f"links/{link['name']}/", link, "links")
            body = f"body {i} ({link['name']})"
            self.m.append(self.letters.number(f"m_{i}", link["mass"], "kg", f"mass of {body}"))
            self.I.append(self.letters.number(f"I_{i}", link["inertia"], "kg m^2", f"inertia of {body} about its centre of mass"))
            self.r.append(self.letters.vector("r", link["com"], "m", "from the inner pin to the centre of mass", i))
            outer = link["pin"] if i < self.n or holds_tip else (0, 0)  # nothing hangs on a free tip
            self.p.append(self.letters.vector("p", outer, "m", "from the inner pin to the outer one", i))

    def _axes(self, links):
        self.axes = [sp.zeros(2, 1)] * self.n
        for i in self.coordinates.prismatic:
            joint = links[i]["joint"]
            self.axes[i] = self._direction("d", joint["axis"], f"axis of the prismatic joint {i + 1} ({joint['name']})", i + 1)
        self.displacement = [q * axis for q, axis in zip(self.q, self.axes)]

    def _gravity(self, gravity):
        x, y = gravity
        if x == 0 and y < 0:
            g = sp.Matrix([0, -self.letters.number("g", -y, "m/s^2", "gravity, along -y of the ground")])
        else:
            g = sp.Matrix([self.letters.number(f"g_{axis}", value, "m/s^2", f"gravity, {axis} of the ground")
                           for axis, value in zip("xy", gravity)])
        self.weights = sp.Matrix([m * component for m in self.m for component in g])
        self.F = self.weights.copy()

    def _joints(self, links):
        self.J, self.tau = [], sp.zeros(self.n, 1)
        for k, link in enumerate(links):
            joint = link["joint"]
            require_known(f"links/{link['name']}/joint/", joint, "joint")
            self.J.append(self._letter("J", k, joint, "rotor_inertia", "kg" if self._units(k)[0] == "m" else "kg m^2", "inertia of the rotor of joint"))
            if "drive" in joint:
                self.driven.append(k)
                self.tau[k] = sp.Symbol(f"tau_{k + 1}")
                acceleration = laws.motion(self.letters, f"links/{link['name']}/joint/drive", joint["drive"],
                                           f"drive_{k + 1}", f"{k + 1}", self._units(k)[0])[2]
                self.qdd[k] = self.define(f"qdd_{k + 1}", acceleration)
            else:
                self.tau[k] = self._torque(k, joint)

    def _letter(self, name, k, joint, key, unit, meaning, latex=None):
        return self.letters.number(f"{name}_{k + 1}", joint.get(key) or 0, unit, f"{meaning} {k + 1} ({joint['name']})",
                                   latex and f"{latex[0]}_{{{k + 1}}}{latex[1]}")

    def _units(self, k):
        """The units of a joint's q and of its torque or force."""
        return ("m", "N") if k in self.coordinates.prismatic else ("rad", "N m")

    def _torque(self, k, joint):
        """Springs, dampers, friction of a sliding joint, drag, stops that push."""
        (q, qd), (way, force) = (self.q[k], self.qd[k]), self._units(k)
        per_rate = "N s/m" if way == "m" else "N m s/rad"
        stiffness = self._letter("k", k, joint, "stiffness", f"{force}/{way}", "stiffness of joint")
        rest = self._letter("q0", k, joint, "rest_angle", way, "rest angle of joint", ("q", "^0")) if stiffness != 0 else 0
        damping = self._letter("d", k, joint, "damping", per_rate, "damping of joint")
        friction = self._letter("c", k, joint, "friction", force, "friction of joint")
        per_square = "N s^2/m^2" if way == "m" else "N m s^2/rad^2"
        drag = self._letter("cd", k, joint, "drag", per_square, "drag of joint", ("c", "^d"))
        torque = -stiffness * (q - rest) - damping * qd - friction * sp.sign(qd) - drag * sp.Abs(qd) * qd
        limits = [(key, sign) for key, sign in (("lower", -1), ("upper", 1)) if joint.get(key) is not None]
        if not limits:
            return torque
        stiffness = self._letter("ks", k, joint, "stop_stiffness", f"{force}/{way}", "stiffness of the stops of joint", ("k", "^s"))
        damping = self._letter("ds", k, joint, "stop_damping", per_rate, "damping of the stops of joint", ("d", "^s"))
        for key, sign in limits:
            limit = self._letter(f"q{key}", k, joint, key, way, f"{key} limit of joint", ("q", "^+" if sign > 0 else "^-"))
            push = stiffness * sign * (q - limit) + damping * sign * qd
            is_beyond = q > limit if sign > 0 else q < limit
            torque -= sign * sp.Piecewise((push, sp.And(is_beyond, push > 0)), (0, True))
        return torque

    def _base(self, base):
        """p̈ of the ground pin; φ, φ̇ and φ̈ of the base."""
        laws_of = base or {}
        require_known("base/", laws_of, "base")
        moved = {axis: laws.motion(self.letters, f"base/{axis}", law, f"base_{axis}",
                                   roman("base", LATEX["phi_0"] if axis == "angle" else axis), "rad" if axis == "angle" else "m")
                 for axis, law in laws_of.items()}
        still = [sp.Integer(0)] * 3
        self.base_laws = [moved.get(axis, still) for axis in "xy"]
        self.pdd = sp.Matrix([self.define(f"pdd_{axis}", law[2]) for axis, law in zip("xy", self.base_laws)])
        self.phi, self.phid, self.phidd = (self.define(name, value) for name, value in
                                           zip(("phi_0", "phid_0", "phidd_0"), moved.get("angle", still)))

    def _tip(self, tip):
        """c_j and ẍ_T."""
        require_known("tip/", tip, "tip")
        self.rows, self.tip_acceleration = [], sp.zeros(2, 1)
        if "line" in tip:
            x, y = tip["line"]["direction"]
            self.rows = [self._direction("c", (-y, x), "the normal of the line on which the tip slides", 1)]
        elif tip:
            self.rows = [sp.Matrix([1, 0]), sp.Matrix([0, 1])]
            self.tip_acceleration = sp.Matrix([self.define(f"{axis}dd_T", laws.motion(
                self.letters, f"tip/pin/{axis}", tip["pin"][axis], f"tip_{axis}", roman("tip", axis), "m")[2]) for axis in "xy"])

    def _direction(self, name, pair, meaning, i):
        return sp.Matrix([exact(x) if x in (-1, 0, 1) else self.letters.number(
            f"{name}_{i}{axis}", x, "1", f"{meaning}, of length 1, {axis}", f"{name}_{{{i}{axis}}}") for axis, x in zip("xy", pair)])

    def _load(self, name, load):
        require_known(f"loads/{name}/", load, "loads")
        factor = laws.factor(self.letters, name, load)
        factor = factor if factor.is_number else self.define(f"factor_{name}", factor)

        def letter(key, value, unit, sign, axis=""):
            meaning = {"arm": "where the force acts, from the centre of mass, in the axes of the body:"}.get(key, f"{key} of")
            return self.letters.number(f"load_{name}_{key}" + (axis and "_" + axis), value, unit,
                                       f"{meaning} the load {name}" + (axis and ", " + axis), f"{sign}_{roman(name, *axis)}")

        if "link" in load:
            k = self.links.index(load["link"])
            force = sp.Matrix([letter("force", value, "N", "F", axis) for axis, value in zip("xy", load["force"])])
            arm = sp.zeros(2, 1)
            if force != sp.zeros(2, 1):
                arm = sp.Matrix([letter("arm", x - r, "m", "x", axis)
                                 for axis, x, r in zip("xy", load["point"], self.com[k])])
            along = arm.T * self.S[k]  # ground components
            self.F[2 * k:2 * k + 2, 0] += factor * force
        if "link" in load and self.coordinates.turner[k] != NONE:
            self.M[k] += factor * (letter("moment", load["moment"], "N m", "M") + along[0] * force[1] - along[1] * force[0])
        if "joint" in load:
            k = self.joints.index(load["joint"])
            self.tau[k] += factor * letter("torque", load["torque"], self._units(k)[1], r"\tau")

    # ---- Air drag and springs to the ground

    def _point_forces(self, chain):
        self.point_forces = []
        if not any("drag" in link for link in chain["links"]) and "springs" not in chain:
            return
        self.base = [sp.Matrix([self.define(f"{name}_{axis}", law[k]) for axis, law in zip("xy", self.base_laws)])
                     for k, name in enumerate(("p", "pd"))]
        for k, link in enumerate(chain["links"]):
            if "drag" in link:
                require_known(f"links/{link['name']}/drag/", link["drag"], "drag")
                name = f"drag_{k + 1}"
                c = self.letters.number(f"ca_{k + 1}", link["drag"]["coefficient"], "N s^2/m^2", f"air drag of body {k + 1} ({link['name']})",
                                        rf"c^{{\mathrm{{air}}}}_{{{k + 1}}}")
                self._act(k, name, f"{k + 1}", link["drag"]["point"], lambda *at, c=c: point_forces.drag(c, *at))
        for name, spring in chain.get("springs", {}).items():
            require_known(f"springs/{name}/", spring, "springs")
            numbers = self._numbers_of(name, spring)
            self._act(self.links.index(spring["link"]), f"spring_{name}", roman(name)[1:-1], spring["point"],
                      lambda *at, numbers=numbers, slack=spring["slack"]: point_forces.spring(numbers, slack, *at))

    def _numbers_of(self, name, spring):
        """k, d, L⁰ and the point of the ground."""
        def letter(key, value, unit, sign, meaning, axis=""):
            return self.letters.number(f"spring_{name}_{key}", value, unit, f"{meaning} of the spring {name}" + (axis and ", " + axis),
                                       f"{sign}_{roman(name, *axis)}")

        k, d, rest = (letter(key, spring[key], unit, sign, key.replace("_", " ")) for key, unit, sign in (
            ("stiffness", "N/m", "k"), ("damping", "N s/m", "d"), ("rest_length", "m", "L^0")))
        return k, d, rest, sp.Matrix([letter(f"ground_{axis}", value, "m", "x^0", "point of the ground", axis)
                                      for axis, value in zip("xy", spring["ground"])])

    def _act(self, k, name, index, point, make):
        """A force on this point of body k, m: make(place, velocity, name, index)."""
        arm = sp.Matrix([self.letters.number(
            f"{name}_arm_{axis}", x - r, "m", f"where {name} acts, from the centre of mass, in the axes of the body: {axis}",
            f"a_{{{index},{axis}}}") for axis, x, r in zip("xy", point, self.com[k])])
        place = self.base[0] + self.S[k].T * (self.r[k] + arm)
        for j in range(k + 1):
            place += self.S[j].T * (self.displacement[j] + (self.p[j] if j < k else sp.zeros(2, 1)))
        moving = [*zip(self.x, self.xd), *([(self.phi, self.phid)] if self.phi != 0 else [])]
        velocity = self.base[1] + sp.Matrix([sp.Add(*(slope(value, x) * xd for x, xd in moving)) for value in place])
        force = make(place, velocity, name, index)
        self.point_forces.append(force)
        self.F[2 * k:2 * k + 2, 0] += force.F
        if self.coordinates.turner[k] != NONE:
            along = arm.T * self.S[k]
            self.M[k] += along[0] * force.F[1] - along[1] * force.F[0]
