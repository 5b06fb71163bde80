#!/usr/bin/python3
"""Draws a motion: angles, rates, torques, energy and the phase portrait. --strobe draws the chain itself at several instants, --movie as a
picture that moves. For many runs it draws the angles at the end and their spread.

FILE is a CSV of `simulate --csv` or of `sweep`, or a bag of `simulate --bag` or rosbag record. A bag needs joint_states; energy and
error come from the node's ~status. Panels without data are left out."""

from program import Parser, put, run, say  # isort: skip

import difflib
import os
import sys

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  the backend comes first
from chain import NoChain, read_chain  # noqa: E402
from drawing.body import Body  # noqa: E402
from files import BadOutput, require_outputs, require_picture, save_picture, scene_file, words_of  # noqa: E402
from plot_movie import movie_of, require_movie, save_movie  # noqa: E402
from plot_panels import MOST, NAMES, STILL, UNKNOWN, give_height, kinds, label_axis, panels, usual  # noqa: E402
from plot_read import Refused, read_bag, read_csv, require_file  # noqa: E402
from plot_runs import Runs, draw_runs  # noqa: E402
from plot_signals import COMMAND, REFERENCE, SENSOR  # noqa: E402
from plot_strobe import draw_strobe  # noqa: E402
from unread import ENDINGS  # noqa: E402

# The colours of Okabe and Ito, which the colour-blind can distinguish. The dashes help in black and white.
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#8C6D31", "#7F7F7F"]
DASHES = ["-", "--", "-.", ":"]
SIGNALS = {COMMAND: {"linestyle": (0, (1, 1)), "linewidth": 1.6, "alpha": 0.7},
           REFERENCE: {"linestyle": (0, (5, 2)), "linewidth": 0.9, "marker": "x", "markersize": 4},
           SENSOR: {"linestyle": "", "marker": ".", "markersize": 2.5, "alpha": 0.6}}
MOST_JOINTS = len(COLOURS)
WIDTH, HEIGHT, ROW_HEIGHT = 9.6, 6.2, 1.5  # inch: of the figure, and of a row if there are more than MOST panels
LINE = 0.19          # inch, of a legend
INSTANTS, MOST_APART = 9, 1e9  # of --strobe; m
COARSE = 0.5  # rad: where a portrait's line has sharper corners, it shows chords and no curve
CLOSE = 0.13  # of the width of a panel: events nearer than that are written one above the other


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
    axes.set_xlim(give_height(axes.get_xlim(), STILL))
    axes.set_ylim(give_height(axes.get_ylim(), STILL))
    axes.set_title("phase portrait, " + "".join(sorted(notes, reverse=True)), fontsize="medium")
    axes.locator_params(axis="x", nbins=5)
    label_axis(axes.xaxis, *kind[0])
    label_axis(axes.yaxis, *kind[1])


def draw_panel(axes, panel, names):
    """names: {joint: k}."""
    for k, (name, t, values) in enumerate(panel.curves):
        axes.plot(t, values, label=name, **(style(names[name]) if name in names else style(k, COLOURS[::-1])))
    for signal in panel.signals:
        axes.plot(signal.t, signal.values, color=style(names[signal.joint])["color"], **SIGNALS[signal.kind])
    axes.set_yscale("log" if panel.name == "error" else "linear")
    axes.set_ylim(give_height(axes.get_ylim(), panel.least))
    label_axis(axes.yaxis, panel.label, panel.unit)
    if panel.name in ("energy", "imu"):  # its names stand above it
        axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncol=4, borderaxespad=0.1, borderpad=0.1, fontsize="small",
                    frameon=False).set_in_layout(False)


def name_events(axes, motion):
    """Above the first panel, each at its time. What would cover another stands higher."""
    ends, (low, high) = [], axes.get_xlim()
    for k, name in sorted(motion.events.items()):
        place = (motion.t[k - 1] - low) / (high - low)
        row = next((row for row, end in enumerate(ends) if place >= end), len(ends))
        ends[row:row + 1] = [place + CLOSE * max(1, len(name) / 8)]
        axes.annotate(name, (motion.t[k - 1], 1.0), (0, 2 + 10 * row), xycoords=("data", "axes fraction"), textcoords="offset points",
                      fontsize="small")


