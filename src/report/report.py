#!/usr/bin/python3
"""Measures error against run time, stability, scaling and more, and writes the page DIR/index.html with its pictures
and its tables as CSV.

A table that the same programs have measured is not measured again, so an interrupted report goes on where it was.
src/report/README.md says what is measured and how.
"""
import argparse
import csv
import datetime
import fcntl
import hashlib
import json
import os
import pathlib
import shlex
import subprocess
import sys

sys.dont_write_bytecode = True  # the script may lie in a folder of sources

# pylint: disable=wrong-import-position
import real_time  # noqa: E402
from race import Failed, list_points, output_of, race  # noqa: E402
from store import lines_of, open_table, read_table, write_whole  # noqa: E402

HERE = pathlib.Path(__file__).absolute().parent
DATA = HERE / "../../share/planar_chain"
OWN, PEERS = HERE / "report_measure", HERE / "report_peers"
STUDIES = ("race", "consistency", "stability", "scaling", "effects", "long", "real_time")
TABLES = {"race": ("work_precision", "work_precision_runs"), **{name: (name,) for name in STUDIES[1:]}}


class Progress:
    """A bar on standard error, if that is a terminal."""

    def __init__(self, total):
        self.total, self.done = max(total, 1), 0
        self.is_shown = sys.stderr.isatty()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.is_shown:
            print("\r\033[K", end="", file=sys.stderr, flush=True)

    def show(self, what):
        if self.is_shown:
            filled = 40 * self.done // self.total
            print(f"\r[{'#' * filled}{'.' * (40 - filled)}] {self.done} of {self.total}: {what}\033[K", end="",
                  file=sys.stderr, flush=True)

    def advance(self):
        self.done += 1


# ---- Studies beside the race ---------------------------------------------------------------------

def study(folder, name, flags, is_quick):
    path = folder / f"{name}.csv"
    if path.exists():
        return
    if name == "stability":
        part = path.with_suffix(".part")
        output_of([HERE / "stability", "--csv", part, *(["--quick"] if is_quick else [])])
        part.replace(path)
        return
    text = output_of([OWN, name, *flags])
    if name == "scaling" and PEERS.exists():
        text += output_of([PEERS, name, *flags])
    write_whole(path, text)


def real_time_study(folder, is_quick, progress):
    if real_time.why_not(HERE):
        return  # and the page says so
    path = folder / "real_time.csv"
    with open_table(path, real_time.COLUMNS) as table:
        done = {(row["links"], row["rate"]) for row in read_table(path)}
        for links, rate in real_time.cells(is_quick):
            progress.show(f"real time: {links} links at {rate} Hz")
            if (str(links), str(rate)) not in done:
                table.write(lines_of(real_time.measure(links, rate, is_quick)))
            progress.advance()


# ---- By what it is measured ----------------------------------------------------------------------

def processor():
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        names = [line.split(":", 1)[1].strip() for line in file if line.startswith("model name")]
    return names[0] if names else "not known"


def digest(*programs):
    return "".join(hashlib.sha256(program.read_bytes()).hexdigest() for program in programs if program.exists())


def facts_by_study(is_quick):
    """What stands under the figures of each study. A table is kept only while these facts stay the same."""
    common = {**json.loads(output_of([OWN, "about", "--data", DATA])), "quick": is_quick, "cpu": processor(),
              "programs": digest(OWN, HERE / "stability")}
    peers = {"engines": json.loads(output_of([PEERS, "about", "--data", DATA])) if PEERS.exists() else {},
             "others": digest(PEERS)}
    node = {"node": digest(HERE / "planar_chain_node", HERE / "report_listen"), "left_out": real_time.why_not(HERE)}
    more = {"race": peers, "scaling": peers, "real_time": node}
    return {name: {**common, **more.get(name, {})} for name in STUDIES}


def prepare(folder, studies, facts):
    """Removes the tables of these studies that other programs measured; notes by what the others are measured."""
    path = folder / "about.json"
    known = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    date = datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d %H:%M UTC")
    words = ["DIR" if pathlib.Path(word) == folder else word for word in sys.argv[1:]]
    for name in studies:
        before = known.get(name, {})
        if all(before.get(fact) == value for fact, value in facts[name].items()):
            continue  # with the date of its first measurements
        for table in TABLES[name]:
            (folder / f"{table}.csv").unlink(missing_ok=True)
        known[name] = {**facts[name], "date": date, "command": "rosrun planar_chain report " + shlex.join(words)}
    write_whole(path, json.dumps(known, indent=1) + "\n")


# ---- The whole -----------------------------------------------------------------------------------

def chosen(text, known, what, parser):
    names = list(known) if text is None else text.split(",")
    for name in names:
        if name not in known:
            parser.error(f'--{what}: expected some of {", ".join(known)}, got "{name}"')
    return names


def parse(scenes):
    parser = argparse.ArgumentParser(prog="report", description=__doc__, allow_abbrev=False,
                                     epilog="Exit status: 0 done; 1 a measurement failed; 2 bad arguments.")
    parser.add_argument("--output", metavar="DIR", required=True, help="folder to write; made if it is not there")
    parser.add_argument("--quick", action="store_true", help="two or three minutes: fewer settings, shorter runs")
    parser.add_argument("--scenes", metavar="NAMES", help="only these of " + ", ".join(scenes))
    parser.add_argument("--studies", metavar="NAMES", help="only these of " + ", ".join(STUDIES))
    arguments = parser.parse_args()
    arguments.scenes = chosen(arguments.scenes, scenes, "scenes", parser)
    arguments.studies = chosen(arguments.studies, STUDIES, "studies", parser)
    arguments.folder = pathlib.Path(arguments.output)
    try:
        arguments.folder.mkdir(parents=True, exist_ok=True)
        if not os.access(arguments.folder, os.W_OK):
            raise PermissionError(f'"{arguments.folder}"')
    except OSError as error:
        parser.error(f"--output: expected a folder that can be written, got {error}")
    return arguments


def report():
    with open(DATA / "report/scenes.csv", encoding="utf-8") as file:
        titles = {row["name"]: row for row in csv.DictReader(file)}
    arguments = parse(titles)
    import render  # pylint: disable=import-outside-toplevel  # matplotlib takes a second: after the arguments
    folder, studies, is_quick = arguments.folder, arguments.studies, arguments.quick
    flags = ["--data", str(DATA), *(["--quick"] if is_quick else [])]
    try:
        fcntl.flock(os.open(folder, os.O_RDONLY), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise Failed(f"another report is writing {folder}") from None
    prepare(folder, studies, facts_by_study(is_quick))
    programs = [program for program in (OWN, PEERS) if program.exists()]
    points = list_points(programs, arguments.scenes, flags) if "race" in studies else []
    others = [name for name in studies if name not in ("race", "real_time")]
    ticks = len(real_time.cells(is_quick)) if "real_time" in studies else 0
    failure = None
    with Progress(len(points) + len(others) + ticks) as progress:
        if points:
            race(folder, points, flags, progress)
        for name in others:
            progress.show(name)
            study(folder, name, flags, is_quick)
            progress.advance()
        try:
            if ticks:
                real_time_study(folder, is_quick, progress)
        except (OSError, subprocess.SubprocessError) as error:  # the other studies' page is written nevertheless
            failure = error
    render.write(folder, DATA / "report", titles)
    print(folder / "index.html")
    if failure is not None:
        raise Failed(failure)


def main():
    try:
        report()
        return 0
    except KeyboardInterrupt:
        print("report: interrupted; the same command goes on from here", file=sys.stderr)
    except (Failed, OSError, ImportError) as error:
        print(f"report: {error}", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
