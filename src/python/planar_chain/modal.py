"""Vibrations about an equilibrium: M δq̈ + D δq̇ + K δq = 0. K and D are −M times the blocks of A of linearize().

With the motions z that are left, δq = N z, and L Lᵀ the inverse of their mass matrix, z = L y gives ÿ + D̃ ẏ + K̃ y = 0,
K̃ = Lᵀ K L symmetric. (L⁻¹ A L is the same, but loses half of the digits of low modes of stiff chains.) Its eigenvectors are the
modes without damping. In them the poles s are those of

    d/dt [w η, η̇] = [[0, w], [−λ/w, −Vᵀ D̃ V]] [w η, η̇],    w² = |λ|,    of which all entries are about as large as s."""

import warnings

import numpy as np

from planar_chain import Refused, equations, equilibrium, inverse_dynamics
from planar_chain._core import _operating_point

NEAR = 1e-5       # rad, m: a pose may be so far from its equilibrium
STARTS = 1e-10    # rad/s², m/s²: or begin to move with so much
ROUNDING = 1e-13  # of the largest λ, of the largest pole
IN_PHASE = 1e-9   # a shape of which no joint has more out of phase is real
FEW = 12          # joints whose shapes are printed


class Modes:
    """q, tau       the equilibrium, n: rad, m; the torques that hold it beside all else, n, N m
    frequencies  |s|/2π of each mode, k, in rising order, Hz
    damping      −Re s/|s|, the damping ratios, k. Below 0: the mode grows
    shapes       n × k: relative q of all joints, rad or m; the largest is 1. Complex if joints swing out of phase
    kinds        "oscillates"; "unstable": grows; "overdamped" or, without dampers, "decays": a pole s < 0, without oscillation;
                 "free": a motion that nothing brings back, s = 0
    poles        s, k, 1/s. A pair has only the one with Im s > 0
    joints       names of the n joints"""

    def __init__(self, q, tau, joints, poles, shapes, is_damped):
        order = np.argsort(abs(poles), kind="stable")
        self.q, self.tau, self.joints, self.poles = q, tau, joints, poles[order]
        size = abs(self.poles)
        self.frequencies = size / (2 * np.pi)
        self.damping = -self.poles.real / np.where(size == 0, 1, size) + 0.0
        largest = np.argmax(abs(shapes) > (1 - IN_PHASE) * abs(shapes).max(axis=0), axis=0)
        shapes = (shapes / shapes[largest, range(len(poles))])[:, order]
        self.shapes = shapes if abs(shapes.imag).max() > IN_PHASE else shapes.real
        tiny = ROUNDING * size.max()
        self.kinds = ["free" if s == 0 else "unstable" if s.real > tiny else "oscillates" if s.imag > 0 else
                      "overdamped" if is_damped else "decays" for s in self.poles]

    def __repr__(self):
        width = max(map(len, self.kinds))
        few = len(self.joints) <= FEW
        lines = [f"mode  frequency (Hz)  damping  {'':{width}}" + "  shape: " * few + ", ".join(self.joints) * few]
        for k, (hertz, ratio, kind) in enumerate(zip(self.frequencies, self.damping, self.kinds), 1):
            shape = "  ".join(map(shown, self.shapes[:, k - 1])) if few else ""
            lines.append(f"{k:4d}  {hertz:14.6g}  {ratio:7.4f}  {kind:{width}}  {shape}")
        return "\n".join(line.rstrip() for line in lines)


def shown(x):
    """A number of a shape: its real part, or size and phase."""
    return f"{x.real:.3g}" if abs(x.imag) < 0.01 * max(abs(x), 0.01) else f"{abs(x):.3g} at {np.degrees(np.angle(x)):.0f}°"