def legend(axes, names, drawn, is_unknown):
    """The joints, and below them commands, references and sensors, of which those are drawn."""
    handles = [pyplot.Line2D([], [], label=name, **style(k)) for name, k in names.items()]
    handles += [pyplot.Line2D([], [], label=kind, color="#7F7F7F", **SIGNALS[kind]) for kind in SIGNALS if kind in drawn]
    axes.legend(handles=handles, loc="upper left", frameon=False, fontsize="small", ncol=columns_of(names), borderaxespad=0,
                handlelength=1.6, handletextpad=0.5, columnspacing=1.0, title_fontsize="small",
                title="joint (m if it is\nprismatic: give --scene)" if is_unknown else "joint")


def columns_of(names):
    return 2 if len(names) > 4 and max(map(len, names)) <= 12 else 1


def draw(motion, columns, title, wrap, asked=()):
    """asked: names of panels; by default the usual ones, with a note on those that do not fit."""
    each_kind, ready = kinds(motion, columns), list(panels(motion, columns, wrap))
    names_drawn, left_out = (asked, []) if asked else usual([panel.name for panel in ready], len(each_kind))
    rows = [panel for name in names_drawn for panel in ready if panel.name == name]
    portraits = each_kind if "phase" in names_drawn else []
    if not rows and not portraits:
        raise Refused(f"--panels: expected panels that this recording has ({', '.join(dict.fromkeys([*(panel.name for panel in ready), 'phase']))}), "
                      f"got {', '.join(asked)}")
    if left_out:
        say(f"note: {MOST} panels are drawn; --panels draws others, such as {' and '.join(left_out)}")
    names = {motion.joints[j]: k for k, j in enumerate(columns)}
    drawn = {signal.kind for panel in rows for signal in panel.signals}
    height = HEIGHT if len(rows) + len(portraits) <= MOST else max(HEIGHT, 0.6 + ROW_HEIGHT * len(rows))
    figure = pyplot.figure(figsize=(WIDTH, height), constrained_layout={"h_pad": 0.09})
    figure.suptitle(title)
    # Two grids side by side: what stands on the right does not push the rows on the left apart.
    left, right = figure.add_gridspec(1, 2, width_ratios=[2 if rows else 0.01, 1 if portraits else 0.5])
    legend_height = LINE * (2.5 + np.ceil(len(names) / columns_of(names)) + len(drawn))
    portrait_height = max((height - 0.6 - legend_height) / max(len(portraits), 1.6), 1.0)
    rest = max(height - 0.6 - legend_height - portrait_height * len(portraits), 0.01)
    right = right.subgridspec(len(portraits) + 2, 1, height_ratios=[*[portrait_height] * len(portraits), legend_height, rest])

    left, first = left.subgridspec(max(len(rows), 1), 1), None
    for row, panel in enumerate(rows):
        axes = figure.add_subplot(left[row], sharex=first)
        first = first or axes
        draw_panel(axes, panel, names)
        for k in motion.events:
            axes.axvspan(motion.t[k - 1], motion.t[k], color="#7F7F7F", alpha=0.3, linewidth=0.8)
        axes.label_outer()
    if rows:
        first.set_xlim(motion.t[0] - 0.02 * np.ptp(motion.t), motion.t[-1] + 0.02 * np.ptp(motion.t))
        axes.tick_params(labelbottom=True)
        label_axis(axes.xaxis, "time", "s")
        name_events(first, motion)
    for row, (kind, ours) in enumerate(portraits):
        draw_phase(figure.add_subplot(right[row]), motion, kind, {j: names[motion.joints[j]] for j in ours})
    legend(figure.add_subplot(right[len(portraits)], frame_on=False, xticks=[], yticks=[]), names, drawn, each_kind[0][0] is UNKNOWN)
    return figure


# ---- The chain itself --------------------------------------------------------------------------


def body_of(option, scene, motion):
    """scene: a path or the name of one that ships; None: that of the recording."""
    body = motion.body if scene is None else Body(read_chain(scene))
    if body is None:
        raise Refused(f"{option}: expected --scene SCENE beside a recording without one, got none")
    if body.joints != motion.joints:
        raise Refused(f"{option}: expected the scene of {listed(motion.joints)}, got that of {listed(body.joints)}")
    return body


def track_of(option, scene, motion):
    body = body_of(option, scene, motion)
    if body.moves and motion.first is None:
        raise Refused(f"{option}: expected a bag with ~link_states, as the base of the scene moves, got none")
    return motion.track(body)


