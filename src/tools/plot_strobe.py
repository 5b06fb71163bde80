"""Draws the chain at several instants, as under a stroboscope. For plot."""

import numpy as np
from chain import read_chain
from matplotlib import pyplot
from matplotlib.colors import ListedColormap, Normalize

FEW_LINKS = 12          # in chains of at most so many links every pin is marked
ASIDE = 0.02            # in units of the reach; a centre of mass further from its link gets a line of its own
WIDEST, HIGHEST = 7.0, 5.5     # inch, size of the drawing at most
LEAST = 2.4, 1.5               # inch, width and height at least
LEFT, RIGHT, BELOW, ABOVE = 0.85, 1.35, 1.05, 0.45  # inch, around it
STAYS = 1e-6                   # of the reach: a pinned tip that moves less has no path
FREE = 0.06                    # of the drawing's size, on each side of what is drawn
GREY = "#7F7F7F"
CART = {"linestyle": "", "marker": [(-1.6, -1), (1.6, -1), (1.6, 1), (-1.6, 1), (-1.6, -1)], "markersize": 16, "markerfacecolor": "none"}
MASS = {"linestyle": ":", "marker": "s", "markersize": 6, "markevery": [-1]}  # and its lever
SPRING = {"linestyle": "--", "linewidth": 0.8, "zorder": 1.5}
FRAME = {"linestyle": "", "marker": "x", "markersize": 7, "markeredgewidth": 1.2}
AXIS = {"linewidth": 5, "alpha": 0.35, "solid_capstyle": "butt", "zorder": 1}
BOX = [-1 - 1j, 1 - 1j, 1 + 1j, -1 + 1j, -1 - 1j]  # on it, at the point of the link that moves along it


class Links:
    """pin, com: of each link in chain order, complex, m. names; joints: theirs. moves: the base does. axis: of a prismatic joint in the frame
    of the link before, complex; 0 of others. leading: how many prismatic joints are first. carts: the same, or 0 for a free chain.
    inner: the prismatic joints further on. limits: lower and upper ones, m. pinned: the tip is.
    grounds: the points of the ground to which springs tie links, complex, m. marked, marks: the link and the point of each spring, then of
    each frame."""

    def __init__(self, scene):
        chain = read_chain(scene)
        self.moves, self.pinned = "base" in chain, "pin" in chain.get("tip", ())
        links = chain["links"]
        self.joints = [link["joint"]["name"] for link in links]
        self.axis = np.array([complex(*link["joint"].get("axis", (0, 0))) for link in links])
        self.names = names = [link["name"] for link in links]
        self.leading = int(np.argmax(np.append(self.axis, 0) == 0))
        self.inner = np.flatnonzero(self.axis[self.leading:]) + self.leading
        self.limits = np.array([[link["joint"].get(key) for key in ("lower", "upper")] for link in links], dtype=float)  # NaN: none
        is_free = names[:2] == [name + axis for name in names[2:3] for axis in ("_x", "_y")]
        self.carts = 0 if is_free else self.leading
        springs, frames = chain.get("springs", {}).values(), chain.get("frames", {}).values()
        self.grounds = np.array([complex(*spring["ground"]) for spring in springs], dtype=complex)
        self.marked = [names.index(one["link"]) for one in (*springs, *frames)]
        self.marks = np.array([complex(*one["point"]) for one in (*springs, *frames)], dtype=complex)
        self.pin, self.com = (np.array([complex(*link[key]) for link in links]) for key in ("pin", "com"))


def base_of(links, motion):
    """x, y (m) and angle (rad) of the ground pin at each state: columns."""
    if not links.moves:
        return np.zeros((len(motion.t), 3))
    com, angle, q = motion.first[:, 0] + 1j * motion.first[:, 1], motion.first[:, 2], motion.q[:, 0]
    pin = com - np.exp(1j * angle) * (links.com[0] + q * links.axis[0])
    return np.column_stack([pin.real, pin.imag, angle - q * (links.axis[0] == 0)])


def rotations(links, base, q):
    """exp(iθ) of each link. base, q: one row for each instant."""
    return np.exp(1j * (base[:, 2:] + np.cumsum(np.where(links.axis == 0, q, 0), axis=1)))


