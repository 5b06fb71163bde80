"""A sketch of a chain with the letters of its formulas."""

import matplotlib
matplotlib.use("Agg")
import numpy as np  # noqa: E402  pylint: disable=wrong-import-position
from matplotlib import pyplot  # noqa: E402  pylint: disable=wrong-import-position
from matplotlib.patches import Arc  # noqa: E402  pylint: disable=wrong-import-position

COLOURS = ("#0072B2", "#D55E00", "#009E73")
HEIGHT, WIDTH = 3.3, 6.3    # inch: as large as the page shows it
FEW = 3                     # more bodies than these have no room for their absolute angles
BEND = 0.6                  # rad, each joint, where the tip is free
THIN = {"color": "0.45", "linewidth": 0.6, "zorder": 0}


def pose(chain):
    """Returns for each joint True if it is prismatic, and q of the sketch: bent and displaced joints. A chain whose tip is held stays
    as it begins, unless it is stretched."""
    prismatic = [link["joint"].get("type") == "prismatic" for link in chain["links"]]
    bend, shift = min(BEND, 2.0 / len(prismatic)), 0.7 * size_of(chain) / len(prismatic)
    if "tip" in chain:
        is_bent = any(abs(np.sin(q)) > 0.2 for q, is_prismatic in list(zip(chain["q"], prismatic))[1:] if not is_prismatic)
        return prismatic, chain["q"] if is_bent else [shift if k else bend * (1 if i == 0 else -1.3) for i, k in enumerate(prismatic)]
    return prismatic, [shift if is_prismatic else bend for is_prismatic in prismatic]


def size_of(chain):
    """m: of all links, one after another."""
    return sum(max(np.hypot(*link["pin"]), np.hypot(*link["com"])) for link in chain["links"]) or 1.0


class Sketch:
    """Draws link after link from the origin. unit: the distance between parallel lines, m. is_long: of many links."""

    def __init__(self, axes, unit, is_long):
        self.axes, self.unit, self.is_long = axes, unit, is_long

    def text(self, at, words, ha="center"):
        self.axes.text(at.real, at.imag, words, ha=ha, va="center", fontsize=7 if self.is_long else 9)

    def line(self, a, b, **style):
        self.axes.plot([a.real, b.real], [a.imag, b.imag], **style)

    def measure(self, a, b, letter, offset):
        """An arrow beside the line from a to b, to its left, with a letter."""
        across = 1j * (b - a) / abs(b - a) * self.unit
        for end in (a, b):
            self.line(end, end + (offset + 0.3) * across, **THIN)
        a, b = a + offset * across, b + offset * across
        self.axes.annotate("", (b.real, b.imag), (a.real, a.imag),
                           arrowprops={"arrowstyle": "->", "linewidth": 0.6, "shrinkA": 0, "shrinkB": 0})
        self.text((a + b) / 2 + 0.6 * across, letter)

    def angle(self, at, first, last, radius, letter):
        """An arc from one direction to another, from a line along the first."""
        self.line(at, at + 1.15 * radius * np.exp(1j * first), **{**THIN, "linestyle": "--"})
        low, high = sorted((first, last))
        self.axes.add_patch(Arc((at.real, at.imag), 2 * radius, 2 * radius, theta1=np.degrees(low), theta2=np.degrees(high), linewidth=0.6))
        self.text(at + (radius + 0.3 * self.unit) * np.exp(1j * (first + last) / 2), letter, "left")

    def mass(self, at, link, i, side):
        """side: the direction in which its letters stand."""
        letters = [rf"${letter}_{{{i}}}$" for letter, key in (("m", "mass"), ("I", "inertia")) if link[key]]
        if letters:
            self.axes.plot(at.real, at.imag, "o", markersize=6, color="black", markerfacecolor="white", markeredgewidth=0.8)
            self.axes.plot(at.real, at.imag, "+", markersize=6, color="black", markeredgewidth=0.8)
            self.text(at + self.unit * side, ", ".join(letters), "left")

    def shift(self, at, link, i, theta, q):
        """A prismatic joint. Returns the outer pin."""
        along = np.exp(1j * theta)
        own, pin, com = (at + q * along * complex(*link["joint"]["axis"]), *(along * complex(*link[key]) for key in ("pin", "com")))
        self.line(at, own, **{**THIN, "linestyle": "--"})
        self.measure(at, own, f"$q_{{{i}}}$", -1)
        if link["mass"]:
            corners = along * np.array([-2 - 1j, 2 - 1j, 2 + 1j, -2 + 1j, -2 - 1j])
            self.axes.plot(own.real, own.imag, linestyle="", marker=np.column_stack([corners.real, corners.imag]), markersize=22,
                           markerfacecolor="none", color="0.45")
            self.mass(own + com, link if theta else {**link, "inertia": 0}, i, 2)
        if theta and com:
            self.measure(own, own + com, f"$r_{{{i}}}$", 1)
        if pin:
            self.line(own, own + pin, **THIN)
            self.measure(own, own + pin, f"$p_{{{i}}}$", 1)
        return own + pin

    def turn(self, at, link, i, before, theta, is_last):
        """before: θ of the link before. Returns the outer pin."""
        along = np.exp(1j * theta)
        com, pin = complex(*link["com"]) * along, complex(*link["pin"]) * along
        reach = max(abs(com), abs(pin))
        self.line(at, at + (pin or com), color=COLOURS[i % len(COLOURS)], linewidth=3, solid_capstyle="round", alpha=0.6)
        self.axes.plot(at.real, at.imag, "o", markersize=4, color="0.3")
        self.angle(at, before, theta, 0.32 * reach, f"$q_{{{i}}}$" if before or self.is_long else rf"$q_{{{i}}} = \theta_{{{i}}}$")
        if before and not self.is_long:
            self.angle(at, 0.0, theta, 0.16 * reach, rf"$\theta_{{{i}}}$")
        if com:
            self.measure(at, at + com, f"$r_{{{i}}}$", 1)
        if pin and not is_last:
            self.measure(at, at + pin, f"$p_{{{i}}}$", 2.6)
        self.mass(at + com, link, i, 0.9 * along * (1 - 1j) if abs(com) > 0.4 * reach else -1.4j)  # there the angles have letters
        return at + pin


def draw(chain):
    """A figure. chain: as read() of chain.py returns it."""
    figure, axes = pyplot.subplots(figsize=(WIDTH, HEIGHT))
    (prismatic, q), at, theta = pose(chain), 0j, 0.0
    sketch = Sketch(axes, 0.05 * size_of(chain), len(prismatic) - sum(prismatic) > FEW)
    for i, (link, is_prismatic) in enumerate(zip(chain["links"], prismatic), 1):
        if is_prismatic:
            at = sketch.shift(at, link, i, theta, q[i - 1])
        else:
            is_last = i == len(prismatic) and "tip" not in chain
            at, theta = sketch.turn(at, link, i, theta, theta + q[i - 1], is_last), theta + q[i - 1]
    if not prismatic[0]:
        axes.plot(0, 0, "^", markersize=10, color="0.6", zorder=-1)
    if "tip" in chain:
        axes.plot(at.real, at.imag, "s", markersize=8, color="0.6", zorder=-1)
    axes.set_aspect("equal")
    axes.margins(0.08)
    axes.axis("off")
    return figure