def points_of(body, named):
    """Those of the option --point, by their names; by default the tip."""
    if not named:
        return {"the tip" if body.pin[-1] else "the last joint": body.point("tip")}  # of a URDF without a frame beyond
    points = {}
    for text in named:
        name, *numbers = text.rsplit(",", 2) if text.count(",") >= 2 else [text]
        try:
            at = [float(number) for number in numbers] or None
            if not np.isfinite(at or 0).all():
                raise ValueError
            points[text] = body.point(name, at)
        except ValueError:
            raise Refused(f"--point: expected LINK,x,y with a link of {listed(body.names)}, a frame of the scene, or tip, got {text}") from None
    return points


def strobe(motion, scene, given, apart, title, named=()):
    track = track_of("--strobe", scene, motion)
    if not abs(apart) <= MOST_APART:
        raise Refused(f"--apart: expected a number up to {MOST_APART:g}, got {apart}")
    first, last = motion.t[0], motion.t[-1]
    times = np.sort(given) if given else np.linspace(first, last, INSTANTS)
    if len(set(times)) < 2 or not first <= times[0] <= times[-1] <= last:
        raise Refused(f"--at: expected two times or more from {first:g} to {last:g} s, got "
                      f"{listed([f'{t:g}' for t in given])}")
    return draw_strobe(track, times, apart, f"{title}: {os.path.basename(scene)}", points_of(track.body, named))


def movie(given, motions):
    scenes = given.scene * len(motions) if len(given.scene) == 1 else given.scene or [None] * len(motions)
    if len(scenes) != len(motions):
        raise Refused(f"--scene: expected one, or one for each of {len(motions)} files, got {len(scenes)}")
    if not 0 < given.speed < np.inf:
        raise Refused(f"--speed: expected a number above 0, got {given.speed}")
    tracks = [track_of("--movie", scene, motion) for scene, motion in zip(scenes, motions)]
    return movie_of(tracks, list(map(os.path.basename, given.file)), [points_of(track.body, given.point) for track in tracks], given.speed)


# ---- The program -------------------------------------------------------------------------------


def arguments():
    parser = Parser(prog="plot", description=__doc__.replace("\n\n", " ").replace("\n", " "))
    parser.add_argument("file", metavar="FILE", nargs="+", help="a .csv or a .bag; several with --movie")
    parser.add_argument("--joints", nargs="+", default=[], metavar="JOINT",
                        help=f"joints to draw (default: all, or {MOST_JOINTS} of them, evenly along the chain)")
    parser.add_argument("--panels", nargs="+", default=[], choices=NAMES, metavar="PANEL",
                        help=f"what to draw of {', '.join(NAMES)} (default: the first five, at most {MOST} panels). "
                             "imbalance is that of the energy, error the estimated one")
    parser.add_argument("--from", dest="first", type=float, metavar="T", help="draws only what comes after, s since the first state")
    parser.add_argument("--to", dest="last", type=float, metavar="T", help="draws only what comes before")
    parser.add_argument("--node", help="node, such as /left/planar_chain, if the bag has several")
    parser.add_argument("--scene", action="append", default=[],
                        help="scene of a CSV, or of a bag without planar_chain/scene; for --movie, and to tell which joints are prismatic. "
                             "Give it again for each of several files")
    parser.add_argument("--output", metavar="OUT", help="a .png, .svg or .pdf (default: FILE.png)")
    parser.add_argument("--wrap", action="store_true", help="draws angles in (-pi, pi]")
    parser.add_argument("--strobe", metavar="SCENE", help="draws the chain in the plane")
    parser.add_argument("--at", nargs="+", type=float, default=[], metavar="T",
                        help=f"instants of --strobe, s since the first state (default: {INSTANTS} in equal steps)")
    parser.add_argument("--apart", type=float, metavar="D",
                        help="distance by which --strobe moves each instant to the right of the previous one, m")
    parser.add_argument("--movie", metavar="FILE", help="writes a .gif, .mp4 or .html of the chain in motion; of several files side by side")
    parser.add_argument("--speed", type=float, metavar="X", help="seconds of motion in a second of --movie (default 1)")
    parser.add_argument("--point", nargs="+", default=[], metavar="LINK,x,y",
                        help="points whose path --strobe and --movie draw: of a link, m in its frame; a frame of the scene; "
                             "LINK alone: its outer pin (default: tip)")
    parser.add_argument("--dark", action="store_true", help="for a dark screen")
    return parser.parse_args()


