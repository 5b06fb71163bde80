"""Fits of real machines: a single and a double pendulum beside their authors' numbers, each recording predicted by a fit of the others
and by one of all; and the dry friction of a real robot, from its windows.

The recordings and their sources: config/recordings, test/reference/robot. `python3 src/report/fits.py build/devel/share/planar_chain` prints the table.
"""
import csv
import math
import pathlib
import sys

import robot

HEADER = "machine,recording,numbers,what,joint_1,joint_2\n"
STARTS = {"first measured sample": "from_first_sample", "start fitted to 0.3 s": "from_first_window", "start fitted to all": "from_fitted_start"}
# Of EstimatedParameters_*.mat, in the units of a scene. Inertia is about the centre of mass.
AUTHORS = {
    "single": {"gravity": [0, -9.81001310], "chain": ["arm"], "links": {
        "arm": {"mass": 0.147584572, "inertia": 1.09118505e-4, "com": [0.147754901, 0], "pin": [0.2, 0], "joint": {"damping": 2.23940125e-4}}}},
    "double": {"gravity": [0, -9.80858023], "chain": ["upper", "lower"], "links": {
        "upper": {"mass": 9.38439748e-2, "inertia": 4.37529430e-4, "com": [0.108565215, 0], "pin": [0.172719204, 0],
                  "joint": {"damping": 2.37142783e-4}},
        "lower": {"mass": 0.137595970, "inertia": 1.26882939e-3, "com": [0.116779018, 0], "pin": [0.2, 0],
                  "joint": {"damping": 1.00000019e-5}}}}}
NUMBERS = {
    "single": ["links/arm/inertia", "links/arm/joint/friction=0", "links/arm/joint/drag=0"],
    "double": ["links/upper/inertia", "links/upper/com/0", "links/upper/pin/0", "links/upper/joint/damping", "links/lower/mass",
               "links/lower/inertia", "links/lower/com/0", "links/lower/joint/damping"]}
START, WINDOW = 0.3, 0.5  # s: a start is fitted to, a piece of the robot's recordings
FRICTION = {f"links/{link}/joint/friction": 0.05 for link in robot.LINKS}
ROBOTS_NUMBERS = {"friction fitted": FRICTION, "friction and com of upper fitted": {**FRICTION, "links/upper/com/0": None}}


def row(*cells):
    return ",".join(f"{cell:.5g}" if isinstance(cell, float) else cell for cell in cells) + "\n"


def errors(machine, numbers, one):
    """The rows of a prediction."""
    for what, key in STARTS.items():
        first, *second = map(float, getattr(one, key))
        yield row(machine, one.name, numbers, what, first, *(second or [math.nan]))


def pendulum(machine, folder):
    from planar_chain import Scene, fit  # pylint: disable=import-outside-toplevel
    from planar_chain.fitting.fit import predicted, recordings_of  # pylint: disable=import-outside-toplevel
    first, authors = Scene.from_file(folder / f"{machine}.yaml"), Scene(AUTHORS[machine])
    files = sorted(str(path) for path in folder.glob(f"{machine}_*.csv"))
    to_all = fit(first, files, NUMBERS[machine], predict=files).predictions
    for k, path in enumerate(files):
        yield from errors(machine, "authors'", predicted(authors, recordings_of(path, authors, START)[0], False, START))
        result = fit(first, files[:k] + files[k + 1:], NUMBERS[machine], predict=[path])
        yield from errors(machine, "fitted to the others", result.predictions[0])
        yield from errors(machine, "fitted to all", to_all[k])


def windows(path):
    """Half a second each, as recordings with the torques that the motors reported."""
    with open(path, encoding="utf-8", newline="") as file:
        rows = [{name: float(value) for name, value in line.items()} for line in csv.DictReader(file)]
    start = rows[0]["t"]
    for k in range(int((rows[-1]["t"] - start) / WINDOW)):
        part = [line for line in rows if k * WINDOW <= line["t"] - start < (k + 1) * WINDOW]
        yield {"name": f"{path.stem} {k + 1}", "t": [line["t"] for line in part],
               **{key: [[line[f"{key}1"], line[f"{key}2"]] for line in part] for key in ("q", "qd", "tau")}}


def robots_friction(folder):
    from planar_chain import Scene, fit  # pylint: disable=import-outside-toplevel
    from planar_chain.fitting.fit import predicted, recordings_of  # pylint: disable=import-outside-toplevel
    values = robot.scene(robot.measured(folder / "swing_up_01.csv"))
    del values["loads"]
    for link in values["links"].values():
        del link["initial"]
    identified = Scene(values)
    data = [window for run in robot.RUNS for window in windows(folder / f"{run}.csv")]
    yield row("robot", "all", "identified", "friction (N m)", *(values["links"][link]["joint"]["friction"] for link in robot.LINKS))
    yield row("robot", "all", "identified", "com of upper (m)", values["links"]["upper"]["com"][0], math.nan)
    for recording in recordings_of(data, identified, START):
        one = predicted(identified, recording, False, START)
        yield row("robot", recording.name, "identified", "start fitted to all", *map(float, one.from_fitted_start))
    for which, vary in ROBOTS_NUMBERS.items():
        result = fit(identified, data, vary)
        for what, key in (("{} ({})", "value"), ("deviation of {} ({})", "deviation")):
            found = [float(getattr(number, key)) for number in result.numbers]
            yield row("robot", "all", which, what.format("friction", "N m"), *found[:2])
            for value in found[2:]:
                yield row("robot", "all", which, what.format("com of upper", "m"), value, math.nan)
        for name, error in result.errors:
            yield row("robot", name, which, "start fitted to all", *map(float, error))


def why_not():
    """Returns why the study cannot be made; empty if it can."""
    try:
        import planar_chain._core  # noqa: F401  pylint: disable=import-outside-toplevel,unused-import
        import scipy  # noqa: F401  pylint: disable=import-outside-toplevel,unused-import
    except ImportError as missing:
        return str(missing)
    return ""


def measure(share):
    """A table with a header. share: the folder with config/recordings and robot."""
    recordings = share / "config/recordings"
    return HEADER + "".join([*pendulum("single", recordings), *pendulum("double", recordings), *robots_friction(share / "robot")])


if __name__ == "__main__":
    sys.stdout.write(measure(pathlib.Path(sys.argv[1])))
