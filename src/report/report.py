#!/usr/bin/python3
"""Measures error against run time, stability, scaling and more, and writes DIR/index.html with its tables as CSV.

What a table of DIR already holds, measured by the same programs, is not measured again: an interrupted report goes on
where it was. test/report/README.md says what is measured and how.
"""
import argparse
import csv
import datetime
import fcntl
import hashlib
import itertools
import json
import os
import pathlib
import shlex
import statistics
import subprocess
import sys

sys.dont_write_bytecode = True  # the script may lie in a folder of sources

import report_real_time as real_time  # noqa: E402  pylint: disable=wrong-import-position

HERE = pathlib.Path(__file__).absolute().parent
DATA = HERE / "../../share/planar_chain"
OWN, PEERS = HERE / "report_measure", HERE / "report_peers"
STUDIES = ("race", "consistency", "stability", "scaling", "effects", "long", "real_time")
COLUMNS = ("scene", "engine", "method", "setting", "error_theta", "error_omega", "cpu_seconds", "evaluations", "steps",
           "rejected", "worst_step_seconds", "outcome")
RUN_COLUMNS = ("scene", "engine", "method", "setting", "runs", "cpu_seconds_least")
TABLES = {"race": ("work_precision", "work_precision_runs"), **{name: (name,) for name in STUDIES[1:]}}


class Failed(Exception):
    """A program that measures did not do it."""


# ---- What the user sees --------------------------------------------------------------------------

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


# ---- Tables --------------------------------------------------------------------------------------

def read_table(path):
    if not path.exists():
        return []
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def output_of(command, **options):
    result = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                            universal_newlines=True, check=False, **options)
    if result.returncode != 0:
        raise Failed(f"{pathlib.Path(command[0]).name} {command[1]}: {result.stderr.strip()}")
    return result.stdout


def write_whole(path, text):
    """All of it or nothing."""
    part = path.with_suffix(".part")
    part.write_text(text, encoding="utf-8")
    part.replace(path)


def write_rows(path, columns, rows):
    lines = [columns, *([row[name] for name in columns] for row in rows)]
    write_whole(path, "".join(",".join(cells) + "\n" for cells in lines))


class Table:
    """A file that grows by a line at a time."""

    def __init__(self, path, columns):
        # What a killed process left of a line is dropped.
        lines = path.read_text(encoding="utf-8").splitlines(True) if path.exists() else []
        lines = [line for line in lines if line.endswith("\n")] or [",".join(columns) + "\n"]
        write_whole(path, "".join(lines))
        self.file = open(path, "a", encoding="utf-8")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.file.close()

    def add_all(self, rows):
        """At once, so that all or none of them are there."""
        self.file.write("".join(",".join(cells) + "\n" for cells in rows))
        self.file.flush()

    def add(self, cells):
        self.add_all([cells])


# ---- Error against run time ----------------------------------------------------------------------

class Racer:
    """A program that measures points, one after the other."""

    def __init__(self, program, flags):
        self.command = [str(program), "race", *flags]
        self.process = None

    def measure(self, point):
        """The columns of the point, those of its runs, and in how many turns it wants to be measured."""
        if self.process is None:
            self.process = subprocess.Popen(self.command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                            stderr=subprocess.DEVNULL, universal_newlines=True)
        try:
            print(",".join(point), file=self.process.stdin, flush=True)
            cells = self.process.stdout.readline().strip().split(",")
        except BrokenPipeError:
            cells = []
        if len(cells) != len(COLUMNS) + 3:
            self.close()
            if self.command[0] == str(OWN):
                raise Failed(f"report_measure broke down at {', '.join(point)}")
            # A peer that breaks down takes only this point with it.
            cells = [*point, "nan", "nan", "nan", "0", "0", "0", "nan", "refused", "1", "nan", "1"]
        return cells[:len(COLUMNS)], [*point, *cells[len(COLUMNS):-1]], int(cells[-1])

    def close(self):
        if self.process is not None:
            self.process.stdin.close()
            self.process.stdout.close()
            self.process.wait()
            self.process = None


def key(row):
    return row["scene"], row["engine"], row["method"], row["setting"]