def pins(links, base, q):
    """Arrays, complex, m: the inner pin of the first link that turns and all outer pins from there on; the centres of mass;
    the inner pins, of links with prismatic joints their own points."""
    ground = (base[:, 0] + 1j * base[:, 1])[:, np.newaxis]
    rotation = rotations(links, base, q)
    outer = np.concatenate([ground, ground + np.cumsum(rotation * (q * links.axis + links.pin), axis=1)], axis=1)
    own = outer[:, :-1] + rotation * q * links.axis
    return outer[:, links.leading:], own + rotation * links.com, own


def axes_of(links, base, q, spans):
    """The ends of the axes of inner prismatic joints at each instant: instants × joints × 2. spans: from where to where they are drawn, m,
    a row for each joint."""
    direction = (rotations(links, base, q) * links.axis)[:, links.inner]
    zero = pins(links, base, q)[2][:, links.inner] - direction * q[:, links.inner]
    return zero[..., np.newaxis] + direction[..., np.newaxis] * spans


def spans_of(links, q):
    """Those to the limits, but not far beyond where the motion gets; to there without limits."""
    q, reach = q[:, links.inner], np.sum(abs(links.pin))
    low, high = np.minimum(q.min(axis=0, initial=0), 0), np.maximum(q.max(axis=0, initial=0), 0)
    limits = np.where(np.isnan(links.limits[links.inner]), np.column_stack([low, high]), links.limits[links.inner])
    return np.clip(limits, (low - reach)[:, np.newaxis], (high + reach)[:, np.newaxis])


def marks_of(links, base, q):
    """The points of springs and frames at each instant: instants × points."""
    return pins(links, base, q)[2][:, links.marked] + rotations(links, base, q)[:, links.marked] * links.marks


def is_aside(links, reach):
    """True for each centre of mass that does not lie on the line from pin to pin."""
    along = np.clip((links.com * links.pin.conj()).real / np.maximum(abs(links.pin) ** 2, 1e-300), 0, 1)
    return abs(links.com - along * links.pin) > ASIDE * reach


def at(motion, values, times):
    """Values of each state at these times, interpolated linearly between states. Before an event the last ones stay."""
    events = sorted(motion.events)
    t = np.insert(motion.t, events, motion.t[events])
    values = np.insert(values, events, values[[k - 1 for k in events]], axis=0)
    return np.column_stack([np.interp(times, t, column) for column in values.T])


def frame(drawn, reach):
    """A figure with the axes of the plane and of the colours. One metre is as long in x as in y. The plane is as large as
    what is drawn, complex, m, and at least half of the chain's reach to each side of its middle."""
    sizes = np.array([np.ptp(drawn.real), np.ptp(drawn.imag)]) * (1 + 2 * FREE)
    sizes = np.maximum(sizes, 0.5 * reach)
    inch = min(WIDEST / sizes[0], HIGHEST / sizes[1])  # a metre
    width, height = np.maximum(sizes * inch, LEAST)
    figure = pyplot.figure(figsize=(LEFT + width + RIGHT, BELOW + height + ABOVE))
    w, h = figure.get_size_inches()
    axes = figure.add_axes([LEFT / w, BELOW / h, width / w, height / h])
    for values, size, limit in ((drawn.real, width, axes.set_xlim), (drawn.imag, height, axes.set_ylim)):
        middle = (values.min() + values.max()) / 2
        limit(middle - size / inch / 2, middle + size / inch / 2)
    axes.locator_params(nbins=6)
    return figure, axes, figure.add_axes([(LEFT + width + 0.25) / w, BELOW / h, 0.2 / w, height / h])


def draw_instant(axes, links, aside, chain, coms, starts, along, **paint):
    """chain, coms, starts: rows of pins(). along: of axes_of(). aside: the links that have a line to their centre of mass."""
    places = links.inner - links.leading + 1  # behind a prismatic joint the line begins anew
    line = np.insert(chain, np.repeat(places, 2), np.column_stack([np.full(len(places), np.nan), starts[links.inner]]).ravel())
    axes.plot(line.real, line.imag, "-", marker="o" * (len(links.pin) <= FEW_LINKS), markersize=3, linewidth=1.6, **paint)
    for lever in zip(starts[aside], coms[aside]):
        axes.plot(np.real(lever), np.imag(lever), **MASS, **paint)
    for ends, at_box in zip(along, starts[links.inner]):
        axes.plot(ends.real, ends.imag, **AXIS, **paint)
        axes.plot(at_box.real, at_box.imag, **box(np.angle(ends[1] - ends[0])), **paint)
    if links.carts:
        carts = starts[:links.carts]
        axes.plot(carts.real, carts.imag, **CART, **paint)
        axes.plot([carts[-1].real, chain[0].real], [carts[-1].imag, chain[0].imag], linewidth=0.6, color=GREY, zorder=0)


