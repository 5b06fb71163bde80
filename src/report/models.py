"""Models that others published: their figures beside this program's, and which of them is right where they differ.

`python3 src/report/models.py build/devel/share/planar_chain [FILE …]` prints the table, or that of the models in files like
test/reference/models/models.json. A row has the published figure and that of `auto` at TOLERANCE. Two more runs measure the error of
ours: `auto` at TIGHTER, and a second way. For a chain with a free tip and without loads, the second way is scipy's DOP853 with Kane's
dense equations. It shares neither recursions nor methods with ours. For other chains it is another method. The doubt is the largest
difference between the runs of a model. Both are right if they differ by less than AGREE times the doubt, or by half a unit of the
figure's last digit. Ours is right if they differ by more than DIFFER times the doubt, and scipy's BDF at the authors' tolerance
errs so, too: it is a method like theirs. A closed form is right, and a recording of a machine. The difference from a recording
is the root mean square error of the authors' model.
"""
import collections
import csv
import decimal
import io
import json
import pathlib
import sys

import fits
import robot

COLUMNS = ["model", "source", "quantity", "t", "figure", "ours", "difference", "second", "second_differs", "tighter_differs", "bdf_errs",
           "right"]
TOLERANCE, TIGHTER = 1e-12, 1e-13
AGREE, DIFFER, LIKELY = 10, 100, 10  # times the doubt, the doubt, the error of BDF
ROUNDING = 1e-13                     # of figures that a program computed with doubles
TEST_SET = "F. Mazzia, C. Magherini, Test Set for Initial Value Problem Solvers, 2008; University of Bari"
GARCIA = ("M. Garcia, A. Chatterjee, A. Ruina, M. Coleman, The Simplest Walking Model: Stability, Complexity, and Scaling, 1998; "
          "J. Biomech. Eng. 120")
BHOUNSULE = ("P. Bhounsule, Numerical Accuracy of Two Benchmark Models of Walking, 2014; Dyn. Contin. Discrete Impuls. Syst. B 21, "
             "its program simplestwalker.m")
IFTOMM = ("M. González et al., A Benchmarking System for MBS Simulation Software, 2006; Multibody Syst. Dyn. 16, "
          "www.iftomm-multibody.org/benchmark")
KAHEMAN = "K. Kaheman et al., The Experimental Multi-Arm Pendulum on a Cart, 2022; arXiv 2205.06231"
DFKI = "DFKI RIC Underactuated Robotics Lab, double_pendulum, 2022; github.com/dfki-ric-underactuated-lab/double_pendulum"
EXACT, MEASURED = "exact", "measured"

# names: (quantity, t) of each figure. run(method, tolerance): our figures. second: (its name, its figures).
# kind: EXACT (a closed form), MEASURED, or empty. bdf: the errors of a program like the authors', if their tolerance is known.
Model = collections.namedtuple("Model", "name source names figures run second kind bdf", defaults=("", None))


# ---- Motions -------------------------------------------------------------------------------------

def motion(scene, times, joints=None, absolute=False):
    """Returns run(method, tolerance) → angles at the times, row by row."""
    import numpy  # pylint: disable=import-outside-toplevel
    from planar_chain import Scene, simulate  # pylint: disable=import-outside-toplevel

    def run(method, tolerance):
        model = Scene({**scene, "integrator": {"method": method, "tolerance": tolerance}})
        angles = simulate(model, [0, *times] if times[0] else times)[-len(times):, :len(model.joints)]
        if absolute:
            angles = numpy.cumsum(angles, axis=1)
        return (angles if joints is None else angles[:, [model.joints.index(joint) for joint in joints]]).ravel()
    return run


def by_kane(scene, times, joints, method, tolerance):
    """The states by a method of scipy, with q̈ from dense matrices."""
    import numpy  # pylint: disable=import-outside-toplevel
    from planar_chain import Scene, equations, simulate  # pylint: disable=import-outside-toplevel
    from scipy.integrate import solve_ivp  # pylint: disable=import-outside-toplevel
    model = Scene(scene)
    n = len(model.joints)

    def slopes(t, y):
        matrices = equations(model, y[:n], y[n:], t)
        return numpy.concatenate([y[n:], numpy.linalg.solve(matrices["M"], matrices["f"])])
    y, ends, chosen = simulate(model, [0.0])[0], [], [model.joints.index(joint) for joint in joints]
    for begin, end in zip([0, *times], times):
        y = solve_ivp(slopes, (begin, end), y, method=method, rtol=tolerance, atol=tolerance).y[:, -1]
        ends.append(y[chosen])
    return numpy.concatenate(ends)