def sort_rows(path, columns, points):
    """Scene by scene in the order of the points, whenever they were measured: each method's loosest setting first."""
    rows = read_table(path)
    place = {point: k for k, (_, point) in enumerate(points)}
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    rows.sort(key=lambda row: (scenes.index(row["scene"]), place.get(key(row), len(place))))
    write_rows(path, columns, rows)


def list_points(scenes, flags):
    """(program, point) of everything that is to be measured, scene by scene."""
    points = []
    for program in (OWN, PEERS):
        if program.exists():
            points += [(program, tuple(line.split(","))) for line in output_of([program, "list", *flags]).splitlines()]
    return [(program, point) for scene in scenes for program, point in points if point[0] == scene]


def together(turns):
    """The columns of a point, and of its runs, from those of its turns."""
    cells, runs = list(turns[0][0]), list(turns[0][1])

    def combine(row, columns, name, by, text):
        values = [turn[row][columns.index(name)] for turn in turns]
        (cells, runs)[row][columns.index(name)] = text(by([float(value) for value in values]))

    combine(0, COLUMNS, "cpu_seconds", statistics.median, "{:.6e}".format)
    combine(0, COLUMNS, "worst_step_seconds", min, "{:.3e}".format)
    combine(1, RUN_COLUMNS, "runs", sum, "{:.0f}".format)
    combine(1, RUN_COLUMNS, "cpu_seconds_least", min, "{:.6e}".format)
    return cells, runs


def race(folder, points, flags, progress):
    """Scene by scene. A processor has its moods, which last for seconds: short runs are measured in several turns, so
    that all methods meet the same."""
    with Table(folder / "work_precision.csv", COLUMNS) as table, \
            Table(folder / "work_precision_runs.csv", RUN_COLUMNS) as runs:
        rows = read_table(folder / "work_precision.csv")
        done = {key(row) for row in rows}
        too_slow = {key(row)[:3] for row in rows if row["outcome"] == "timed out"}
        racers = {program: Racer(program, flags) for program in (OWN, PEERS)}

        def write(turns):
            cells, times = together(turns)
            runs.add(times)
            table.add(cells)

        for _, scene in itertools.groupby(points, key=lambda each: each[1][0]):
            short = []
            for program, point in scene:
                progress.show(" ".join(point))
                # Tighter settings than one that took too long take longer still.
                if point not in done and point[:3] not in too_slow:
                    *first, wanted = racers[program].measure(point)
                    if wanted > 1:
                        short.append((program, point, wanted, [first]))
                    else:
                        write([first])
                    if first[0][-1] == "timed out":
                        too_slow.add(point[:3])
                progress.advance()
            for turn in range(2, 1 + max((wanted for _, _, wanted, _ in short), default=0)):
                for program, point, wanted, turns in short:
                    progress.show(f"{' '.join(point)}, turn {turn}")
                    if turn <= wanted:
                        turns.append(racers[program].measure(point)[:2])
            for *_, turns in short:
                write(turns)
        for racer in racers.values():
            racer.close()
    sort_rows(folder / "work_precision.csv", COLUMNS, points)
    sort_rows(folder / "work_precision_runs.csv", RUN_COLUMNS, points)


# ---- The other studies ---------------------------------------------------------------------------

def study(folder, name, flags, quick):
    path = folder / f"{name}.csv"
    if path.exists():
        return
    if name == "stability":
        part = folder / "stability.part"
        output_of([HERE / "stability", "--csv", part, *(["--quick"] if quick else [])])
        part.replace(path)
        return
    text = output_of([OWN, name, *flags])
    if name == "scaling" and PEERS.exists():
        text += output_of([PEERS, name, *flags])
    write_whole(path, text)


def real_time_study(folder, quick, progress):
    if real_time.why_not(HERE):
        return  # and the page says so
    with Table(folder / "real_time.csv", real_time.COLUMNS) as table, real_time.Master() as master:
        done = {(row["links"], row["rate"]) for row in read_table(folder / "real_time.csv") if row["share"] == "0"
                and row["quantity"] == "work"}
        for links, rate in real_time.cells(quick):
            progress.show(f"real time: {links} links at {rate} Hz")
            if (str(links), str(rate)) not in done:
                table.add_all(real_time.measure(master, links, rate, quick))
            progress.advance()


