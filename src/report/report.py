#!/usr/bin/python3
"""Measures error against run time, stability, scaling and more, and writes the pages DIR/index.html and DIR/README.md
with their pictures, and the tables as CSV.

Called again, it continues an interrupted report. It measures no table again that the same programs have measured.
src/report/README.md says what is measured and how.
"""
import argparse
import datetime
import fcntl
import hashlib
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys

sys.dont_write_bytecode = True  # the script may lie in a folder of sources

import fits  # noqa: E402  pylint: disable=wrong-import-position
import from_python  # noqa: E402  pylint: disable=wrong-import-position
import models  # noqa: E402  pylint: disable=wrong-import-position
import real_time  # noqa: E402  pylint: disable=wrong-import-position
import results  # noqa: E402  pylint: disable=wrong-import-position
from peers import environment  # noqa: E402  pylint: disable=wrong-import-position
import robot  # noqa: E402  pylint: disable=wrong-import-position

HERE = pathlib.Path(__file__).absolute().parent
DATA = HERE / "../../share/planar_chain"
OWN = HERE / "report_measure"
STUDIES = ["race", "peers", "consistency", "stability", "scaling", "effects", "long", "python", "real_time", "models", "robot", "fits"]


class Failed(Exception):
    """A program that measures has failed."""


def write_whole(path, text):
    """Writes all of the file or none of it."""
    part = path.with_suffix(".part")
    part.write_text(text, encoding="utf-8")
    part.replace(path)


# ---- Studies -------------------------------------------------------------------------------------

def output_of(*command):
    result = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                            universal_newlines=True, check=False)
    if result.returncode != 0:
        raise Failed(f"{' '.join(map(str, command))}: {result.stderr.strip() or result.returncode}")
    return result.stdout


def of_peers(peers, study, arguments):
    """The rows of other programs. One that fails is left out with a line."""
    for command in peers.commands(study, arguments, HERE / "equations") if peers else ():
        try:
            yield output_of(*command)
        except Failed as error:
            print(f"report: left out: {error}", file=sys.stderr)


def parts_of(study, scenes, is_quick):
    """A study is measured part by part. A row of a part begins with these words."""
    return ([(scene,) for scene in scenes] if study in ("race", "peers") else
            real_time.cells(is_quick) if study == "real_time" else [()])


def measure(study, part, is_quick, peers):
    """A table with a header."""
    if study == "real_time":
        return real_time.measure(*part, is_quick)
    if study == "python":
        return from_python.measure(HERE / "batches", is_quick)
    if study == "fits":
        return fits.measure(DATA)
    if study == "models":
        return models.measure(DATA)
    if study == "robot":
        return robot.measure(HERE / "simulate", DATA / "robot")
    quick = ["--quick"] if is_quick else []
    if study == "stability":
        return output_of(HERE / "stability", *quick)
    arguments = ["--study", study, "--data", DATA, *quick, *(["--scene", *part] if part else [])]
    own = "scene,program,what,setting,seconds,error\n" if study == "peers" else output_of(OWN, *arguments)
    return own + "".join(of_peers(peers, study, arguments))


def shorter(rows):
    """The rows without needless characters: six digits of a number suffice, and nothing for what is none."""
    def cell(match):
        return re.sub(r"(e[+-]?)0", r"\1", f"{float(match.group()):.6g}").replace("nan", "")
    return re.sub(r"(?<![^,\n])(-?\d+\.\d{2,}(e[+-]\d+)?|nan)(?![^,\n])", cell, rows)


def extend(path, study, part, is_quick, peers):
    """Measures a part that the table does not hold yet."""
    text = path.read_text(encoding="utf-8") if path.exists() else ""
    begin = "".join(f"{word}," for word in part)
    if not any(line.startswith(begin) for line in text.splitlines()[1:]):
        header, rows = measure(study, part, is_quick, peers).split("\n", 1)
        write_whole(path, (text or header + "\n") + (rows if study == "models" else shorter(rows)))  # published figures stay


# ---- By what it is measured ----------------------------------------------------------------------

def processor():
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        return next((line.split(":", 1)[1].strip() for line in file if line.startswith("model name")), "not known")


def digest(*programs):
    return "".join(hashlib.sha256(program.read_bytes()).hexdigest() for program in programs if program.exists())


