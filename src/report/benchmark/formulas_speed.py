#!/usr/bin/python3
"""The time of q'' in the C code that `formulas` writes, over that of the program's own kernel, in one run.

Medians of 2001 rounds by turns.

    src/report/benchmark/formulas_speed.py [BUILD [OPTION…]]      BUILD: the build folder, by default build; further options of gcc"""

import json
import os
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
SOURCE = HERE.parents[1]
OPTIONS = ["-O3", "-DNDEBUG", "-ffp-contract=off"]


def measure(build, options, n, kind, folder):
    rod = {"mass": 1.0, "inertia": 1 / 12, "com": [0.5, 0.0], "pin": [1.0, 0.0]}
    scene, code, program = (os.path.join(folder, name) for name in (f"rods_{n}.yaml", f"rods_{n}.c", f"rods_{n}"))
    with open(scene, "w", encoding="utf-8") as file:
        json.dump({"chain": [f"link_{i}" for i in range(n)], "links": {f"link_{i}": rod for i in range(n)}}, file)
    subprocess.run([build / "devel/lib/planar_chain/formulas", scene, "--format", "c", *kind, "--output", code], check=True,
                   stdout=subprocess.DEVNULL)
    if not kind:
        with open(code, "a", encoding="utf-8") as file:
            file.write(f"void rods_qdd(double t, const double *q, const double *qd, double *qdd)\n"
                       f"{{\n  rods_{n}_qdd(&rods_{n}_scene, t, q, qd, qdd);\n}}\n")
    subprocess.run(["gcc", "-std=c99", *OPTIONS, *options, "-c", code, "-o", program + ".o"], check=True)
    subprocess.run(["g++", "-std=c++17", *OPTIONS, f"-DLINKS={n}", f"-DQDD=rods_{n}_qdd" if kind else "-DQDD=rods_qdd", f"-I{SOURCE}", f"-I{SOURCE.parent / 'include'}",
                    "-I/usr/include/eigen3", HERE / "formulas.cpp", program + ".o", f"-L{build}/devel/lib", f"-Wl,-rpath,{build}/devel/lib", "-lplanar_chain_core", "-o", program,
                    "-ltinyxml2", "-lyaml-cpp", "-lpthread"], check=True)
    for plain in ("0", "1"):
        print("numbers," if kind else "letters,", "plain kernel," if plain == "1" else "fastest kernel of this CPU,", end=" ", flush=True)
        subprocess.run([program], check=True, env={**os.environ, "PLANAR_CHAIN_PLAIN_KERNEL": plain})


def main():
    build = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "build").resolve()
    with tempfile.TemporaryDirectory() as folder:
        for n in (2, 3):
            for kind in (["--numbers"], []):
                measure(build, sys.argv[2:], n, kind, folder)


if __name__ == "__main__":
    main()