def from_file(text):
    """Models as in test/reference/models/models.json. Figures keep their digits. `tolerance` is that of Dymola by default."""
    from planar_chain import Scene  # pylint: disable=import-outside-toplevel
    for one in json.loads(text, parse_float=decimal.Decimal):
        scene, rows = one["scene"], one["rows"]
        scene = Scene.from_file(scene).to_dict() if isinstance(scene, str) else json.loads(json.dumps(scene, default=float))
        scene.pop("integrator", None)
        times, joints = [float(row[0]) for row in rows], one["joints"]
        run, bdf, second = motion(scene, times, joints), None, ("radau13", None)
        if not {"tip", "loads", "base", "springs"} & set(scene):
            second = ("Kane, DOP853", lambda s=scene, t=times, j=joints: by_kane(s, t, j, "DOP853", TOLERANCE))
            bdf = (lambda s=scene, t=times, j=joints, least=float(one.get("tolerance", 1e-6)): by_kane(s, t, j, "BDF", least))
        yield Model(one["model"], one.get("source", ""), [(joint, t) for t in times for joint in joints],
                    [figure for row in rows for figure in row[1:]], run, second, EXACT if one.get("exact") else "", bdf)


# ---- Each by itself ------------------------------------------------------------------------------

def a01():
    """A point mass of 1 kg on a bar of 1 m without mass, let go at rest from θ = π. Exact: sin(ψ/2) = k sn(K − ω t, k), ψ = θ + π/2,
    k = sin(π/4), and ψ is below 0 at the start."""
    from scipy.special import ellipj, ellipk  # pylint: disable=import-outside-toplevel
    import numpy  # pylint: disable=import-outside-toplevel
    times = [10.0, 100.0, 1000.0, 2000.0]
    sn = ellipj(ellipk(0.5) - 9.81 ** 0.5 * numpy.array(times), 0.5)[0]
    exact = 1.5 * numpy.pi - 2 * numpy.arcsin(0.5 ** 0.5 * sn)
    scene = {"chain": ["bar"], "links": {"bar": {"mass": 1, "inertia": 0, "com": [1, 0], "pin": [1, 0],
                                                 "initial": {"angle": numpy.pi}}}}
    return Model("IFToMM A01", IFTOMM, [("bar_joint", t) for t in times], exact, motion(scene, times), ("radau13", None), EXACT)


def beam(share):
    from planar_chain import Scene  # pylint: disable=import-outside-toplevel
    rows = [line.split(",") for line in (share / "report/beam.csv").read_text(encoding="utf-8").splitlines()]
    figures = [decimal.Decimal(value) for quantity, _, value, *_ in rows if quantity == "theta"]
    scene = Scene.from_file(share / "config/scenes/beam.yaml").to_dict()
    return Model("BEAM", TEST_SET, [(f"θ of link {k + 1}", 5.0) for k in range(len(figures))], figures,
                 motion(scene, [5.0], absolute=True), ("radau13", None))


def walkers():
    import walker  # pylint: disable=import-outside-toplevel
    figures = {"long": (GARCIA, "0.200310900544287 -0.199832473004977 -0.1901 0.5576 -0.1901 -0.5576"),
               "short": (BHOUNSULE, "0.193937369810188 -0.203866927442012 4.0039 0 0.4596 0")}
    for name, (source, text) in figures.items():
        values = list(map(decimal.Decimal, text.split()))
        for what, part in (("start of a step", slice(2)), ("multipliers", slice(2, None))):
            yield Model(f"walker, {name}: {what}", source, [(number, "") for number in walker.NUMBERS[part]], values[part],
                        lambda method, tolerance, name=name, part=part: walker.gait(name, method, tolerance)[part], ("radau13", None))


