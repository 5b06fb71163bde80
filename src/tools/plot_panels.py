"""What the panels over time show, and their axes: for plot."""

import numpy as np

ENERGIES = {"T": "T, kinetic", "V": "V, potential", "supplied": "work supplied"}
STILL = 1e-6      # rad, rad/s, N m, or shares of an energy: no axis shows less
ROUNDING = 1e-12  # the same of an imbalance, in shares of the energy
FEW = 20          # one error of so many may be less than the axis shows
# Label and unit of q, its rate, and what acts along it.
TURNS = ("angle q", "rad"), ("rate q̇", "rad/s"), ("torque τ", "N m")
PRISMATIC = ("position q", "m"), ("speed q̇", "m/s"), ("force τ", "N")
UNKNOWN = ("q", "rad or m"), ("rate q̇", "rad/s or m/s"), ("torque τ", "N m or N")


def kinds(motion, columns):
    """Pairs (units, columns): of the prismatic joints, and of the revolute ones; or of all, if that is not known."""
    if motion.prismatic is None:
        return [(UNKNOWN, columns)]
    prismatic = [j for j in columns if motion.joints[j] in motion.prismatic]
    return [pair for pair in ((PRISMATIC, prismatic), (TURNS, [j for j in columns if j not in prismatic])) if pair[1]]


def panels(motion, columns, wrap):
    """For each panel with data: label and unit of the axis, curves (name, t, values), the least height of the axis."""
    for kind, ours in kinds(motion, columns):
        joints = [(motion.joints[j], motion.curves(j, wrap)) for j in ours]
        for k, (label, unit) in enumerate(kind, 1):
            curves = [(name, curves[0], curves[k]) for name, curves in joints]
            if k < 3 or has_values(curves):
                yield label, unit, curves, STILL
    if motion.energy:
        t, parts = motion.energy
        curves = [(ENERGIES.get(name, name), *motion.broken(t, part)) for name, part in parts.items() if np.any(np.nan_to_num(part) != 0)]
        most = max(np.nan_to_num(abs(part)).max() for part in parts.values())
        if curves:
            yield "energy" if len(parts) > 1 else "T + V, less that\nof the start", "J", curves, max(STILL * most, STILL)
        if motion.balance:
            curves = [("", *motion.broken(*motion.balance))]
            if has_values(curves):
                yield "energy imbalance\n", "J", curves, ROUNDING * max(most, STILL)
    if motion.error and (motion.error[1] > 0).any():
        t, error = motion.broken(*motion.error)
        sizes = np.sort(error[error > 0])
        least = max(sizes[len(sizes) // FEW] / 3, motion.rounding)  # what is far less does not stretch the axis
        yield "error estimate\n", "tolerances", [("", t, np.maximum(error, least))], 0


def has_values(curves):
    return any(np.any(np.nan_to_num(values) != 0) for _, _, values in curves)


def label_axis(axis, label, unit):
    """Puts the power of ten that stands at the numbers of an axis before its unit, where it covers nothing."""
    low, high = axis.get_view_interval()
    largest = max(abs(low), abs(high))
    power = int(np.floor(np.log10(largest))) if largest > 0 else 0
    if axis.get_scale() == "linear" and not -3 <= power <= 4:
        axis.set_major_formatter(lambda value, _: f"{value / 10.0 ** power:.4g}".replace("-", "\N{MINUS SIGN}"))
        unit = f"1e{power} {unit}"
    axis.set_label_text(f"{label} ({unit})" if not label.endswith("\n") else f"{label}({unit})")


def give_height(axes, least):
    low, high = axes.get_ylim()
    if high - low < least:
        axes.set_ylim((low + high - least) / 2, (low + high + least) / 2)
