#!/usr/bin/python3
"""Draws the frequency response of a scene near an equilibrium: magnitude (dB) and phase from each input to each output.

Exit status: 0 done; 1 it cannot be written; 2 bad arguments, or a scene with faults or without equilibrium."""

from program import Parser, put, run, say  # isort: skip

import argparse
import csv
import inspect
import io
import os
import sys
import warnings

from files import notes_by, require_outputs, require_picture, save_picture, scene_file, writing
from user_input import read_numbers, read_torques
try:
    import numpy as np

    from planar_chain import Scene, equations, equilibrium, linearize, state_space
except ImportError as missing:
    sys.exit(f"bode: {missing}")

POINTS, MOST_POINTS = 400, 100000
AROUND, FAR = 10.0, 1e4  # times the lowest and highest pole that are drawn; the highest, of the lowest
FREE = 1e-9              # of the largest pole: less counts as 0
ROUNDING = 1e-12  # of the terms whose sum it is
NEAR = 1e-6       # rad, m: to a pose so far away no response changes by more than a share
MOST_SHARE = 0.1
NEAR_POLES = 1 + np.concatenate([sign * np.logspace(-4, -1, 10) for sign in (1, -1)])


def arguments():
    names = inspect.cleandoc(state_space.__doc__).partition("\n\nInputs:")[2]
    parser = Parser(prog="bode", description=__doc__, epilog="Inputs:" + names, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", metavar="SCENE", help="a YAML file, a URDF, or the name of a scene that ships")
    parser.add_argument("--input", nargs="+", required=True, metavar="INPUT", help="such as a joint, whose torque it is")
    parser.add_argument("--output", nargs="+", required=True, metavar="OUTPUT", help="such as JOINT/position")
    parser.add_argument("--q", metavar="A,B,…",
                        help="angles, rad, m for prismatic joints (default: the equilibrium of `equations --equilibrium`)")
    parser.add_operating_point()
    parser.add_argument("--motors", action="store_true", help="torques of joints are commanded ones, which pass the lags of motors")
    parser.add_argument("--from", dest="first", type=float, metavar="HZ", help="lowest frequency (default: a tenth of the lowest pole)")
    parser.add_argument("--to", dest="last", type=float, metavar="HZ",
                        help=f"highest frequency (default: ten times the highest pole, at most {FAR:g} times --from)")
    parser.add_argument("--points", type=int, default=POINTS, metavar="N",
                        help=f"frequencies, evenly on a logarithmic scale (default: {POINTS}); poles have more")
    parser.add_argument("--plot", metavar="FILE", help="a .png, .svg or .pdf")
    parser.add_argument("--csv", metavar="FILE", help="frequency (Hz), then magnitude (dB) and phase (degrees) of each pair; -: standard "
                                                      "output (default without --plot)")
    return parser.parse_args()


def frequencies(A, given):
    """In rising order, Hz; beside poles with little damping they are close."""
    poles = np.linalg.eigvals(A)
    size = abs(poles)[abs(poles) > FREE * abs(poles).max()] / (2 * np.pi)
    size = size if len(size) else np.array([1.0])
    first = size.min() / AROUND if given.first is None else given.first
    last = min(size.max() * AROUND, first * FAR) if given.last is None else given.last
    if not 0 < first < last < np.inf:
        raise ValueError(f"--from, --to: expected frequencies > 0 Hz, the second larger, got {first:g} and {last:g}")
    if not 2 <= given.points <= MOST_POINTS:
        raise ValueError(f"--points: expected a number from 2 to {MOST_POINTS}, got {given.points}")
    beside = np.outer(abs(poles[poles.imag > 0]) / (2 * np.pi), NEAR_POLES).ravel()
    beside = beside[(beside > first) & (beside < last)][:MOST_POINTS]
    return np.unique(np.concatenate([np.geomspace(first, last, given.points), beside]))


def response(A, B, C, D, hertz):
    """C (iω − A)⁻¹ B + D at each frequency: frequencies × outputs × inputs. 0 where it is rounding."""
    one, H = np.eye(len(A)), np.empty((len(hertz), *D.shape), dtype=complex)
    for k, f in enumerate(hertz):
        x = np.linalg.solve(2j * np.pi * f * one - A, B)
        H[k] = C @ x + D
        H[k][abs(H[k]) <= ROUNDING * (abs(C) @ abs(x) + abs(D))] = 0
    return H


def neighbours(scene, q, friction):
    """Two poses close to q. Joints that are driven or stick stay."""
    rest = np.zeros(len(scene))
    moves = linearize(scene, q, rest, friction=friction)[1][len(scene):].any(axis=1)
    step = NEAR * moves * np.cos(np.arange(len(scene)))
    return q + step, q - step


def curves(scene, given):
    """Frequencies, and of each pair its name, magnitude (dB) and phase (degrees): NaN where the response is 0."""
    rest, about = np.zeros(len(scene)), {"tau": read_torques("--tau", given.tau, ValueError), "friction": given.friction, "motors": given.motors}

    def system_at(q):
        return state_space(scene, given.input, given.output, q, rest, **about)

    with notes_by(say):
        q = read_numbers("--q", given.q, ValueError)
        q = equilibrium(scene) if q is None and given.tau is None else q
        system = system_at(q)
    hertz = frequencies(system[0], given)
    H = response(*system, hertz)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # they came
        change = np.min([abs(response(*system_at(near), hertz) - H) for near in neighbours(scene, equations(scene, q, rest)["q"], given.friction)],
                        axis=0)
    responds = np.mean(change < MOST_SHARE * abs(H), axis=0) > 0.5
    H = np.where(responds & (H != 0), H, np.nan)
    pairs = []
    for i, output in enumerate(given.output):
        for j, source in enumerate(given.input):
            of, name = H[:, i, j], f"{output} from {source}"
            if not responds[i, j]:
                say(f"{name}: no response")
            phase, is_there = np.full(len(of), np.nan), ~np.isnan(of)
            phase[is_there] = np.degrees(np.unwrap(np.angle(of[is_there])))
            pairs.append((name, 20 * np.log10(abs(of)), phase))
    return hertz, pairs


def table(hertz, pairs):
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(["frequency_Hz", *(f"{name} ({unit})" for name, *_ in pairs for unit in ("dB", "degrees"))])
    for k, f in enumerate(hertz):
        rows.writerow([f"{f:.17g}", *("" if np.isnan(values[k]) else f"{values[k]:.17g}" for _, *both in pairs for values in both)])
    return text.getvalue()


def draw(hertz, pairs, title):
    import matplotlib  # pylint: disable=import-outside-toplevel
    matplotlib.use("Agg")
    from matplotlib import pyplot  # pylint: disable=import-outside-toplevel
    figure, (upper, lower) = pyplot.subplots(2, sharex=True, figsize=(7.5, 6), constrained_layout=True)
    figure.suptitle(title)
    for name, magnitude, phase in pairs:
        if np.isnan(magnitude).all():
            upper.plot([], [], " ", label=name + ": no response")
            continue
        upper.semilogx(hertz, magnitude, label=name)
        lower.semilogx(hertz, phase)
    upper.set_ylabel("magnitude (dB)")
    lower.set(xlabel="frequency (Hz)", ylabel="phase (°)", xscale="log", xlim=(hertz[0], hertz[-1]))
    lower.yaxis.set_major_locator(pyplot.MaxNLocator(steps=[1, 1.5, 3, 4.5, 9, 10]))
    upper.legend(fontsize="small")
    for axes in (upper, lower):
        axes.grid(which="both", alpha=0.3)
    return figure


def main():
    given = arguments()
    target = "-" if given.plot is None and given.csv is None else given.csv
    require_picture("--plot", given.plot)
    require_outputs([("--plot", given.plot), ("--csv", None if target == "-" else target)], [scene_file(given.scene)])
    with notes_by(say):
        scene = Scene.from_file(given.scene)
    hertz, pairs = curves(scene, given)
    if given.plot:
        save_picture(draw(hertz, pairs, f"frequency response of {os.path.basename(given.scene)}"), given.plot, dpi=130)
    if target == "-":
        put(table(hertz, pairs))
    elif target:
        with writing(target), open(target, "w", encoding="utf-8") as file:
            file.write(table(hertz, pairs))
    for path in filter(None, (given.plot, target if target != "-" else None)):
        say(f"written to {path}")
    return 0


if __name__ == "__main__":
    sys.exit(run(main, (ValueError,)))