def machines(share):
    """Recordings, and the motions from the first measured state on by what the authors identified."""
    from planar_chain import Scene  # pylint: disable=import-outside-toplevel
    from planar_chain.fitting.fit import recordings_of  # pylint: disable=import-outside-toplevel
    from planar_chain.fitting.solve import first_state  # pylint: disable=import-outside-toplevel
    for name, scene in fits.AUTHORS.items():
        for path in sorted((share / "config/recordings").glob(f"{name}_*.csv")):
            recording = recordings_of(str(path), Scene(scene), fits.WINDOW)[0]
            state, n = first_state(recording), len(scene["chain"])
            links = {link: {**values, "initial": {"angle": float(state[k]), "velocity": float(state[n + k])}}
                     for k, (link, values) in enumerate(scene["links"].items())}
            yield measured(f"MultiArm-Pendulum, {name}", path.stem, KAHEMAN, {**scene, "links": links}, recording.t.tolist(), recording.q.tolist())
    for run in robot.RUNS:
        data = robot.measured(share / f"robot/{run}.csv")
        yield measured("DFKI, double pendulum", run, DFKI, robot.scene(data), [t - data["t"][0] for t in data["t"]], list(zip(data["q1"], data["q2"])))


def measured(model, recording, source, scene, times, angles):
    names = [(f"{recording}: joint {k + 1}", t) for t in times for k in range(len(angles[0]))]
    return Model(model, source, names, [angle for row in angles for angle in row], motion(scene, times), ("dopri5", None), MEASURED)


# ---- The table -----------------------------------------------------------------------------------

def half_a_unit(figure):
    """Of the last digit that is given."""
    return 0.5 * 10.0 ** figure.as_tuple().exponent if isinstance(figure, decimal.Decimal) else 0.0


def judged(kind, difference, doubt, unit, bdf):
    """Returns which is right, as one word; bdf: the largest error of BDF, NaN if the authors' tolerance is not known."""
    if kind == MEASURED:
        return "machine"
    if difference <= unit + max(AGREE * doubt, ROUNDING):
        return "both"
    if kind == EXACT:
        return "figure"
    return "ours" if unit + DIFFER * doubt < difference < LIKELY * bdf else "open"


def rows_of(model):
    """The rows of a model."""
    import numpy  # pylint: disable=import-outside-toplevel
    figures = numpy.array([float(figure) for figure in model.figures])
    ours, tighter = model.run("auto", TOLERANCE), model.run("auto", TIGHTER)
    second = model.second[1]() if model.second[1] else model.run(model.second[0], TOLERANCE)
    bdf = abs(model.bdf() - tighter) if model.bdf else numpy.full(len(figures), numpy.nan)
    doubt = max(abs(second - ours).max(), abs(tighter - ours).max())
    columns = [figures, ours, abs(ours - figures), abs(second - ours), abs(tighter - ours), bdf]
    names, units = model.names, [half_a_unit(figure) for figure in model.figures]
    if model.kind == MEASURED:  # the root mean square of each joint, in place of its angles
        names = [(name, names[-1][1]) for name in dict.fromkeys(name for name, _ in names)]
        columns = [numpy.sqrt(numpy.mean(column.reshape(-1, len(names)) ** 2, axis=0)) for column in columns]
        columns[:2] = numpy.full((2, len(names)), numpy.nan)
    source = model.source
    for (name, t), unit, (figure, value, difference, by_second, by_tighter, by_bdf) in zip(names, units, zip(*columns)):
        right = judged(model.kind, difference, doubt, unit, bdf.max())
        yield [model.name, source, name, t if t == "" else f"{t:g}", figure, value, f"{difference:.3g}", model.second[0],
               f"{by_second:.2g}", f"{by_tighter:.2g}", f"{by_bdf:.2g}", right]
        source = ""  # stands in the first row of a model


def why_not():
    """Returns why the study cannot be made; empty if it can."""
    return fits.why_not()


def all_of(share):
    yield from from_file((share / "models/models.json").read_text(encoding="utf-8"))
    yield a01()
    yield beam(share)
    yield from walkers()
    yield from machines(share)


def measure(share, files=()):
    """A table with a header. share: the folder with models, report, robot, config."""
    models = [model for path in files for model in from_file(pathlib.Path(path).read_text(encoding="utf-8"))] if files else all_of(share)
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([COLUMNS, *(row for model in models for row in rows_of(model))])
    return text.getvalue()


if __name__ == "__main__":
    sys.stdout.write(measure(pathlib.Path(sys.argv[1]), sys.argv[2:]))
