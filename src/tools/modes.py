#!/usr/bin/python3
"""Prints the modes of a scene about an equilibrium: frequencies, damping ratios, shapes. With --plot it draws the chain in each.

A mode that grows is unstable. One with a real pole, without oscillation, is overdamped, or decays without dampers. Exit status: 0 done;
1 it cannot be written; 2 bad arguments, a scene with faults, or a pose that is no equilibrium."""

from program import Parser, put, run, say  # isort: skip

import argparse
import os
import sys

from chain import NoChain
from files import notes_by, require_outputs, require_picture, save_picture, scene_file
from user_input import read_numbers
try:
    import numpy as np

    from planar_chain import Scene, modes
except ImportError as missing:
    sys.exit(f"modes: {missing}")

MOST = 12  # panels
COLUMNS, PANEL = 4, 2.6  # inch
SWING, BEND = 0.2, 0.6        # of the reach: the way of the pin that moves most; rad: most in a joint
FREE, SLIM = 0.08, 0.6        # of the drawing's larger side: around it; the smaller side at least
AT_REST, FORTH, BACK = {"color": "#7F7F7F"}, {"color": "#0072B2"}, {"color": "#D55E00"}


def arguments():
    parser = Parser(prog="modes", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", metavar="SCENE", help="a YAML file, a URDF, or the name of a scene that ships")
    parser.add_argument("--q", metavar="A,B,…",
                        help="the equilibrium, rad, m for prismatic joints (default: that of `equations --equilibrium`)")
    parser.add_argument("--plot", metavar="FILE", help=f"a .png, .svg or .pdf with the first {MOST} modes")
    return parser.parse_args()


def deflections(links, q, shapes):
    """The ± amplitude of each mode, n × k: as large as SWING and BEND allow."""
    from plot_strobe import pins  # pylint: disable=import-outside-toplevel  # matplotlib takes a second
    reach = np.sum(abs(links.pin)) or 1.0
    small = 1e-4
    way = [abs(np.subtract(*pins(links, np.zeros((2, 3)), np.array([q + small * shape, q]))[0])).max() / small for shape in shapes.T]
    turn = np.abs(np.where(links.axis[:, np.newaxis] == 0, shapes, 0)).max(axis=0)
    return shapes * np.minimum(SWING * reach / np.maximum(way, 1e-300), BEND / np.maximum(turn, 1e-300))


def title_of(mode, k):
    kind, s = mode.kinds[k], mode.poles[k]
    if kind == "oscillates":
        return f"{k + 1}: {mode.frequencies[k]:.4g} Hz, ζ = {mode.damping[k]:.2g}"
    return f"{k + 1}: {kind}" + (f", s = {s.real:.3g}{f' ± {s.imag:.3g}i' if s.imag else ''}/s" if s else "")


def draw(scene, mode, title):
    """Each mode in a panel: the chain at rest, and at ± amplitude."""
    import matplotlib  # pylint: disable=import-outside-toplevel
    matplotlib.use("Agg")
    from matplotlib import pyplot  # pylint: disable=import-outside-toplevel
    from plot_strobe import Links, axes_of, draw_instant, is_aside, pins, spans_of  # pylint: disable=import-outside-toplevel
    links = Links(scene)
    count = min(MOST, len(mode.kinds))
    a = deflections(links, mode.q, mode.shapes.real[:, :count])
    # Rows of pins(): at rest, then forth and back of each mode.
    q = np.vstack([mode.q, *(mode.q + sign * a[:, k] for k in range(count) for sign in (1, -1))])
    base = np.zeros((len(q), 3))
    poses = list(zip(*pins(links, base, q), axes_of(links, base, q, spans_of(links, q))))
    drawn = np.concatenate([part.ravel() for pose in poses for part in pose])
    aside = np.flatnonzero(is_aside(links, np.sum(abs(links.pin))))
    rows, columns = -(-count // COLUMNS), min(count, COLUMNS)
    figure, panels = pyplot.subplots(rows, columns, figsize=(PANEL * columns, PANEL * rows + 0.4), squeeze=False, constrained_layout=True)
    figure.suptitle(title)
    for k, axes in enumerate(panels.flat):
        if k >= count:
            axes.axis("off")
            continue
        for pose, paint in ((0, AT_REST), (2 * k + 1, FORTH), (2 * k + 2, BACK)):
            draw_instant(axes, links, aside, *poses[pose], **paint)
        axes.set_title(title_of(mode, k), fontsize="small", color="#B00000" if mode.kinds[k] == "unstable" else "black")
        axes.set_aspect("equal")
        largest = max(np.ptp(drawn.real), np.ptp(drawn.imag))
        for values, limit in ((drawn.real, axes.set_xlim), (drawn.imag, axes.set_ylim)):
            half, middle = max(np.ptp(values), SLIM * largest) / 2 + FREE * largest, (values.min() + values.max()) / 2
            limit(middle - half, middle + half)
        axes.tick_params(labelsize="x-small")
        axes.grid(alpha=0.3)
    return figure


def main():
    given = arguments()
    require_picture("--plot", given.plot)
    require_outputs([("--plot", given.plot)], [scene_file(given.scene)])
    with notes_by(say):
        scene = Scene.from_file(given.scene)
        mode = modes(scene, read_numbers("--q", given.q, ValueError))
    name = os.path.basename(given.scene)
    text = f"{name} at q = {', '.join(f'{angle:.6g}' for angle in mode.q)}\n" * (len(mode.q) <= MOST) + f"{mode}\n"
    if given.plot:
        count = len(mode.kinds)
        save_picture(draw(given.scene, mode, f"modes of {name}, m" + f" (the first {MOST} of {count})" * (count > MOST)), given.plot, dpi=130)
        text += f"written to {given.plot}\n"
    put(text)
    return 0


if __name__ == "__main__":
    sys.exit(run(main, (NoChain, ValueError)))
