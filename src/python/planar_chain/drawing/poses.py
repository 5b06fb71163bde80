"""A chain as lines of a picture: one drawing of a pose for stroboscopes, movies and Environment.render()."""

import numpy as np

from .body import factor_at, most_of

FEW_LINKS = 12  # in chains of at most so many links every pin, and every spring of a joint, is marked
GREY, SPRING, LOAD = "#7F7F7F", "#009E73", "#CC79A7"
PATHS = ["#D55E00", "#E69F00", "#56B4E9", "#8C6D31"]  # of points of the chain
# Sizes in points of the printer, whatever the scale.
BOX, CART, COIL, HEAD, ARC = 4.0, 8.0 + 5.0j, 4.0, 6.0, 13.0
LONGEST = 0.25       # of the reach: the arrow of the largest force
LARGEST = 1.5 * np.pi  # rad: the arc of the largest torque
TURNS = 7            # of a coil
FREE = 0.06          # of the picture's size, on each side of what is drawn

# For each kind of line its name in a legend, or "", and how it is drawn. Without a colour it has that of its pose.
STYLES = {
    "rails": ("", {"color": GREY, "linewidth": 2.5, "alpha": 0.35, "solid_capstyle": "butt", "zorder": 0}),
    "mast": ("", {"color": GREY, "linewidth": 0.6, "zorder": 0}),
    "axes": ("", {"linewidth": 5, "alpha": 0.35, "solid_capstyle": "butt", "zorder": 1}),
    "anchors": ("", {"color": GREY, "linestyle": "", "marker": "^", "markersize": 5, "zorder": 0}),
    "springs": ("spring", {"linewidth": 1.0, "zorder": 1.5}),
    "ropes": ("rope", {"linewidth": 1.0, "zorder": 1.5}),
    "links": ("", {"linewidth": 1.6}),
    "pins": ("", {"linestyle": "", "marker": "o", "markersize": 3}),
    "levers": ("", {"linewidth": 1.6, "linestyle": ":"}),
    "masses": ("centre of mass", {"linestyle": "", "marker": "s", "markersize": 6}),
    "boxes": ("prismatic joint", {"linewidth": 1.3}),
    "carts": ("cart", {"linewidth": 1.3}),
    "ground": ("ground pin", {"color": GREY, "linestyle": "", "marker": "^", "markersize": 9, "zorder": 0}),
    "held": ("pin of the tip", {"color": GREY, "linestyle": "", "marker": "s", "markersize": 8, "zorder": 0}),
    "frames": ("frame", {"linestyle": "", "marker": "x", "markersize": 6}),
    "loads": ("load", {"color": LOAD, "linewidth": 1.4, "zorder": 4}),
}


def joined(lines):
    """instants × lines × points: the lines in one, with gaps between."""
    gaps = np.full((*lines.shape[:2], 1), np.nan)
    return np.concatenate([lines, gaps], axis=2).reshape(len(lines), -1)


def polygons(corners, places, directions):
    """Closed polygons around each place: instants × places."""
    return joined(places[..., np.newaxis] + directions[..., np.newaxis] * np.append(corners, corners[0]))


def directions_of(lines):
    """The directions of lines × 2 points, of length 1. A line without length has 1."""
    steps = lines[..., 1] - lines[..., 0]
    size = abs(steps)
    return np.where(size > 0, steps / np.where(size > 0, size, 1), 1)


def coils(start, end, width):
    """A zigzag from each start to its end."""
    share = np.concatenate([[0, 0.1], 0.1 + 0.8 * (np.arange(2 * TURNS) + 0.5) / (2 * TURNS), [0.9, 1]])
    aside = np.concatenate([[0, 0], width * (-1.0) ** np.arange(2 * TURNS), [0, 0]])
    lines = np.stack([start, end], axis=-1)
    return joined(start[..., np.newaxis] + (end - start)[..., np.newaxis] * share + 1j * directions_of(lines)[..., np.newaxis] * aside)


