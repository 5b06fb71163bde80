"""The chain of a scene, as `equations --chain` writes it out."""

import json
import pathlib
import subprocess
import sys

EQUATIONS = pathlib.Path(sys.argv[0]).absolute().parent / "equations"  # beside the program that was started


class NoChain(Exception):
    """Why `equations` refused the scene."""


def read_chain(scene, text=None):
    """scene: path of a YAML file or a .urdf, or /dev/stdin for text."""
    given = ["--urdf", scene] if scene.endswith(".urdf") else [scene]
    run = subprocess.run([str(EQUATIONS), *given, "--chain"], input=text, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                         universal_newlines=True, check=False)
    if run.returncode != 0:
        raise NoChain(run.stderr.strip())
    return json.loads(run.stdout)
