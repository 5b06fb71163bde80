#!/usr/bin/python3
"""The measured figures of README.md and test/README.md. Without options: names those that do not match their table, page/readme.json.

Exit status: 0 all match; 1 some do not, or a measurement failed.
"""
import argparse
import csv
import difflib
import json
import pathlib
import re
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PAGES, TABLE = (ROOT / "README.md", ROOT / "test/README.md"), HERE / "page/readme.json"
IN_SPACE = ("Bullet", "Pinocchio", "MuJoCo")  # shown in README.md
WORDS = ("no one two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen sixteen seventeen "
         "eighteen nineteen twenty").split()


def output_of(*command):
    return subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, check=True, cwd=ROOT,
                          universal_newlines=True).stdout


# ---- Measure -------------------------------------------------------------------------------------

def speed():
    """ns a link of one evaluation on crooked chains: {engine: {links: time}}, and by what it was measured."""
    sys.path.insert(0, str(HERE / "benchmark"))
    import tables  # pylint: disable=import-outside-toplevel
    group = "evaluation/crooked"
    output_of(HERE / "benchmark/run", "--peers", f"--benchmark_filter={group}")
    results = tables.Results(ROOT / "build/benchmark/result.json", 0.1)
    times = {kind: {n: round(time, 3) for n in results.sizes(group)
                    for time in [results.per_link(f"{group}/{kind}", n)] if time} for kind in results.kinds(group)}
    versions = {engine: re.match(r"[0-9]+\.[0-9]+", results.context[engine]).group() for engine in IN_SPACE if engine in times}
    return {"times": times, "versions": versions, "cpu": tables.processor(), "commit": results.context[tables.OURS]}


def roundings(build):
    """The largest error of an angle by dopri5 on the scenes of trajectory_test, in roundings."""
    with tempfile.TemporaryDirectory() as folder:
        output_of(build / "test/trajectory_test", "--gtest_filter=*WhatDoubleAllows*", f"--gtest_output=xml:{folder}/a.xml")
        text = pathlib.Path(folder, "a.xml").read_text(encoding="utf-8")
    errors = re.findall(r'"dopri5_angle_error_in_roundings" value="([0-9.]+)"', text)
    return {"roundings": max(map(float, errors)), "trajectories": len(errors)}


def apart(build, scene, duration, reference=None, *settings):
    """The largest difference of an absolute angle at the end from that of a file, or from another method's."""
    sys.path.insert(0, str(ROOT / "test/motions"))
    import compare_csv  # pylint: disable=import-outside-toplevel

    def run(path, *options):
        output_of(build / "devel/lib/planar_chain/simulate", f"config/scenes/{scene}.yaml", "--duration", duration,
                  "--rate", 1 / float(duration), "--csv", path, *options)
        return path

    with tempfile.TemporaryDirectory() as folder:
        ours = run(f"{folder}/a.csv")
        error, reach = compare_csv.compare(ours, reference or run(f"{folder}/b.csv", *settings))[0]
    return {"error": error, "reach": reach}


def measure(build):
    about = json.loads(output_of(build / "devel/lib/planar_chain/report_measure", "--study", "about"))
    facts = {"exact": {"commit": about["commit"], "compiler": about["compiler"], **roundings(build),
                       "beam": apart(build, "beam", 5, ROOT / "test/reference/beam.csv"),
                       "cable": apart(build, "cable", 10, None, "--method", "radau13", "--tolerance", "1e-6")},
             "speed": {"compiler": about["compiler"], **speed()}}
    TABLE.write_text(json.dumps(facts, indent=1) + "\n", encoding="utf-8")


# ---- Write ---------------------------------------------------------------------------------------

def number(value, form="{:.2g}"):
    """Two digits, or three from 100 on; a dash for what was not measured."""
    if value is None:
        return "–"
    return f"{float(f'{value:.3g}'):,.0f}" if value >= 100 else form.format(value)