def require_together(given):
    """Raises Refused for options that have no effect beside the others."""
    if (given.at or given.apart is not None) and given.strobe is None:
        raise Refused("--at and --apart: expected --strobe SCENE beside them, got nothing")
    if given.point and given.strobe is None and given.movie is None:
        raise Refused("--point: expected --strobe SCENE or --movie FILE beside it, got nothing")
    if given.speed is not None and given.movie is None:
        raise Refused("--speed: expected --movie FILE beside it, got nothing")
    for option, others in (("strobe", ("joints", "panels", "scene", "wrap", "movie")), ("movie", ("joints", "panels", "wrap", "output"))):
        beside = [f"--{name}" for name in others if getattr(given, name)]
        if getattr(given, option) is not None and beside:
            raise Refused(f"--{option}: expected no {' and no '.join(beside)} beside it, got both")
    if len(given.file) > 1 and given.movie is None:
        raise Refused(f"expected one file, or --movie FILE beside several, got {', '.join(given.file)}")
    if len(given.scene) > 1 and given.movie is None:
        raise Refused(f"--scene: expected one, got {', '.join(given.scene)}")


def read(given, path):
    motion = read_bag(path, given.node) if path.endswith(ENDINGS) else read_csv(path)
    if isinstance(motion, Runs):
        for option in ("strobe", "movie", "panels", "first", "last"):
            if getattr(given, option):
                name = {"first": "from", "last": "to"}.get(option, option)
                raise Refused(f"--{name}: expected one motion, got many runs")
        return motion
    if np.isnan(motion.q).all():
        raise Refused(f"{path}: expected angles, got nan alone")
    first, last = (end if end is not None else motion.t[k] for end, k in ((given.first, 0), (given.last, -1)))
    if np.count_nonzero((motion.t >= first) & (motion.t <= last)) < 2:
        raise Refused(f"--from and --to: expected two states of {path} or more between them, of {motion.t[0]:g} to {motion.t[-1]:g} s, got "
                      f"{first:g} and {last:g} s")
    motion.cut(first, last)
    return motion


def picture(given, motion):
    columns, title = chosen(motion, given.joints), os.path.basename(given.file[0])
    if given.strobe is not None:
        return strobe(motion, given.strobe, given.at, given.apart or 0.0, title, given.point)
    for scene in given.scene:
        motion.know(body_of("--scene", scene, motion))
    if not given.joints and len(columns) < len(motion.joints):
        title += f": {len(columns)} of {len(motion.joints)} joints"
    if isinstance(motion, Runs):
        return draw_runs(motion, columns, title, given.wrap, COLOURS[0])
    return draw(motion, columns, title, given.wrap, given.panels)


def main():
    given = arguments()
    output = given.movie or given.output or given.file[0] + ".png" if given.output != "" else ""
    try:
        for path in given.file:
            require_file(path)
        if given.movie is not None:
            require_movie("--movie", given.movie)
        else:
            require_picture("--output", output)
        if given.node is not None and not all(path.endswith(ENDINGS) for path in given.file):
            raise Refused(f"--node: expected a bag beside it, got {', '.join(given.file)}")
        scenes = [*given.scene, *([given.strobe] if given.strobe else [])]
        require_outputs([("--movie" if given.movie is not None else "--output", output)], [*given.file, *map(scene_file, filter(None, scenes))])
        require_together(given)
        given.speed = 1.0 if given.speed is None else given.speed
        pyplot.style.use(["default", "dark_background"] if given.dark else "default")
        pyplot.rcParams.update({"axes.grid": True, "grid.alpha": 0.3, "lines.linewidth": 1.3})
        motions = [read(given, path) for path in given.file]
        drawn = picture(given, motions[0]) if given.movie is None else movie(given, motions)
    except (OSError, UnicodeDecodeError) as problem:
        raise Refused(words_of(problem)) from problem
    if given.movie is None:
        save_picture(drawn, output, dpi=130)
    else:
        save_movie(drawn, output)
    put(f"written to {output}\n")
    return 0


if __name__ == "__main__":
    sys.exit(run(main, (BadOutput, NoChain, Refused)))
