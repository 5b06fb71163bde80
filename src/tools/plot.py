#!/usr/bin/python3
"""Draws a motion: angles, rates, torques, energy and error estimate over time, and the phase portrait. With --strobe
it draws the chain itself at several instants. Of many runs it draws the angles at the end and their spread.

FILE is a CSV of `simulate --csv` or of `sweep`, or a bag of `simulate --bag` or rosbag record. A bag needs joint_states; energy and
error come from the node's ~status. Panels without data are left out."""

from program import Parser, put, run, say  # isort: skip

import csv
import difflib
import math
import os
import sys

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  the backend comes first
from chain import NoChain, read_chain  # noqa: E402
from files import BadOutput, require_outputs, save_picture, scene_file, words_of  # noqa: E402
from given import read_number, rows_of  # noqa: E402
from plot_panels import STILL, UNKNOWN, give_height, kinds, label_axis, panels  # noqa: E402
from plot_runs import Runs, draw_runs  # noqa: E402
from plot_strobe import Links, draw_strobe  # noqa: E402
from unread import ENDINGS, opened, topics_of  # noqa: E402

# The colours of Okabe and Ito, which the colour-blind can distinguish. The dashes help in black and white.
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#8C6D31", "#7F7F7F"]
DASHES = ["-", "--", "-.", ":"]
MOST_JOINTS = len(COLOURS)
ROW_HEIGHT, WIDTH = 1.9, 11.0  # inch
INSTANTS = 9  # of --strobe
COARSE = 0.5  # rad: where a portrait's line has sharper corners, it shows chords and no curve
LARGEST = 1e300  # of larger numbers, matplotlib cannot find the height of an axis


class Refused(Exception):
    """A fault of the input: where, what was expected, what was found."""


class Motion:
    """t: time of each state; q, qd, effort: one column for each joint. events: {k: name} where the motion is not
    continuous between the states k - 1 and k. energy: times and curves by name. balance, error: times and values.
    slides: names of the joints whose q is in m; None if that is not known.
    rounding: the error estimate that the rounding of an angle makes.
    first: x, y, angle of the first link's centre of mass, m, rad, one row for each state. effort, energy, balance, error
    and first may be None."""

    def __init__(self, joints, t, q, qd, effort=None):
        self.joints, self.t, self.q, self.qd, self.effort = joints, t, q, qd, effort
        self.energy = self.balance = self.error = self.first = self.slides = None
        self.events, self.rounding = {}, 0.0

    def curves(self, j, wrap=False):
        """t, q, q̇, τ of a joint, with NaN where lines must not join them. wrap: q in (−π, π]."""
        q, breaks = self.q[:, j], set(self.events)
        if wrap and self.joints[j] not in (self.slides or ()):
            q = q - 2 * np.pi * np.ceil((q - np.pi) / (2 * np.pi))
            breaks |= set(np.flatnonzero(abs(np.diff(q)) > np.pi) + 1)
        effort = np.zeros(len(q)) if self.effort is None else self.effort[:, j]
        return np.insert(np.array([self.t, q, self.qd[:, j], effort]), sorted(breaks), np.nan, axis=1)

    def broken(self, t, values):
        """The same for values at other times."""
        places = np.searchsorted(t, [(self.t[k - 1] + self.t[k]) / 2 for k in sorted(self.events)])
        return np.insert(t, places, np.nan), np.insert(values, places, np.nan)


# ---- Reading -----------------------------------------------------------------------------------


def require_file(path):
    try:
        with open(path, "rb"):
            pass
    except OSError as problem:
        raise Refused(f"{path}: expected a .csv or .bag that can be read, got nothing: {problem.strerror}") from problem


def require_times(path, what, t):
    """what: has a time, such as a row."""
    if len(t) < 2:
        raise Refused(f"{path}: expected two states or more, got {len(t)}")
    for k in np.flatnonzero(~(np.diff(t) > 0))[:1] + 1:
        raise Refused(f"{path}, {what} {k + 1}: expected a time after {t[k - 1]:.12g} s, got {t[k]:.12g} s")


