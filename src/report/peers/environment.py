#!/usr/bin/python3
"""The programs of PyPI that the report compares with: a virtual environment in the user's cache, and report_peers built against it.

As a program, it makes the environment alone, for the benchmark, and prints the options for cmake.
"""
import json
import os
import pathlib
import subprocess
import sys
import venv

REQUIREMENTS = {"heyoka": "heyoka==7.13.2", "Pinocchio": "pin==4.1.0", "MuJoCo": "mujoco==4.0.0", "Drake": "drake==1.51.1",
                "Exudyn": "exudyn==1.13.6"}
FROM_PYTHON = {"heyoka": "{} (Taylor's method, compiled for each scene; closed forms, or the articulated recursion)",
               "Drake": "{} (MultibodyPlant in continuous time)", "Exudyn": "{} (without range checks; kinematic tree, or plane bodies)"}
FOLDER = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "planar_chain/peers"
HERE = pathlib.Path(__file__).resolve().parent
SOURCE = HERE.parents[2]
SITE = FOLDER / f"lib/python{sys.version_info[0]}.{sys.version_info[1]}/site-packages"
OPTIONS = [f"-DPLANAR_CHAIN_PINOCCHIO={SITE}/cmeel.prefix/include", f"-DCMAKE_INCLUDE_PATH={SITE}/mujoco/include",
           f"-DCMAKE_LIBRARY_PATH={SITE}/mujoco"]  # of cmake
BUILD = SOURCE / "build/peers"
PROGRAM = BUILD / "devel/lib/planar_chain/report_peers"


def run(*command):
    """Returns the last line of what a command that failed says; empty if it did not."""
    try:
        result = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                universal_newlines=True, check=False)
    except OSError as error:
        return str(error)
    return (result.stdout.strip().splitlines() or ["failed"])[-1] if result.returncode else ""


def install():
    """Makes the environment. Returns {program: why it is left out}."""
    try:
        if not (FOLDER / "bin/pip").exists():
            venv.create(FOLDER, with_pip=True, clear=True)
    except (OSError, subprocess.CalledProcessError) as error:
        return {name: f"no virtual environment: {error}" for name in REQUIREMENTS}
    failed = {name: run(FOLDER / "bin/pip", "install", "--quiet", "--disable-pip-version-check", requirement)
              for name, requirement in REQUIREMENTS.items()}
    for library in SITE.glob("mujoco/libmujoco.so.*"):  # the linker's name
        link = library.with_name("libmujoco.so")
        if not link.exists():
            link.symlink_to(library.name)
    return {name: f"no {REQUIREMENTS[name]}: {why}" for name, why in failed.items() if why}


def build():
    """Builds report_peers. Returns why it cannot be built; empty if it is."""
    if not (SOURCE / "CMakeLists.txt").exists():
        return f"no sources in {SOURCE}"
    return (run("cmake", "-S", SOURCE, "-B", BUILD, "-DPYTHON_EXECUTABLE=/usr/bin/python3", "-DPLANAR_CHAIN_ROS=OFF",
                "-DPLANAR_CHAIN_REPORT_PEERS=ON", *OPTIONS) or
            run("cmake", "--build", BUILD, "--target", "planar_chain_report_peers", "--parallel", os.cpu_count()))


class Peers:
    """What `report --peers` compares with, and why the rest is left out."""

    def __init__(self):
        self.left_out = install()
        why = build()
        if why:
            self.left_out["report_peers"] = why
        self.programs = [PROGRAM, *sorted(HERE.glob("*.py"))]
        self.scripts = {name: HERE / f"{name.lower()}_race.py" for name in FROM_PYTHON if name not in self.left_out}

    def commands(self, study, arguments, equations):
        """The command lines that print rows of a study."""
        if study in ("race", "scaling") and "report_peers" not in self.left_out:
            yield [PROGRAM, *arguments]
        for name, script in self.scripts.items():
            if study == "race" or (study, name) == ("peers", "heyoka"):
                yield [FOLDER / "bin/python", "-B", script, *arguments, "--equations", equations]

    def versions(self):
        """{program: version and settings}, or why it is left out."""
        built = {} if "report_peers" in self.left_out else json.loads(subprocess.run(
            [PROGRAM, "--study", "about"], stdout=subprocess.PIPE, check=True).stdout)
        return {**built, **{name: text.format(REQUIREMENTS[name].split("==")[1]) for name, text in FROM_PYTHON.items()},
                **{name: f"left out: {why}" for name, why in self.left_out.items()}}


if __name__ == "__main__":
    for NAME, WHY in install().items():
        print(f"Without {NAME}: {WHY}", file=sys.stderr)
    print(*OPTIONS, sep="\n")