def modes(scene, q=None, t=0.0, tau=None, friction="acts"):
    """Returns the Modes at the equilibrium q (rad, m), by default that of equilibrium(), with loads, drives and base as at time t (s).

    tau: torques that act there beside all else, n, N m; "holding": those that hold q. With them, q is by default that of the first state.
    friction="slips": joints slip, without friction. Otherwise what friction holds does not move, nor what drives or the tip hold.
    Lags of motors are left out: each adds the mode −1/T alone. Raises ValueError for a pose that is no equilibrium."""
    q = (equilibrium(scene, t=t) if tau is None else None) if q is None else np.array(q, dtype=float)
    rest = np.zeros(len(scene))
    try:
        at = equations(scene, q, rest, t)
        q = at["q"]  # to which a closed chain is moved
        with warnings.catch_warnings(record=True) as notes:
            warnings.simplefilter("always")
            (A, B), tau, _ = _operating_point(scene, q, rest, tau, friction, t, False)
        torques = inverse_dynamics(scene, rest, q, rest, t) - tau
    except Refused as refused:
        if not str(refused).startswith("qd"):
            raise
        raise ValueError(f"expected drives, base and tip at rest at t = {t:g} s, got a motion ({refused})") from None
    for note in notes:
        if str(note.message).startswith("tau"):  # the others are on what has no mode, or is refused below
            warnings.warn(note.message, stacklevel=2)
    n = len(scene)
    K, D, B = -at["M"] @ A[n:, :n], -at["M"] @ A[n:, n:], B[n:]
    N = motions_left(B, at.get("J_c", np.zeros((0, n))))
    if N.shape[1] == 0:
        raise ValueError("expected a chain that can move, got one whose joints are all held, by friction "
                         "(friction=\"slips\" lets them slip) or drives")
    L = np.linalg.cholesky(N.T @ B @ N)
    K, D = N.T @ K @ N, N.T @ D @ N
    require_equilibrium(scene, N, N.T @ at["M"] @ N, K, N.T @ torques)
    poles, y, is_damped = poles_of(L.T @ K @ L, L.T @ D @ L)
    return Modes(q, tau, scene.joints, poles, N @ L @ y, is_damped)


def motions_left(B, held):
    """An orthonormal basis of the δq that are left, n × k. B: ∂q̈/∂τ, in which held joints have no row. held: J_c."""
    N = np.eye(len(B))[:, B.any(axis=1)]
    J = held @ N
    return N @ np.linalg.svd(J)[2][len(J):].T if len(J) else N


def require_equilibrium(scene, N, M, K, left):
    """M, K: of the motions left. left: the torques that would hold them."""
    most = NEAR * abs(K).max() + STARTS * abs(M).max()
    if not abs(left).max() <= most:
        torque = N @ left
        j = np.argmax(abs(torque))
        unit = "N" if scene.prismatic[j] else "N m"
        raise ValueError(f"q: expected an equilibrium (equilibrium(scene, q) finds one), got a pose that {abs(torque[j]):.6g} {unit} "
                         f"in {scene.joints[j]}{' and more in other joints' * (np.count_nonzero(abs(torque) > most) > 1)} would have to hold")


def poles_of(K, D):
    """Returns poles, their y as columns, and True if there is damping. One of each pair of poles."""
    value, V = np.linalg.eigh((K + K.T) / 2)
    size = abs(value).max()
    value[abs(value) <= ROUNDING * size] = 0
    w = np.sqrt(np.where(value == 0, 1, abs(value)))
    D = V.T @ D @ V
    is_free = value == 0
    if abs(D).max() <= ROUNDING * np.sqrt(size):
        poles = np.where(value < 0, w, 1j * w)
        poles[is_free] = 0
        falls = value < 0
        return np.concatenate([poles, -w[falls]]), np.hstack([V, V[:, falls]]).astype(complex), False
    zero = np.zeros_like(D)
    s, x = np.linalg.eig(np.block([[zero, np.diag(w)], [-np.diag(value / w), -D]]))
    kept = (s.imag >= 0) & (abs(s) > ROUNDING * abs(s).max())
    y = V @ (x[:len(w)] / w[:, np.newaxis])
    return np.concatenate([np.zeros(np.count_nonzero(is_free)), s[kept]]), np.hstack([V[:, is_free], y[:, kept]]).astype(complex), True
