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


class Links:
    """pin, com: of each link in chain order, complex, m. joints: names. moves: the base does. rail: the direction in
    which a link slides, complex, or 0. slides: how many do, the first ones. carts: the same, or 0 for
    a free chain. pinned: the tip is."""

    def __init__(self, scene):
        chain = read_chain(scene)
        self.moves, self.pinned = "base" in chain, "pin" in chain.get("tip", ())
        links = chain["links"]
        self.joints = [link["joint"]["name"] for link in links]
        self.rail = np.array([complex(*link["joint"].get("axis", (0, 0))) for link in links])
        names = [link["name"] for link in links]
        self.slides = np.count_nonzero(self.rail)
        is_free = names[:2] == [name + axis for name in names[2:3] for axis in ("_x", "_y")]
        self.carts = 0 if is_free else self.slides
        self.pin, self.com = (np.array([complex(*link[key]) for link in links]) for key in ("pin", "com"))


def base_of(links, motion):
    """x, y (m) and angle (rad) of the ground pin at each state: columns."""
    if not links.moves:
        return np.zeros((len(motion.t), 3))
    com, angle = motion.first[:, 0] + 1j * motion.first[:, 1], motion.first[:, 2]
    pin = com - np.exp(1j * angle) * links.com[0]
    return np.column_stack([pin.real, pin.imag, angle - motion.q[:, 0]])


def pins(links, base, q):
    """Arrays, complex, m: the inner pin of the first link that turns and all outer pins from there on; the centres of mass;
    the inner pins, of links that slide their own points. base, q: one row for each instant."""
    ground = (base[:, 0] + 1j * base[:, 1])[:, np.newaxis]
    rotation = np.exp(1j * (base[:, 2:] + np.cumsum(np.where(links.rail == 0, q, 0), axis=1)))
    outer = np.concatenate([ground, ground + np.cumsum(q * links.rail + rotation * links.pin, axis=1)], axis=1)
    own = outer[:, :-1] + q * links.rail
    return outer[:, links.slides:], own + rotation * links.com, own


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


def draw_instant(axes, links, aside, chain, coms, starts, **paint):
    """chain, coms, starts: rows of pins(). aside: the links that have a line to their centre of mass."""
    axes.plot(chain.real, chain.imag, "-", marker="o" * (len(links.pin) <= FEW_LINKS), markersize=3, linewidth=1.6, **paint)
    for lever in zip(starts[aside], coms[aside]):
        axes.plot(np.real(lever), np.imag(lever), **MASS, **paint)
    if links.carts:
        carts = starts[:links.carts]
        axes.plot(carts.real, carts.imag, **CART, **paint)
        axes.plot([carts[-1].real, chain[0].real], [carts[-1].imag, chain[0].imag], linewidth=0.6, color=GREY, zorder=0)


def draw_strobe(motion, links, times, apart, title):
    """apart: distance by which each instant is moved to the right of the previous one, m."""
    # The chain at each instant, and the path of its tip, broken at events.
    base = base_of(links, motion)
    shift = apart * np.arange(len(times))[:, np.newaxis]
    points, coms, starts = (each + shift for each in pins(links, at(motion, base, times), at(motion, motion.q, times)))
    seen = (motion.t >= times[0]) & (motion.t <= times[-1])
    tip = np.where(seen, pins(links, base, motion.q)[0][:, -1] + np.interp(motion.t, times, shift[:, 0]), np.nan)
    trail = np.insert(tip, sorted(motion.events), np.nan)
    aside = np.flatnonzero(is_aside(links, np.sum(abs(links.pin))))

    figure, axes, bar = frame(np.concatenate([points.ravel(), tip[seen], coms[:, aside].ravel(), starts[:, :links.carts].ravel()]),
                              np.sum(abs(links.pin)) or 1.0)

    # Light is early, dark is late; neither end fades into a white or a black page.
    colour = ListedColormap(pyplot.get_cmap("viridis_r")(np.linspace(0.2, 0.85, 256)))
    span = Normalize(times[0], times[-1])
    stays = links.pinned and np.ptp(tip[seen].real) + np.ptp(tip[seen].imag) < STAYS * np.sum(abs(links.pin))
    if not stays:
        name = "tip" if links.pin[-1] else "last joint"  # of a URDF without a frame beyond
        axes.plot(trail.real, trail.imag, color="#D55E00", linewidth=0.8, label="path of the " + name)
    for t, *instant in zip(times, points, coms, starts):
        draw_instant(axes, links, aside, *instant, color=colour(span(t)))
    if links.carts:
        axes.plot([], [], color=GREY, label="cart", **CART)
    elif not links.slides:
        ground = points[:, 0] if apart or links.moves else points[:1, 0]
        axes.plot(ground.real, ground.imag, "^", markersize=9, color=GREY, label="ground pin", zorder=0)
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
