#!/usr/bin/python3
"""What each constant of a source file is worth: knobs.py FILE BUILD [--scenes FOLDER] [--method M] [--only NAME …]

For every `constexpr double` or `int` of FILE, such as src/ode/fastest_steps.cpp, runs the scenes with half of it and with
twice as much. Prints, over the program's own value, the geometric mean of the evaluations of f of all scenes, and the best
and the worst scene. BUILD: a folder where `planar_chain_simulate` was built. A copy of FILE is compiled, in which the
environment sets the constants; FILE and BUILD stay as they are."""
import argparse
import math
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).absolute().parents[2]
KNOB = re.compile(r"^(\s*)(static )?constexpr (double|int) (\w+) = ([^;]+);", re.MULTILINE)
DURATIONS = {"cable": 0.02, "hanging_cable": 0.5}  # s; others: 2


def program(file, build, folder):
    """A simulate whose knobs the environment sets; and their names."""
    text = file.read_text(encoding="utf-8")
    names = [match[4] for match in KNOB.finditer(text)]
    text = KNOB.sub(r'\1\2inline const \3 \4 = static_cast<\3>(std::getenv("\4") ? std::atof(std::getenv("\4")) * (\5)'
                    r" : (\5));", text)
    copy = folder / "knobs.cpp"
    copy.write_text("#include <cstdlib>\n" + text, encoding="utf-8")
    flags = (build / "CMakeFiles/planar_chain_core.dir/flags.make").read_text(encoding="utf-8")
    flags = " ".join(re.findall(r"^CXX_(?:DEFINES|INCLUDES|FLAGS) = (.*)$", flags, re.MULTILINE))
    subprocess.run(["c++", *shlex.split(flags), "-c", str(copy), "-o", str(folder / "knobs.o")], check=True)
    link = shlex.split((build / "CMakeFiles/planar_chain_simulate.dir/link.txt").read_text(encoding="utf-8"))
    link[link.index("-o") + 1] = str(folder / "simulate")
    link.insert(link.index("-o"), str(folder / "knobs.o"))  # before the library, whose own is then left out
    subprocess.run(link, cwd=build, check=True)
    return names


def evaluations(simulate, scene, method, knobs):
    duration = DURATIONS.get(scene.stem, 2)
    done = subprocess.run([str(simulate), str(scene), "--duration", str(duration), "--method", method],
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True,
                          env={**os.environ, **knobs}, check=False)
    count = re.search(r"(\d+) evaluations", done.stdout)
    return int(count[1]) if count else math.inf


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("file", type=pathlib.Path)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--scenes", type=pathlib.Path, default=ROOT / "config/scenes")
    parser.add_argument("--method", default="auto")
    parser.add_argument("--only", nargs="*", default=[])
    options = parser.parse_args()
    scenes = sorted(options.scenes.glob("*.yaml"))
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        knobs = program(options.file, options.build.absolute(), folder)
        own = [evaluations(folder / "simulate", scene, options.method, {}) for scene in scenes]
        for knob in knobs:
            if options.only and knob not in options.only:
                continue
            for factor in ("0.5", "2"):
                ratios = [evaluations(folder / "simulate", scene, options.method, {knob: factor}) / before
                          for scene, before in zip(scenes, own)]
                mean = math.exp(sum(map(math.log, ratios)) / len(ratios))
                best, worst = min(zip(ratios, scenes)), max(zip(ratios, scenes))
                print(f"{knob:18} × {factor:4} {mean:7.3f}   {best[0]:7.3f} {best[1].stem:16} {worst[0]:7.3f} "
                      f"{worst[1].stem}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