def facts_now(is_quick, peers):
    """What stands under the figures. A table is kept only while these facts stay the same."""
    return {**json.loads(output_of(OWN, "--study", "about")), "quick": is_quick, "cpu": processor(),
            "engines": peers.versions() if peers else {}, "python": from_python.versions(),
            "left_out": {"fits": fits.why_not(), "models": models.why_not(), "real_time": real_time.why_not(HERE),
                         "python": from_python.why_not(), "peers": "" if peers else "without --peers"},
            "programs": digest(OWN, HERE / "batches", HERE / "stability", HERE / "planar_chain_node", *(peers.programs if peers else ()))}


def prepare(folder, studies, facts):
    """Removes the tables of these studies that other programs measured; notes by what the others are measured."""
    known = results.read_about(folder)
    date = datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d %H:%M UTC")
    words = ["DIR" if pathlib.Path(word) == folder else word for word in sys.argv[1:]]
    for name in studies:
        before = known.get(name, {})
        if all(before.get(fact) == value for fact, value in facts.items()):
            continue  # with the date of its first measurements
        results.table(folder, name).unlink(missing_ok=True)
        known[name] = {**facts, "date": date, "command": "rosrun planar_chain report " + shlex.join(words)}
    first = {name: next(other for other in known if known[other] == known[name]) for name in known}
    named = {name: known[name] if name == other else other for name, other in first.items()}
    write_whole(folder / "about.json", json.dumps(named, indent=1) + "\n")


# ---- The whole -----------------------------------------------------------------------------------

def parse(scenes):
    parser = argparse.ArgumentParser(prog="report", description=__doc__, allow_abbrev=False,
                                     epilog="Exit status: 0 done; 1 a measurement failed; 2 bad arguments.")
    parser.add_argument("--quick", action="store_true", help="two or three minutes: fewer settings, shorter runs")
    parser.add_argument("--peers", action="store_true",
                        help="compares with other programs, which this installs from PyPI into the user's cache and builds")
    lists = {"scenes": scenes, "studies": STUDIES}
    for option, known in lists.items():
        parser.add_argument("--" + option, metavar="NAMES", default=",".join(known),
                            help="only these of " + ", ".join(known))
    parser.add_argument("--output", metavar="DIR", required=True,
                        help="folder to write; made if it is not there")
    arguments = parser.parse_args()
    for option, known in lists.items():
        names = getattr(arguments, option).split(",")
        if not set(names) <= set(known):
            parser.error(f"--{option}: expected some of {', '.join(known)}, got {','.join(names)}")
        setattr(arguments, option, names)
    folder = pathlib.Path(arguments.output)
    is_good = arguments.output not in ("", "-")  # nothing; standard output
    try:
        if is_good:
            folder.mkdir(parents=True, exist_ok=True)
            is_good = os.access(folder, os.W_OK)
    except OSError:
        is_good = False
    if not is_good:
        parser.error(f"--output: expected a folder that can be written, got {arguments.output or 'nothing'}")
    arguments.output = folder
    return arguments


def report():
    titles = {row["name"]: row for row in results.read_table(DATA / "report/scenes.csv")}
    arguments = parse(list(titles))
    import render  # pylint: disable=import-outside-toplevel  # matplotlib takes a second: after the arguments
    folder, is_quick = arguments.output, arguments.quick
    try:
        fcntl.flock(os.open(folder, os.O_RDONLY), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise Failed(f"another report is writing {folder}") from None
    peers = environment.Peers() if arguments.peers else None
    for name, why in peers.left_out.items() if peers else ():
        print(f"report: without {name}: {why}", file=sys.stderr)
    facts = facts_now(is_quick, peers)
    prepare(folder, arguments.studies, facts)
    parts = [(study, part) for study in arguments.studies for part in parts_of(study, arguments.scenes, is_quick)
             if not facts["left_out"].get(study)]  # the page says why
    failure = None
    for done, (study, part) in enumerate(parts):
        if sys.stderr.isatty():
            print(f"{done} of {len(parts)} done:", study, *part, file=sys.stderr)
        try:
            extend(results.table(folder, study), study, part, is_quick, peers)
        except (Failed, OSError, subprocess.SubprocessError) as error:  # the page shows the other studies
            failure = error
    render.write(folder, DATA / "report", titles)
    os.write(sys.stdout.fileno(), f"{folder / 'index.html'}\n".encode())  # fails where print would not
    if failure is not None:
        raise Failed(failure)


if __name__ == "__main__":
    try:
        report()
    except KeyboardInterrupt:
        sys.exit("report: interrupted; the same command goes on from here")
    except (Failed, OSError, ImportError) as error:
        sys.exit(f"report: {error}")
