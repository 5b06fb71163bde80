"""What the panels over time show, and their axes: for plot."""

import numpy as np
from matplotlib.ticker import Formatter

ENERGIES = {"T": "T, kinetic", "V": "V, potential", "supplied": "work supplied"}
STILL = 1e-6      # rad, rad/s, N m, or shares of what is drawn: no axis shows less
ROUNDING = 1e-12  # the same of an imbalance, in shares of the energy
FINE = 1e-3       # an axis along x that shows so little of its largest number has few, long numbers
FEW = 20          # one error of so many may be less than the axis shows
DIGITS = 9        # of a number at an axis, at most
# Label and unit of q, its rate, and what acts along it.
TURNS = ("angle q", "rad"), ("rate q̇", "rad/s"), ("torque τ", "N m")
PRISMATIC = ("position q", "m"), ("speed q̇", "m/s"), ("force τ", "N")
UNKNOWN = ("q", "rad or m"), ("rate q̇", "rad/s or m/s"), ("torque τ", "N m or N")
OF_JOINTS = ("q", "rate", "torque")
NAMES = (*OF_JOINTS, "energy", "phase", "imbalance", "error", "imu")
USUAL, MOST = NAMES[:5], 6
FIRST_TO_GO = ("rate", "energy", "torque", "phase")  # if there are more than MOST


class Panel:
    """name: of NAMES. label, unit: of its axis. curves: (name, t, values). least: height of the axis. signals: of plot_signals."""

    def __init__(self, name, label, unit, curves, least, signals=()):
        self.name, self.label, self.unit, self.curves, self.least, self.signals = name, label, unit, curves, least, signals


def kinds(motion, columns):
    """Pairs (units, columns): of the prismatic joints, and of the revolute ones; or of all, if that is not known."""
    if motion.prismatic is None:
        return [(UNKNOWN, columns)]
    prismatic = [j for j in columns if motion.joints[j] in motion.prismatic]
    return [pair for pair in ((PRISMATIC, prismatic), (TURNS, [j for j in columns if j not in prismatic])) if pair[1]]


def panels(motion, columns, wrap):
    """All that have data."""
    for k, name in enumerate(OF_JOINTS, 1):
        for kind, ours in kinds(motion, columns):
            joints = [motion.joints[j] for j in ours]
            curves = [(joint, each[0], each[k]) for joint, each in ((motion.joints[j], motion.curves(j, wrap)) for j in ours)]
            signals = [signal for signal in motion.signals if signal.panel == k and signal.joint in joints]
            if k < 3 or has_values(curves) or signals:
                yield Panel(name, *kind[k - 1], curves, STILL, signals)
    yield from energies(motion)
    if motion.error and (motion.error[1] > 0).any():
        t, error = motion.broken(*motion.error)
        sizes = np.sort(error[error > 0])
        least = max(sizes[len(sizes) // FEW] / 3, motion.rounding)  # what is far less does not stretch the axis
        yield Panel("error", "error estimate\n", "tolerances", [("", t, np.maximum(error, least))], 0)
    if motion.imus:
        yield Panel("imu", "gyro", "rad/s", [(name, t, rate) for name, (t, rate, _) in motion.imus.items()], STILL)
        yield Panel("imu", "accelerometer\n", "m/s²", [(f"{name}, {axis}", t, values[:, k]) for name, (t, _, values) in motion.imus.items()
                                                     for k, axis in enumerate("xy")], STILL)


def energies(motion):
    if not motion.energy:
        return
    t, parts = motion.energy
    curves = [(ENERGIES.get(name, name), *motion.broken(t, part)) for name, part in parts.items() if np.any(np.nan_to_num(part) != 0)]
    most = max(np.nan_to_num(abs(part)).max() for part in parts.values())
    if curves:
        yield Panel("energy", "energy" if len(parts) > 1 else "T + V, less that\nof the start", "J", curves, max(STILL * most, STILL))
    if motion.balance:
        curves = [("", *motion.broken(*motion.balance))]
        if has_values(curves):
            yield Panel("imbalance", "energy imbalance\n", "J", curves, ROUNDING * max(most, STILL))


def usual(present, portraits):
    """The names of the panels that are drawn if none are asked for, and of those that do not fit. present: the name of each panel with
    data. portraits: how many there are."""
    counts = {name: portraits if name == "phase" else present.count(name) for name in USUAL}
    left_out = []
    for name in FIRST_TO_GO:
        if sum(counts.values()) > MOST and counts[name]:
            left_out.append(name)
            counts[name] = 0
    return [name for name in USUAL if counts[name]], left_out


def has_values(curves):
    return any(np.any(np.nan_to_num(values) != 0) for _, _, values in curves)


class Plain(Formatter):
    """Numbers in units of a power of ten, with as many digits as tell one tick from the next: no sum with an offset."""

    def __init__(self, power):
        self.power, self.decimals = power, 0

    def set_locs(self, locs):
        self.locs = locs
        values = np.array(locs) / 10.0 ** self.power
        step = abs(np.diff(values)).min(initial=np.inf) if len(values) > 1 else 1.0
        self.decimals = next((n for n in range(DIGITS) if (abs(np.round(values, n) - values) < 1e-3 * step).all()), DIGITS)

    def __call__(self, x, pos=None):
        text = f"{x / 10.0 ** self.power:.{self.decimals}f}"
        return text.replace("-", "\N{MINUS SIGN}") if float(text) else text.replace("-", "")


def label_axis(axis, label, unit):
    """Puts a power of ten of the numbers at an axis before its unit, where it covers nothing."""
    low, high = axis.get_view_interval()
    largest = max(abs(low), abs(high))
    power = int(np.floor(np.log10(largest))) if largest > 0 else 0
    if axis.get_scale() == "linear":
        power = 0 if -3 <= power <= 4 else power
        axis.set_major_formatter(Plain(power))
        if axis.axis_name == "x" and high - low < FINE * largest:
            axis.axes.locator_params(axis="x", nbins=2)
        unit = f"1e{power} {unit}" if power else unit
    axis.set_label_text(f"{label} ({unit})" if not label.endswith("\n") else f"{label}({unit})")


def give_height(limits, least):
    """Widens the interval of an axis to this height at least."""
    low, high = limits
    least = max(least, STILL * max(abs(low), abs(high))) if least else 0
    return ((low + high - least) / 2, (low + high + least) / 2) if high - low < least else (low, high)
