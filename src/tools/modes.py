#!/usr/bin/python3
"""Prints the modes of a scene about an equilibrium: frequencies, damping ratios, shapes. With --plot it draws the chain in each.

A mode that grows is unstable. One with a real pole, without oscillation, is overdamped, or decays without dampers. Exit status: 0 done;
1 it cannot be written; 2 bad arguments, a scene with faults, or a pose that is no equilibrium."""

from program import Parser, put, run, say  # isort: skip

import argparse
import os
import sys

from chain import NoChain, read_chain
from drawing.body import Body, Places
from files import notes_by, require_outputs, require_picture, save_picture, scene_file
from user_input import read_numbers, read_torques
try:
    import numpy as np

    from planar_chain import Scene, modes
except ImportError as missing:
    sys.exit(f"modes: {missing}")

MOST = 12  # panels
COLUMNS, PANEL, WIDEST, WIDTH = 4, 2.6, 4.5, 7.5  # inch: width of a panel at least and at most; of the drawing at least
ABOVE = 0.5                   # inch: of a panel's title and numbers
SLIM, HIGHEST = 0.6, 1.5      # height of a panel at least and at most, of its width
SWING, BEND = 0.2, 0.6        # of the reach: the way of the pin that moves most; rad: most in a joint
ALONG, BESIDE = 0.2, 0.25     # a swing with a smaller share across the links covers the chain: so far beside it, of the reach, it is drawn
SMALL = 1e-4                  # of a shape: it moves pins in proportion
AT_REST, FORTH, BACK = "#7F7F7F", "#0072B2", "#D55E00"


def arguments():
    parser = Parser(prog="modes", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", metavar="SCENE", help="a YAML file, a URDF, or the name of a scene that ships")
    parser.add_argument("--q", metavar="A,B,…",
                        help="the equilibrium, rad, m for prismatic joints (default: that of `equations --equilibrium`)")
    parser.add_operating_point()
    parser.add_argument("--plot", metavar="FILE", help=f"a .png, .svg or .pdf with the first {MOST} modes")
    return parser.parse_args()


def ways(body, q, shapes):
    """The pins at rest; how each shape moves them, row by row."""
    at = Places(body, np.zeros((shapes.shape[1] + 1, 3)), np.array([q, *(q + SMALL * shape for shape in shapes.T)])).points
    return at[0], (at[1:] - at[0]) / SMALL


def deflections(body, q, shapes):
    """The ± amplitude of each mode, n × k: as large as SWING and BEND allow."""
    way = abs(ways(body, q, shapes)[1]).max(axis=1)
    turn = np.abs(np.where(body.axis[:, np.newaxis] == 0, shapes, 0)).max(axis=0)
    return shapes * np.minimum(SWING * body.reach / np.maximum(way, 1e-300), BEND / np.maximum(turn, 1e-300))


def beside(body, q, shapes):
    """The way, complex, m, by which the chain is drawn beside itself in each mode: 0 unless it moves along its links."""
    rest, moves = ways(body, q, shapes)
    along = np.diff(rest)
    across = abs((moves[:, 1:] * along.conj()).imag / np.maximum(abs(along), 1e-300)).max(axis=1, initial=0)
    covers = (across < ALONG * abs(moves).max(axis=1)) * (len(along) > 0)
    return covers * BESIDE * body.reach * (1 if np.ptp(rest.imag) > np.ptp(rest.real) else 1j)


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
    from drawing.poses import Pose, View, in_view, lines_of  # pylint: disable=import-outside-toplevel
    body = Body(read_chain(scene))
    count = min(MOST, len(mode.kinds))
    a = deflections(body, mode.q, mode.shapes.real[:, :count])
    # Rows: at rest, then forth and back of each mode.
    q = np.vstack([mode.q, *(mode.q + sign * a[:, k] for k in range(count) for sign in (1, -1))])
    places = Places(body, np.zeros((len(q), 3)), q, shift=[0, *np.outer(beside(body, mode.q, a), [1, -1]).ravel()])
    view = View(in_view(places), body.reach)
    rows, columns = -(-count // COLUMNS), min(count, COLUMNS)
    width = np.clip(WIDTH / columns, PANEL, WIDEST)
    box = np.array([width, width * np.clip(view.size[1] / view.size[0], SLIM, HIGHEST)])
    figure, panels = pyplot.subplots(rows, columns, figsize=(box[0] * columns, (box[1] + ABOVE) * rows), squeeze=False, constrained_layout=True)
    figure.suptitle(title, fontsize="medium")
    for k, axes in enumerate(panels.flat):
        if k >= count:
            axes.axis("off")
            continue
        lines = lines_of(places, view.limit(axes, box))
        for pose, colour in ((0, AT_REST), (2 * k + 1, FORTH), (2 * k + 2, BACK)):
            Pose(axes, lines, colour).show(lines, pose)
        axes.set_title(title_of(mode, k), fontsize="small", color="#B00000" if mode.kinds[k] == "unstable" else "black")
        axes.set_aspect("equal")
        axes.tick_params(labelsize="x-small")
        axes.grid(alpha=0.3)
    return figure


def main():
    given = arguments()
    require_picture("--plot", given.plot)
    require_outputs([("--plot", given.plot)], [scene_file(given.scene)])
    with notes_by(say):
        scene = Scene.from_file(given.scene)
        mode = modes(scene, read_numbers("--q", given.q, ValueError), tau=read_torques("--tau", given.tau, ValueError), friction=given.friction)
    name = os.path.basename(given.scene)
    about = [f"{letter} = {', '.join(f'{number:.6g}' for number in numbers)}" for letter, numbers in (("q", mode.q), ("tau", mode.tau))
             if letter == "q" or numbers.any()]
    text = f"{name} at {'; '.join(about)}\n" * (len(mode.q) <= MOST) + f"{mode}\n"
    if given.plot:
        count = len(mode.kinds)
        save_picture(draw(given.scene, mode, f"modes of {name}, m" + f" (the first {MOST} of {count})" * (count > MOST)), given.plot, dpi=130)
        text += f"written to {given.plot}\n"
    put(text)
    return 0


if __name__ == "__main__":
    sys.exit(run(main, (NoChain, ValueError)))