def require_drawable(path, name, values):
    beyond = values[abs(values) > LARGEST]  # NaN is a gap
    if len(beyond):
        raise Refused(f"{path}, {name}: expected numbers up to {LARGEST:g}, got {beyond[0]:g}")


def read_rows(path):
    try:
        rows, cut = rows_of(path)
        if cut:
            say(f"note: {cut}")
        return [row for _, row in rows]
    except (UnicodeDecodeError, csv.Error) as problem:
        raise Refused(f"{path}: expected a table in text, got other bytes ({problem})") from problem


def numbers_of(path, header, rows, texts=0):
    """The numbers of rows that have as many cells as the header has names. The last `texts` cells are text."""
    last = len(header) - texts
    table = np.empty((len(rows), last))
    for k, row in enumerate(rows):
        try:
            if len(row) != len(header):
                raise ValueError(f"{len(row)} cells")
            table[k] = [read_number(cell) for cell in row[:last]]
        except ValueError as problem:
            raise Refused(f"{path}, row {k + 1}: expected {last} numbers{' and a reason' if texts else ''}, got {problem}") from problem
    for name, column in zip(header, table.T):
        require_drawable(path, name, column)
    return table


def read_csv(path):
    header, *rows = read_rows(path) or [[]]
    joints = [name[2:] for name in header if name.startswith("q_")]
    if Runs.are_in(header) and joints and rows:
        numbers_of(path, header, rows, texts=1)
        return Runs(header, rows)
    if not joints or header != ["t", *("q_" + j for j in joints), *("qd_" + j for j in joints), "energy"]:
        raise Refused(f"{path}: expected the columns t, q_<joint>…, qd_<joint>…, energy, got "
                      f"{', '.join(header)[:80] or 'nothing'}")
    table = numbers_of(path, header, rows)
    require_times(path, "row", table[:, 0])
    n = len(joints)
    motion = Motion(joints, table[:, 0], table[:, 1:n + 1], table[:, n + 1:2 * n + 1])
    motion.energy = motion.t, {"T + V, less that of the start": table[:, -1] - table[0, -1]}
    return motion


def slides_of(chain):
    return [link["joint"]["name"] for link in chain["links"] if "axis" in link["joint"]]


def events_of(stamps, statuses, taken):
    """stamps: of the states, s. taken: the messages on commands_taken, if it was recorded."""
    period = np.median(np.diff(stamps))
    events = {}
    for k in np.flatnonzero(np.diff(stamps) > 1.5 * period) + 1:
        within = [status for status in statuses if stamps[k - 1] < status.header.stamp.to_sec() < stamps[k]]
        events[k] = ("fault" if any(status.fault for status in within) else
                     "pause" if any(status.paused for status in within) else "gap")

    # The first tick of each. A reset begins the scene's time at 0: without commands_taken, that is seen if it lies after the status
    # before. A settle shifts the time by one tick.
    ticks = [(message.tick, name) for message in taken for name in ("RESET", "SET_STATE", "SETTLE") if message.kind == getattr(message, name)]
    if not taken:
        ticks = [(start, "RESET") for before, status in zip(statuses, statuses[1:]) if status.scene_time > 0
                 for start in [status.tick - round(status.scene_time / period)] if start > before.tick]
    # Its state: a status says when its tick was.
    known = [(status.tick, k) for status in statuses for k in [np.argmin(abs(stamps - status.tick_stamp.to_sec()))]
             if abs(stamps[k] - status.tick_stamp.to_sec()) < period / 2]
    for tick, name in ticks if known else ():
        nearest, k = min(known, key=lambda pair: abs(pair[0] - tick))  # pylint: disable=cell-var-from-loop
        k += tick - nearest
        if 0 < k < len(stamps):
            events[k] = f"{events[k]}, {name.lower()}" if k in events else name.lower()
    return events


