#!/usr/bin/python3
"""Draws a motion: angles, rates, torques, energy and error estimate over time, and the phase portrait. With --strobe
it draws the chain itself at several instants. Of many runs it draws the angles at the end and their spread.

FILE is a CSV of `simulate --csv` or of `sweep`, or a bag of `simulate --bag` or rosbag record. A bag needs joint_states; energy and
error come from the node's ~status. Panels without data are left out."""

from program import Parser, put, run  # isort: skip

import difflib
import os
import sys

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  the backend comes first
from chain import NoChain  # noqa: E402
from files import BadOutput, require_outputs, require_picture, save_picture, scene_file, words_of  # noqa: E402
from plot_panels import STILL, UNKNOWN, give_height, kinds, label_axis, panels  # noqa: E402
from plot_read import Refused, read_bag, read_csv, require_file  # noqa: E402
from plot_runs import Runs, draw_runs  # noqa: E402
from plot_strobe import Links, draw_strobe  # noqa: E402
from unread import ENDINGS  # noqa: E402

# The colours of Okabe and Ito, which the colour-blind can distinguish. The dashes help in black and white.
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#8C6D31", "#7F7F7F"]
DASHES = ["-", "--", "-.", ":"]
MOST_JOINTS = len(COLOURS)
ROW_HEIGHT, WIDTH = 1.9, 11.0  # inch
INSTANTS, MOST_APART = 9, 1e9  # of --strobe; m
COARSE = 0.5  # rad: where a portrait's line has sharper corners, it shows chords and no curve


# ---- Drawing -----------------------------------------------------------------------------------


def listed(names):
    return ", ".join(names[:12]) + (" …" if len(names) > 12 else "")


def chosen(motion, names):
    """The columns of the joints to draw: those named, or all, or some if there are many."""
    missing = [name for name in names if name not in motion.joints]
    if missing:
        near = [match for name in missing for match in difflib.get_close_matches(name, motion.joints, 1)]
        meant = f" (did you mean {', '.join(near)}?)" if near else ""
        raise Refused(f"--joints: expected joints of {listed(motion.joints)}, got {listed(missing)}{meant}")
    n = len(motion.joints)
    some = sorted({round(k) for k in np.linspace(0, n - 1, min(n, MOST_JOINTS))})
    return [motion.joints.index(name) for name in names] or some