def ropes(start, end, rest, down):
    """A straight line from each start to its end, or a parabola as long as the rope at rest, if that is longer."""
    share = np.linspace(0, 1, 17)
    line, sag = start[..., np.newaxis] + (end - start)[..., np.newaxis] * share, down * 4 * share * (1 - share)
    low, high = np.zeros(start.shape), np.broadcast_to(rest, start.shape)
    for _ in range(20):
        middle = (low + high) / 2
        is_short = abs(np.diff(line + middle[..., np.newaxis] * sag)).sum(axis=-1) < rest
        low, high = np.where(is_short, middle, low), np.where(is_short, high, middle)
    return joined(line + low[..., np.newaxis] * sag)


def spirals(places, directions, width):
    """Around each place."""
    turn = np.linspace(0, 2.25, 28)
    return joined(places[..., np.newaxis] + width * directions[..., np.newaxis] * (0.4 + 0.5 * turn) * np.exp(2j * np.pi * turn))


def arrows(start, steps, head):
    """From each start. One without length is left out."""
    size = abs(steps)
    there = np.where(size > 0, steps, np.nan)
    barb = np.minimum(head, 0.5 * size) * there / np.where(size > 0, size, 1)
    end = start + there
    return joined(np.stack([start, end, end - barb * (1 + 0.5j), end, end - barb * (1 - 0.5j)], axis=-1))


def arcs(places, angles, head, radius):
    """An arrow around each place, as far as the angle. One without an angle is left out."""
    there = np.where(angles == 0, np.nan, angles)[..., np.newaxis]
    line = places[..., np.newaxis] + radius * np.exp(1j * there * np.linspace(0, 1, 24))
    end, along = line[..., -1:], 1j * np.sign(there) * np.exp(1j * there) * np.minimum(head, radius * abs(there))
    return joined(np.concatenate([line, end - along * (1 + 0.5j), end, end - along * (1 - 0.5j)], axis=2))


def acting(places):
    """Arrows of forces and arcs of moments and torques: for each load its places and complex steps, m, or angles, rad, at the instants.
    The largest that the scene's loads reach have full length."""
    body, forces, turns = places.body, [], []
    for load in body.loads:
        factor, most = factor_at(load, places.t), most_of(load)
        if "link" in load:
            at, force = places.of(body.names.index(load["link"]), complex(*load["point"])), complex(*load["force"])
            forces.append((at, factor * force, most * abs(force)))
            turns.append((at, factor * load["moment"], most * abs(load["moment"])))
        if "joint" in load:
            j = body.joints.index(load["joint"])
            along = (places.rotation * body.axis)[:, j] if body.axis[j] else 1.0
            (forces if body.axis[j] else turns).append((places.own[:, j], factor * load["torque"] * along, most * abs(load["torque"])))
    for acts, full in ((forces, LONGEST * body.reach), (turns, LARGEST)):
        at, values = (np.array([act[k] for act in acts]).reshape(len(acts), len(places.q)).T for k in (0, 1))
        yield at, values * (full / (max((most for *_, most in acts), default=0) or 1.0))


def loads_of(places, unit):
    forces, turns = acting(places)
    return np.concatenate([arrows(*forces, HEAD * unit), arcs(*turns, HEAD * unit, ARC * unit)], axis=1)


def in_view(places):
    """All that must be seen."""
    body, forces, ends = places.body, next(acting(places)), places.spring_ends()
    slack = ropes(*ends, np.where(body.springs.slack, body.springs.rest, 0), body.down)
    seen = np.concatenate([each.ravel() for each in (
        places.points, places.coms[:, body.aside], places.own[:, :body.carts], places.own[:, body.inner], places.axes(body.inner),
        places.axes(np.arange(body.carts)), slack, sum(forces), *(places.of(*point) for point in body.frames.values()))])
    return seen[~np.isnan(seen)]