def draw_marks(axes, links, marks, shift, **paint):
    """marks: a row of marks_of(). shift: of this instant, m."""
    for x, ground in zip(marks, links.grounds + shift):
        axes.plot([ground.real, x.real], [ground.imag, x.imag], **SPRING, **paint)
    frames = marks[len(links.grounds):]
    axes.plot(frames.real, frames.imag, **FRAME, **paint)


def box(angle):
    """The marker of a link on its axis, which has this angle."""
    corners = np.exp(1j * angle) * np.array(BOX)
    return {"linestyle": "", "marker": np.column_stack([corners.real, corners.imag]), "markersize": 8, "markerfacecolor": "white"}


def draw_strobe(motion, links, times, apart, title):
    """apart: distance by which each instant is moved to the right of the previous one, m."""
    # The chain at each instant, and the path of its tip, broken at events.
    base = base_of(links, motion)
    seen = (motion.t >= times[0]) & (motion.t <= times[-1])
    shift = apart * np.arange(len(times))[:, np.newaxis]
    now = at(motion, base, times), at(motion, motion.q, times)
    points, coms, starts = (each + shift for each in pins(links, *now))
    along = axes_of(links, *now, spans_of(links, motion.q[seen])) + shift[..., np.newaxis]
    marks, grounds = marks_of(links, *now) + shift, links.grounds + shift
    tip = np.where(seen, pins(links, base, motion.q)[0][:, -1] + np.interp(motion.t, times, shift[:, 0]), np.nan)
    trail = np.insert(tip, sorted(motion.events), np.nan)
    aside = np.flatnonzero(is_aside(links, np.sum(abs(links.pin))))

    figure, axes, bar = frame(np.concatenate([points.ravel(), tip[seen], coms[:, aside].ravel(), starts[:, :links.carts].ravel(),
                                              starts[:, links.inner].ravel(), along.ravel(), marks.ravel(), grounds.ravel()]),
                              np.sum(abs(links.pin)) or 1.0)

    # Light is early, dark is late; neither end fades into a white or a black page.
    colour = ListedColormap(pyplot.get_cmap("viridis_r")(np.linspace(0.2, 0.85, 256)))
    span = Normalize(times[0], times[-1])
    stays = links.pinned and np.ptp(tip[seen].real) + np.ptp(tip[seen].imag) < STAYS * np.sum(abs(links.pin))
    if not stays:
        name = "tip" if links.pin[-1] else "last joint"  # of a URDF without a frame beyond
        axes.plot(trail.real, trail.imag, color="#D55E00", linewidth=0.8, label="path of the " + name)
    for t, by, its_marks, *instant in zip(times, shift[:, 0], marks, points, coms, starts, along):
        draw_instant(axes, links, aside, *instant, color=colour(span(t)))
        draw_marks(axes, links, its_marks, by, color=colour(span(t)))
    if len(links.grounds):
        axes.plot([], [], color=GREY, label="spring to the ground", **SPRING)
        axes.plot(grounds.real, grounds.imag, "^", markersize=6, color=GREY, zorder=0)
    if len(links.marks) > len(links.grounds):
        axes.plot([], [], color=GREY, label="frame", **FRAME)
    if links.carts:
        axes.plot([], [], color=GREY, label="cart", **CART)
    elif not links.leading:
        ground = points[:, 0] if apart or links.moves else points[:1, 0]
        axes.plot(ground.real, ground.imag, "^", markersize=9, color=GREY, label="ground pin", zorder=0)
    if len(links.inner):
        axes.plot([], [], color=GREY, label="prismatic joint", **box(0))
    if len(aside):
        axes.plot([], [], color=GREY, label="centre of mass", **MASS)
    if links.pinned:
        axes.plot(points[:, -1].real, points[:, -1].imag, "s", markersize=8, color=GREY, label="pin of the tip", zorder=0)
    figure.suptitle(title, y=1 - 0.1 / figure.get_figheight(), va="top")
    axes.set(xlabel="x (m)", ylabel="y (m)")
    figure.legend(*axes.get_legend_handles_labels(), fontsize="small", loc="lower center", ncol=3, frameon=False)
    figure.colorbar(pyplot.cm.ScalarMappable(span, colour), cax=bar, label="time (s)")
    bar.hlines(times, 0, 1, color="white", linewidth=0.8)
    return figure