def style(k, colours=tuple(COLOURS)):
    return {"color": colours[k % len(colours)], "linestyle": DASHES[k // 2 % len(DASHES)]}


def is_coarse(q, qd):
    """True if one corner in ten of the line through these states is sharp."""
    steps = np.diff(q) / max(np.nanmax(abs(q)), STILL) + 1j * np.diff(qd) / max(np.nanmax(abs(qd)), STILL)
    steps = steps[abs(steps) > 1e-3]  # without gaps, and the noise of what stands still
    corners = abs(np.angle(steps[1:] * steps[:-1].conj()))
    return len(corners) > 0 and np.quantile(corners, 0.9) > COARSE


def draw_phase(axes, motion, kind, places):
    """places: {column: k}. Angles that leave (-pi, pi] come back on its other side."""
    notes = {"● the start"}
    for j, k in places.items():
        _, q, qd, _ = motion.curves(j, wrap=np.nanmax(abs(motion.q[:, j])) > np.pi)
        how = {**style(k), "marker": "", "linewidth": 0.9}
        if is_coarse(q, qd):
            how.update(linestyle="", marker=".", markersize=2)
            notes.add("\ndots: too few states for a line")
        axes.plot(q, qd, label=motion.joints[j], **how)
        axes.plot(q[0], qd[0], "o", markersize=4, color=how["color"])
    give_height(axes, STILL)
    axes.set(title="phase portrait, " + "".join(sorted(notes, reverse=True)))
    axes.locator_params(axis="x", nbins=5)
    label_axis(axes.xaxis, *kind[0])
    label_axis(axes.yaxis, *kind[1])


def draw(motion, columns, title, wrap):
    rows, each_kind = list(panels(motion, columns, wrap)), kinds(motion, columns)
    places = {j: k for k, j in enumerate(columns)}
    names = {motion.joints[j]: k for j, k in places.items()}
    beside = 2 * len(each_kind) + 1
    height = max(len(rows), beside)
    figure = pyplot.figure(figsize=(WIDTH, 0.6 + ROW_HEIGHT * height), constrained_layout={"h_pad": 0.09})
    figure.suptitle(title)
    # Two grids side by side: what stands on the right does not push the rows on the left apart.
    left, right = figure.add_gridspec(1, 2, width_ratios=[2, 1])
    left = left.subgridspec(len(rows), 1)
    right = right.subgridspec(len(each_kind) + 2, 1, height_ratios=[*[2] * len(each_kind), 1, max(height - beside, 0.01)])
    first = None

    for row, (label, unit, curves, least) in enumerate(rows):
        axes = figure.add_subplot(left[row], sharex=first)
        first = first or axes
        for k, (name, t, values) in enumerate(curves):
            axes.plot(t, values, label=name, **(style(names[name]) if name in names else style(k, COLOURS[::-1])))
        for k in motion.events:
            axes.axvspan(motion.t[k - 1], motion.t[k], color="#7F7F7F", alpha=0.3, linewidth=0.8)
        axes.set_yscale("log" if label.startswith("error") else "linear")
        give_height(axes, least)
        label_axis(axes.yaxis, label, unit)
        axes.ticklabel_format(axis="x", useOffset=False)
        axes.label_outer()
        if label == "energy":  # its names stand above it
            axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncol=4, borderaxespad=0.1, borderpad=0.1, fontsize="small",
                        frameon=False).set_in_layout(False)
    axes.tick_params(labelbottom=True)
    axes.set_xlabel("time (s)")
    for k, name in motion.events.items():
        first.annotate(name, (motion.t[k - 1], 1.02), xycoords=("data", "axes fraction"), fontsize="small")

    for row, (kind, ours) in enumerate(each_kind):
        draw_phase(figure.add_subplot(right[row]), motion, kind, {j: places[j] for j in ours})
    figure.add_subplot(right[len(each_kind)], frame_on=False, xticks=[], yticks=[]).legend(
        handles=[pyplot.Line2D([], [], label=name, **style(k)) for name, k in names.items()], loc="upper left", frameon=False,
        title="joint (m if it is prismatic: give --scene)" if each_kind[0][0] is UNKNOWN else "joint")
    return figure


def links_of(option, scene, motion):
    links = Links(scene)
    if links.joints != motion.joints:
        raise Refused(f"{option}: expected the scene of {listed(motion.joints)}, got that of {listed(links.joints)}")
    return links


def strobe(motion, scene, given, apart, title):
    links = links_of("--strobe", scene, motion)
    if not abs(apart) <= MOST_APART:
        raise Refused(f"--apart: expected a number up to {MOST_APART:g}, got {apart}")
    if links.moves and motion.first is None:
        raise Refused("--strobe: expected a bag with ~link_states, as the base of the scene moves, got none")
    first, last = motion.t[0], motion.t[-1]
    times = np.sort(given) if given else np.linspace(first, last, INSTANTS)
    if len(set(times)) < 2 or not first <= times[0] <= times[-1] <= last:
        raise Refused(f"--at: expected two times or more from {first:g} to {last:g} s, got "
                      f"{listed([f'{t:g}' for t in given])}")
    return draw_strobe(motion, links, times, apart, f"{title}: {os.path.basename(scene)}")


def arguments():
    parser = Parser(prog="plot", description=__doc__.replace("\n\n", " ").replace("\n", " "))
    parser.add_argument("file", metavar="FILE", help="a .csv or a .bag")
    parser.add_argument("--joints", nargs="+", default=[], metavar="JOINT",
                        help=f"joints to draw (default: all, or {MOST_JOINTS} of them, evenly along the chain)")
    parser.add_argument("--node", help="node, such as /left/planar_chain, if the bag has several")
    parser.add_argument("--scene", help="scene of a CSV, or of a bag without planar_chain/scene: tells which joints are prismatic, for the units")
    parser.add_argument("--output", metavar="OUT", help="a .png, .svg or .pdf (default: FILE.png)")
    parser.add_argument("--wrap", action="store_true", help="draws angles in (-pi, pi]")
    parser.add_argument("--strobe", metavar="SCENE", help="draws the chain in the plane")
    parser.add_argument("--at", nargs="+", type=float, default=[], metavar="T",
                        help=f"instants of --strobe, s since the first state (default: {INSTANTS} in equal steps)")
    parser.add_argument("--apart", type=float, metavar="D",
                        help="distance by which --strobe moves each instant to the right of the previous one, m")
    parser.add_argument("--dark", action="store_true", help="for a dark screen")
    return parser.parse_args()


def main():
    given = arguments()
    output = given.file + ".png" if given.output is None else given.output
    try:
        require_file(given.file)
        require_picture("--output", output)
        if given.node is not None and not given.file.endswith(ENDINGS):
            raise Refused(f"--node: expected a bag beside it, got {given.file}")
        require_outputs([("--output", output)], [given.file, *map(scene_file, filter(None, (given.scene, given.strobe)))])
        motion = read_bag(given.file, given.node) if given.file.endswith(ENDINGS) else read_csv(given.file)
        is_sweep = isinstance(motion, Runs)
        if not is_sweep and np.isnan(motion.q).all():
            raise Refused(f"{given.file}: expected angles, got nan alone")
        columns = chosen(motion, given.joints)
        if given.scene is not None:
            links = links_of("--scene", given.scene, motion)
            motion.prismatic, motion.links = ([name for name, axis in zip(names, links.axis) if axis != 0] for names in (links.joints, links.names))
        title = os.path.basename(given.file)
        if (given.at or given.apart is not None) and given.strobe is None:
            raise Refused("--at and --apart: expected --strobe SCENE beside them, got nothing")
        beside = [f"--{name}" for name in ("joints", "scene", "wrap") if getattr(given, name)]
        if given.strobe is not None and beside:
            raise Refused(f"--strobe: expected no {' and no '.join(beside)} beside it, got both")
        if not given.joints and given.strobe is None and len(columns) < len(motion.joints):
            title += f": {len(columns)} of {len(motion.joints)} joints"
        pyplot.style.use(["default", "dark_background"] if given.dark else "default")
        pyplot.rcParams.update({"axes.grid": True, "grid.alpha": 0.3, "lines.linewidth": 1.3})
        if is_sweep and given.strobe is not None:
            raise Refused("--strobe: expected one motion, got many runs")
        figure = (draw_runs(motion, columns, title, given.wrap, COLOURS[0]) if is_sweep
                  else strobe(motion, given.strobe, given.at, given.apart or 0.0, title) if given.strobe is not None
                  else draw(motion, columns, title, given.wrap))
    except (OSError, UnicodeDecodeError) as problem:
        raise Refused(words_of(problem)) from problem
    save_picture(figure, output, dpi=130)
    put(f"written to {output}\n")
    return 0


if __name__ == "__main__":
    sys.exit(run(main, (BadOutput, NoChain, Refused)))