def lines_of(places, unit):
    """{name: points of the line at each instant}, of those of STYLES that this chain has. unit: metres in a point of the printer."""
    body, few = places.body, len(places.body.pin) <= FEW_LINKS
    carts = np.arange(body.carts)
    breaks = np.repeat(body.inner - body.leading + 1, 2)  # behind a prismatic joint the line begins anew
    anew = np.stack([np.full((len(places.q), len(body.inner)), np.nan), places.own[:, body.inner]], axis=2)
    lines = {"links": np.insert(places.points, breaks, anew.reshape(len(places.q), -1), axis=1)}
    if few:
        lines["pins"] = np.column_stack([places.points, places.own[:, body.inner]])
    if len(body.aside):
        lines["levers"] = joined(np.stack([places.own[:, body.aside], places.coms[:, body.aside]], axis=2))
        lines["masses"] = places.coms[:, body.aside]
    if len(body.inner):
        along = places.axes(body.inner)
        square = BOX * unit * np.array([-1 - 1j, 1 - 1j, 1 + 1j, -1 + 1j])
        lines.update(axes=joined(along), boxes=polygons(square, places.own[:, body.inner], directions_of(along)))
    if body.carts:
        rails, size = places.axes(carts), CART * unit
        corners = np.array([-size, size.conjugate(), size, -size.conjugate()])
        lines.update(rails=joined(rails), carts=polygons(corners, places.own[:, carts], directions_of(rails)),
                     mast=np.column_stack([places.own[:, body.carts - 1], places.points[:, 0]]))
    elif not body.leading:
        lines["ground"] = places.points[:, :1]
    if body.pinned:
        lines["held"] = places.points[:, -1:]
    if body.frames:
        lines["frames"] = np.column_stack([places.of(*point) for point in body.frames.values()])
    lines.update(springs_of(places, unit, few))
    if body.loads:
        lines["loads"] = loads_of(places, unit)
    return lines


def springs_of(places, unit, few):
    """Those to the ground, and in chains of few links those in joints."""
    body, springs, parts = places.body, places.body.springs, []
    start, end = places.spring_ends()
    coiled, slack = ~springs.slack, springs.slack
    if coiled.any():
        parts.append(coils(start[:, coiled], end[:, coiled], COIL * unit))
    if few and len(body.stiff):
        along = body.stiff[body.axis[body.stiff] != 0]
        turning = body.stiff[body.axis[body.stiff] == 0]
        zero = (places.own - places.rotation * body.axis * places.q)[:, along]
        parts.append(coils(zero, places.own[:, along], COIL * unit))
        parts.append(spirals(places.own[:, turning], places.rotation[:, turning], COIL * unit))
    lines = {"springs": np.concatenate(parts, axis=1)} if parts else {}
    if len(springs.link):
        lines["anchors"] = start
    if slack.any():
        lines["ropes"] = ropes(start[:, slack], end[:, slack], springs.rest[slack], body.down)
    return lines


class Pose:
    """The lines of a chain on matplotlib's axes, at one of the instants of lines_of()."""

    def __init__(self, axes, lines, colour, springs=None):
        colours = dict.fromkeys(("springs", "ropes"), springs or colour)
        self.artists = {name: axes.plot([], [], **{"color": colours.get(name, colour), **STYLES[name][1]})[0] for name in lines}

    def show(self, lines, k):
        for name, artist in self.artists.items():
            artist.set_data(lines[name][k].real, lines[name][k].imag)


def legend_of(axes, names):
    """Empty lines with the names of what is drawn, in grey."""
    for name in STYLES:
        label, style = STYLES[name]
        if name in names and label:
            is_outline = name in ("carts", "boxes")
            mark = {"linestyle": "", "marker": "s", "markersize": 8, "markerfacecolor": "none"} if is_outline else {}
            axes.plot([], [], label=label, **{"color": GREY, **style, **mark})


class View:
    """The part of the plane that a picture shows: all of `drawn`, and at least half of the reach to each side of its middle."""

    def __init__(self, drawn, reach):
        self.middle = complex((drawn.real.min() + drawn.real.max()) / 2, (drawn.imag.min() + drawn.imag.max()) / 2)
        self.size = np.maximum(np.array([np.ptp(drawn.real), np.ptp(drawn.imag)]) * (1 + 2 * FREE), 0.5 * reach)

    def box(self, widest, highest, least):
        """The size of its picture, inch."""
        return np.maximum(self.size * min(widest / self.size[0], highest / self.size[1]), least)

    def limit(self, axes, box):
        """Fills the box; one metre is as long in x as in y. Returns the metres in a point of the printer."""
        inch = max(self.size / box)
        for middle, size, limit in ((self.middle.real, box[0], axes.set_xlim), (self.middle.imag, box[1], axes.set_ylim)):
            limit(middle - size * inch / 2, middle + size * inch / 2)
        return inch / 72