def table(rows):
    return "\n".join("| " + " | ".join(cells) + " |" for cells in rows)


def speeds(facts, race):
    """Patterns of README.md and the figures in their places."""
    times = {engine: {int(n): time for n, time in group.items()} for engine, group in facts["times"].items()}
    rows = []
    for n in (2, 10, 100, 1000, 10000):
        closed = times["closed form"].get(n)
        by_hand = f"{number(closed)} (closed form)" if closed else number(times["dense"].get(n))
        rows.append([f"{n:,}" if n >= 10000 else str(n), number(times["planar_chain"][n]), by_hand,
                     *(number(times[engine].get(n)) for engine in facts["versions"])])
    heads = ["links", "planar_chain", "M and f by hand, Cholesky", *(" ".join(head) for head in facts["versions"].items())]
    sys.path.insert(0, str(HERE))
    import results  # pylint: disable=import-outside-toplevel
    others = {row["engine"] for row in race} - {"planar_chain", "by hand", *results.INTEGRATORS}
    return {r"(?<=Measured on one core of ).*?(?= \(\[how)": facts["cpu"],
            r"\| links \|.*\n(\|.*\n)+": table([heads]) + "\n|" + "--:|" * len(heads) + "\n" + table(rows) + "\n",
            r"(?<=more scenes and )\w+(?=\s+other)": WORDS[len(others)]}


def errors(facts):
    """Patterns of test/README.md."""
    beam, cable = facts["beam"], facts["cable"]
    return {r"(?<=Last measured with ).*(?=\.\n)": f"{facts['compiler']} at commit {facts['commit']}",
            r"(?<=\n\|---\|---\|---\|--:\|\n)(\|.*\n)+": table([
                [f"{facts['trajectories']} motions of 1 to 100 links", "`dopri5`, 1e-12", "quadruple precision",
                 f"{facts['roundings']:.2g} times the error that rounding the scene's numbers causes"],
                ["`beam`: 40 stiff links, 5 s", "`auto`, 1e-8", "the published solution", f"{beam['error']:.2g} rad"],
                ["`cable`: 10,000 stiff links, 10 s", "`rodas5p`, 0.15", "`radau13`, 1e-6",
                 f"{cable['error']:.2g} rad; angles reach {cable['reach']:.2g} rad"]]) + "\n"}


def written(page, figures):
    """A page's text with these figures."""
    text = page.read_text(encoding="utf-8")
    for pattern, figure in figures.items():
        text, count = re.subn(pattern, lambda _: figure, text)  # pylint: disable=cell-var-from-loop
        if count != 1:
            sys.exit(f"readme: {page.relative_to(ROOT)} has {count} places for {pattern}")
    return text


def main():
    parser = argparse.ArgumentParser(prog="readme", description=__doc__, allow_abbrev=False)
    parser.add_argument("--measure", metavar="BUILD", type=pathlib.Path,
                        help="measures anew, with the programs in this folder of a build; then --write")
    parser.add_argument("--write", action="store_true", help="writes the pages from the table")
    arguments = parser.parse_args()
    if arguments.measure:
        measure(arguments.measure.resolve())
    with open(HERE / "page/work_precision.csv", encoding="utf-8", newline="") as file:
        race = list(csv.DictReader(file))
    facts = json.loads(TABLE.read_text(encoding="utf-8"))
    differ = False
    for page, figures in zip(PAGES, (speeds(facts["speed"], race), errors(facts["exact"]))):
        text, expected = page.read_text(encoding="utf-8"), written(page, figures)
        if arguments.measure or arguments.write:
            page.write_text(expected, encoding="utf-8")
            continue
        sys.stdout.writelines(difflib.unified_diff(text.splitlines(True), expected.splitlines(True), page.name, TABLE.name))
        differ = differ or text != expected
    return int(differ)


if __name__ == "__main__":
    sys.exit(main())
