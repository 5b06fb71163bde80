"""Measures error against run time: every method of every program, with every setting, scene by scene."""
import itertools
import pathlib
import statistics
import subprocess

from store import lines_of, open_table, read_table, write_rows

COLUMNS = ("scene", "engine", "method", "setting", "error_theta", "error_omega", "cpu_seconds", "evaluations", "steps",
           "rejected", "worst_step_seconds", "outcome")
RUN_COLUMNS = ("scene", "engine", "method", "setting", "runs", "cpu_seconds_least")


class Failed(Exception):
    """A program that measures has failed."""


def output_of(command):
    result = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                            universal_newlines=True, check=False)
    if result.returncode != 0:
        raise Failed(f"{pathlib.Path(command[0]).name} {command[1]}: {result.stderr.strip()}")
    return result.stdout


class Racer:
    """A program that measures one point after the other: report_measure, or report_peers."""

    def __init__(self, program, flags):
        self.command = [str(program), "race", *flags]
        self.process = None

    def measure(self, point):
        """Returns the point's columns, the columns of its runs, and the number of turns to measure it in."""
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
            if pathlib.Path(self.command[0]).name == "report_measure":
                raise Failed(f"report_measure crashed at {', '.join(point)}")
            # A crash of another program costs this point only.
            cells = [*point, "nan", "nan", "nan", "0", "0", "0", "nan", "refused", "1", "nan", "1"]
        return cells[:len(COLUMNS)], [*point, *cells[len(COLUMNS):-1]], int(cells[-1])

    def close(self):
        if self.process is not None:
            self.process.stdin.close()
            self.process.stdout.close()
            self.process.wait()
            self.process = None


def together(turns):
    """Combines the turns of a point to its columns and the columns of its runs."""
    cells, runs = list(turns[0][0]), list(turns[0][1])
    for row, columns, index, name, combine, form in ((cells, COLUMNS, 0, "cpu_seconds", statistics.median, "{:.6e}"),
                                                     (cells, COLUMNS, 0, "worst_step_seconds", min, "{:.3e}"),
                                                     (runs, RUN_COLUMNS, 1, "runs", sum, "{:.0f}"),
                                                     (runs, RUN_COLUMNS, 1, "cpu_seconds_least", min, "{:.6e}")):
        column = columns.index(name)
        row[column] = form.format(combine([float(turn[index][column]) for turn in turns]))
    return cells, runs


def key(row):
    return row["scene"], row["engine"], row["method"], row["setting"]


def sort_rows(path, columns, points):
    """Puts the rows in the order of the points, scene by scene, however they were measured."""
    rows = read_table(path)
    place = {point: k for k, (_, point) in enumerate(points)}
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    rows.sort(key=lambda row: (scenes.index(row["scene"]), place.get(key(row), len(place))))
    write_rows(path, columns, rows)


def list_points(programs, scenes, flags):
    """(program, point) of everything that is to be measured, scene by scene."""
    points = [(program, tuple(line.split(","))) for program in programs
              for line in output_of([program, "list", *flags]).splitlines()]
    return [(program, point) for scene in scenes for program, point in points if point[0] == scene]


def measure_scene(racers, points, too_slow, progress):
    """Returns the turns of each point.

    The speed of a processor drifts over seconds. Short runs are therefore divided among several turns through all
    methods, so that the drift is the same for all."""
    measured = {}
    while points:
        again = []
        for program, point in points:
            progress.show(" ".join(point))
            turns = measured.get(point, [])
            # A tighter setting than one that timed out takes longer still.
            if turns or point[:3] not in too_slow:
                *turn, wanted = racers[program].measure(point)
                measured[point] = [*turns, turn]
                if turn[0][-1] == "timed out":
                    too_slow.add(point[:3])
                if len(measured[point]) < wanted:
                    again.append((program, point))
            if not turns:
                progress.advance()
        points = again
    return measured


def race(folder, points, flags, progress):
    """Measures the points that the folder's tables do not hold yet; writes them at the end of each scene."""
    table, runs = folder / "work_precision.csv", folder / "work_precision_runs.csv"
    with open_table(table, COLUMNS) as table_file, open_table(runs, RUN_COLUMNS) as runs_file:
        rows = read_table(table)
        done = {key(row) for row in rows}
        too_slow = {key(row)[:3] for row in rows if row["outcome"] == "timed out"}
        progress.done = sum(point in done for _, point in points)
        racers = {program: Racer(program, flags) for program in {program for program, _ in points}}
        for _, scene in itertools.groupby(points, key=lambda each: each[1][0]):
            missing = [each for each in scene if each[1] not in done]
            measured = [together(turns) for turns in measure_scene(racers, missing, too_slow, progress).values()]
            runs_file.write(lines_of(times for _, times in measured))
            table_file.write(lines_of(cells for cells, _ in measured))
        for racer in racers.values():
            racer.close()
    sort_rows(table, COLUMNS, points)
    sort_rows(runs, RUN_COLUMNS, points)