# ---- The whole -----------------------------------------------------------------------------------

def processor():
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        for line in file:
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return "not known"


def digest(program):
    return hashlib.sha256(program.read_bytes()).hexdigest() if program.exists() else ""


def about(arguments):
    """What stands under each figure, and what must be the same for a table to be gone on with."""
    facts = json.loads(output_of([OWN, "about", "--data", DATA]))
    facts["engines"] = json.loads(output_of([PEERS, "about", "--data", DATA])) if PEERS.exists() else {}
    facts.update(programs=digest(OWN) + digest(HERE / "stability"), others=digest(PEERS),
                 node=digest(HERE / "planar_chain_node") + digest(HERE / "report_listen"), quick=arguments.quick,
                 cpu=processor(), left_out=real_time.why_not(HERE))
    return facts


def keep_own(path, columns):
    """Drops the lines of other engines."""
    write_rows(path, columns, [row for row in read_table(path) if row["engine"] == "planar_chain"])


def prepare(folder, studies, facts):
    """Keeps what the same programs measured of these studies, removes what others did."""
    path = folder / "about.json"
    known = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    for name in studies:
        before = known.get(name, {})
        changed = {fact for fact, value in facts.items() if before.get(fact) != value}
        if changed - {"engines", "others", "node", "left_out"} or name == "real_time" and "node" in changed:
            for table in TABLES[name]:
                (folder / f"{table}.csv").unlink(missing_ok=True)
        elif changed & {"engines", "others"} and name == "race":
            keep_own(folder / "work_precision.csv", COLUMNS)
            keep_own(folder / "work_precision_runs.csv", RUN_COLUMNS)
        elif changed & {"engines", "others"} and name == "scaling":
            (folder / "scaling.csv").unlink(missing_ok=True)
        if before and not changed:
            continue  # gone on with: it keeps the date of its measurements
        date = datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d %H:%M UTC")
        words = ["DIR" if pathlib.Path(word) == folder else word for word in sys.argv[1:]]
        known[name] = {**facts, "date": date, "command": "rosrun planar_chain report " + shlex.join(words)}
    write_whole(path, json.dumps(known, indent=1) + "\n")


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
    try:
        folder = pathlib.Path(arguments.output)
        folder.mkdir(parents=True, exist_ok=True)
        if not os.access(folder, os.W_OK):
            raise PermissionError(f'"{folder}"')
    except OSError as error:
        parser.error(f"--output: expected a folder that can be written, got {error}")
    arguments.folder = folder
    return arguments


def report():
    with open(DATA / "report/scenes.csv", encoding="utf-8") as file:
        titles = {row["name"]: row for row in csv.DictReader(file)}
    arguments = parse(list(titles))
    import report_page  # pylint: disable=import-outside-toplevel  # matplotlib takes a second: after the arguments
    folder = arguments.folder
    flags = ["--data", str(DATA), *(["--quick"] if arguments.quick else [])]
    try:
        fcntl.flock(os.open(folder, os.O_RDONLY), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise Failed(f"another report is writing {folder}") from None
    prepare(folder, arguments.studies, about(arguments))
    points = list_points(arguments.scenes, flags) if "race" in arguments.studies else []
    others = [name for name in arguments.studies if name not in ("race", "real_time")]
    ticks = len(real_time.cells(arguments.quick)) if "real_time" in arguments.studies else 0
    with Progress(len(points) + len(others) + ticks) as progress:
        if points:
            race(folder, points, flags, progress)
        for name in others:
            progress.show(name)
            study(folder, name, flags, arguments.quick)
            progress.advance()
        failure = None
        try:
            if ticks:
                real_time_study(folder, arguments.quick, progress)
        except (OSError, subprocess.SubprocessError) as error:  # the other studies' page is written nevertheless
            failure = error
    report_page.write(folder, DATA / "report", titles)
    print(f"{folder / 'index.html'}")
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
