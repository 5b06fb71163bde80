#!/usr/bin/python3
"""How much slower auto is than the best of this program's other methods: auto_cells.py [TABLE] [--cheapest]

A cell is a scene and an error, 1e-3 to 1e-11. TABLE is a report's work_precision.csv. Times are interpolated between
settings, as on the report's page; with --cheapest that of the cheapest setting whose error is no larger. Then an error
just above the bound costs a decade of the tolerance. Prints how many cells lie within 1.25, and those beyond 1.1."""
import argparse
import pathlib
import sys

ROOT = pathlib.Path(__file__).absolute().parents[2]
sys.path.insert(0, str(ROOT / "src/report"))
import results  # noqa: E402  pylint: disable=wrong-import-position


def cheapest(group, level):
    return min((float(row["cpu_seconds"]) for row in group if float(row["error_theta"]) <= 10.0**-level), default=None)


def interpolated(group, level):
    return results.at_level(group, level, "cpu_seconds")


def cells(rows, time_of):
    """(ratio, scene, error, fastest method) of each cell that auto and another method reach."""
    for scene, group in results.grouped(rows, "scene").items():
        by_method = results.by_contestant(group)
        for level, error in results.LEVELS.items():
            times = {who: time_of(runs, level) for who, runs in by_method.items()}
            times = {who: time for who, time in times.items() if time}
            auto = times.pop(results.AUTO, None)
            if auto and times:
                fastest = min(times, key=times.get)
                yield auto / times[fastest], scene, error, fastest[1]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("table", nargs="?", type=pathlib.Path, default=ROOT / "src/report/page/work_precision.csv")
    parser.add_argument("--cheapest", action="store_true")
    options = parser.parse_args()
    rows = [row for row in results.read_table(options.table) if row["engine"] == results.OWN]
    found = sorted(cells(rows, cheapest if options.cheapest else interpolated), reverse=True)
    print(f"{len(found)} cells, {sum(cell[0] <= 1.25 for cell in found)} within 1.25")
    for ratio, scene, error, method in found:
        if ratio > 1.1:
            print(f"{ratio:5.2f}  {scene} at {error}: {method}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
