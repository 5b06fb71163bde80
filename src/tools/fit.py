#!/usr/bin/python3
"""Fits numbers of a scene to recordings of its motion, and prints them with their deviations.

FILE is a bag (joint_states, and the commands that planar_chain's node took) or a CSV with the columns t, q_<joint>, optional qd_<joint>
and tau_<joint>; an empty field is a gap. The initial state of each recording is fitted too.

Exit status: 0 done; 1 the fit did not converge or is bad; 2 bad arguments, scene or recordings; 130 interrupted. After 1 and 130 the best
numbers are printed and written."""

from program import Parser, put, run, say  # isort: skip

import argparse
import json
import math
import os
import sys

from chain import scene_from
from files import BadOutput, is_same, require_outputs, require_picture, save_picture, scene_file, tree_of, words_of, writing
from user_input import read_number
try:
    import yaml

    from planar_chain import BadFit, Failed, Refused, fit
    from planar_chain.fitting.fit import is_bag
    from planar_chain.fitting.report import as_json, as_text
    from planar_chain.fitting.yaml_edit import with_fitted
except ImportError as missing:
    sys.exit(f"fit: {missing}")


def arguments():
    parser = Parser(prog="fit", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", metavar="SCENE", help="a YAML file, a URDF, or the name of a scene that ships")
    parser.add_argument("--data", nargs="+", action="extend", required=True, metavar="FILE", help="recordings to fit: .bag or .csv")
    parser.add_argument("--vary", nargs="+", action="extend", required=True, metavar="PATH[=FIRST[:LOW:HIGH]]",
                        help="a number to find, such as links/lower/mass, its first value (default: the scene's) and its bounds")
    parser.add_argument("--predict", nargs="+", action="extend", default=[], metavar="FILE",
                        help="prints the errors on recordings that the fit does not use")
    parser.add_argument("--output", metavar="FITTED.yaml", help="writes the scene with the fitted numbers; comments behind them give way to their deviations")
    parser.add_argument("--plot", metavar="PICTURE", help="draws angles, residuals and an ellipse: .png, .svg or .pdf")
    parser.add_argument("--json", action="store_true", help="prints one JSON object")
    parser.add_argument("--offsets", action="store_true", help="also fits an offset of each encoder in each recording")
    parser.add_argument("--delay", action="store_true", help="also fits the delay between torque and motion in each recording; predictions use the mean")
    parser.add_argument("--effort", action="store_true", help="applies the effort of a bag as torque")
    parser.add_argument("--node", help="node, such as /left/planar_chain, if a bag has several")
    parser.add_argument("--many-turns", action="store_true", help="accepts angles above 50 rad in a CSV, which look like degrees")
    parser.add_argument("--pieces", type=float, metavar="S", help="cuts each recording into equal pieces of about S seconds")
    parser.add_argument("--windows", metavar="A,B,…", default="0.3,0.6,1.2,2.4",
                        help="the growing windows, s, each from the start of a recording; then twice as long each, then the whole")
    return parser.parse_args()


def windows_of(text):
    try:
        return [read_number(part) for part in text.split(",")]
    except ValueError:
        raise BadFit(f"--windows: expected times in s, such as 0.3,0.6, got {text!r}") from None


def scene_text(path, scene):
    """The text of the scene's file; of one with a URDF, which has no such numbers, that of the links that were written out."""
    try:
        with open(scene_file(path), encoding="utf-8") as file:
            text = file.read()
        return yaml.safe_dump(scene.to_dict(), sort_keys=False) if "robot_description" in tree_of(text) else text
    except (UnicodeDecodeError, yaml.YAMLError) as problem:
        raise BadFit(f"{path}: expected YAML in UTF-8 that PyYAML reads too (--output), got {' '.join(str(problem).split())}") from None


def check(given):
    require_picture("--plot", given.plot)
    for option, is_given in (("--effort", given.effort), ("--node", given.node is not None)):
        if is_given and not any(is_bag(file) for file in [*given.data, *given.predict]):
            raise BadFit(f"{option}: expected a bag beside it, got none")
    if given.output is not None and given.output.endswith(".urdf"):
        raise BadFit(f"--output: expected the name of a YAML scene, got {given.output}")
    require_outputs([("--output", given.output), ("--plot", given.plot)], [scene_file(given.scene), *given.data, *given.predict])
    for file in given.predict:
        if any(is_same(file, other) for other in given.data):
            say(f"note: the fit uses {file} of --predict too")


def show_progress(window, error, calls):
    if sys.stderr.isatty():
        where = "whole recordings" if math.isinf(window) else f"first {window:g} s"
        sys.stderr.write(f"\rfit: {where}: error {error:.3g} after {calls} evaluations (Ctrl-C keeps the best)\033[K")
        sys.stderr.flush()


def write_all(given, result, text):
    """The files that were asked for."""
    if given.output is not None:
        with writing(given.output), open(given.output, "w", encoding="utf-8", errors="surrogateescape") as file:
            file.write(f"# The fit is bad: {result.bad}.\n" * bool(result.bad)
                       + with_fitted(text, {found.path: found.deviation for found in result.numbers},
                                     {found.path: found.value for found in result.numbers}))
    if given.plot is not None:
        from planar_chain.fitting.pictures import draw  # pylint: disable=import-outside-toplevel  # matplotlib takes a second
        save_picture(draw(result, f"{os.path.basename(given.scene)}: fit"), given.plot, dpi=110)


def main():
    given = arguments()
    check(given)
    try:
        scene = scene_from(given.scene, say)
        text = given.output and scene_text(given.scene, scene)
        result = fit(scene, given.data, given.vary, predict=given.predict, offsets=given.offsets, delay=given.delay, effort=given.effort,
                     node=given.node, many_turns=given.many_turns, pieces=given.pieces, windows=windows_of(given.windows),
                     progress=show_progress)
    except OSError as problem:
        raise BadFit(words_of(problem)) from problem
    if sys.stderr.isatty():
        sys.stderr.write("\r\033[K")
    put((json.dumps(as_json(result), indent=1) if given.json else as_text(result)) + "\n")
    write_all(given, result, text)
    if result.interrupted:
        say("interrupted; this is the best so far")
        return 130
    if not result.converged:
        seen = "; the warnings say more" if result.warnings else ""
        say(f"the fit did not converge: {result.reason}; this is the best so far{seen}")
        return 1
    if result.bad:
        say(f"the fit is bad: {result.bad}")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(run(main, (BadFit, BadOutput, Refused), (Failed,)))