def since_jump(messages):
    """As they were published: rosbag sorts by the time of receipt, which goes back with the clock. Of a motion whose clock went back, what
    came after that."""
    if len({message.header.seq for message in messages}) == len(messages):
        messages = sorted(messages, key=lambda message: message.header.seq)
    stamps = [message.header.stamp for message in messages]
    back = [k for k in range(1, len(stamps)) if stamps[k] < stamps[k - 1]]
    return messages[back[-1]:] if back and len(stamps) - back[-1] > 1 else messages


def read_bag(path, node):
    with opened(path, Refused) as (bag, messages_of):
        states_topic, below = topics_of(bag, path, node, Refused)
        states = messages_of(states_topic, "sensor_msgs/JointState")
        statuses, taken, links, scenes = (messages_of(below and f"{below}/{name}", kind) for name, kind in (
            ("status", "planar_chain/SimStatus"), ("commands_taken", "planar_chain/CommandTaken"),
            ("link_states", "planar_chain/LinkStates"), ("scene", "std_msgs/String")))
    recorded = len(states)
    states, statuses, links = map(since_jump, (states, statuses, links))
    if len(states) < recorded:
        say(f"note: {path}: the clock went back; only the {len(states)} states after that are drawn, of {recorded}")
    stamps = np.array([state.header.stamp.to_sec() for state in states])
    require_times(path, f"message of {states_topic}", stamps)

    names, efforts = list(states[0].name), len(states[0].effort)  # robots may have none
    if not names or efforts not in (0, len(names)) or any(
            list(state.name) != names or not len(state.position) == len(state.velocity) == len(names) or len(state.effort) != efforts for state in states):
        raise Refused(f"{path}, {states_topic}: expected an angle, a rate and perhaps an effort of the same joints in each state, got others")

    def of(messages, *fields):
        values = [np.array([getattr(message, field) for message in messages]) for field in fields]
        for field, each in zip(fields, values):
            require_drawable(path, field, each)
        return values

    def since_start(messages):
        return np.array([(message.header.stamp - states[0].header.stamp).to_sec() for message in messages])

    motion = Motion(names, since_start(states), *of(states, "position", "velocity", *["effort"] * (efforts > 0)))
    motion.events = events_of(stamps, statuses, taken)
    if scenes:
        try:
            motion.slides = slides_of(read_chain("/dev/stdin", scenes[0].data))
        except NoChain as problem:
            raise Refused(f"{path}: the scene is refused:\n" + str(problem).replace("/dev/stdin:", "line ")) from problem
    if links:
        poses = np.array([(pose.x, pose.y, pose.theta) for pose in (message.pose[0] for message in links)])
        motion.first = np.column_stack([np.interp(motion.t, since_start(links), column) for column in poses.T])
    running = [status for status in statuses if not status.standstill]
    if running:
        t = since_start(running)
        parts = of(running, "kinetic", "potential", "work_supplied", "dissipated", "energy_balance", "error_estimate")
        motion.energy = t, dict(zip(("T", "V", "supplied", "dissipated"), parts))
        motion.balance, motion.error = (t, parts[4]), (t, parts[5])
        loosest = max(status.tolerance for status in running)  # 0: a fixed step has no error estimate
        motion.rounding = np.finfo(float).eps * max(1.0, abs(motion.q).max()) / loosest if loosest else 0.0
    return motion


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
        title="joint (m if it slides: give --scene)" if each_kind[0][0] is UNKNOWN else "joint")
    return figure


def links_of(option, scene, motion):
    links = Links(scene)
    if links.joints != motion.joints:
        raise Refused(f"{option}: expected the scene of {listed(motion.joints)}, got that of {listed(links.joints)}")
    return links


def strobe(motion, scene, given, apart, title):
    links = links_of("--strobe", scene, motion)
    if not math.isfinite(apart):
        raise Refused(f"--apart: expected a finite number, got {apart}")
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
    parser.add_argument("--scene", help="scene of a CSV, or of a bag without planar_chain/scene: tells which joints slide, for the units")
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
        if os.path.splitext(output)[1] not in (".png", ".svg", ".pdf"):
            raise Refused(f"--output: expected a name that ends in .png, .svg or .pdf, got {output}")
        require_file(given.file)
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
            motion.slides = links.joints[:links.slides]
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
