"""The chain of a Scene with all defaults, repeated links and URDFs written out."""

import json
import pathlib
import subprocess

import planar_chain
from planar_chain._core import _prefix


def described(scene):
    """The object that `equations --chain` prints. Raises RuntimeError."""
    tool = pathlib.Path(planar_chain.__file__).absolute().parent / _prefix / "lib/planar_chain/equations"
    run = subprocess.run([str(tool), "/dev/stdin", "--chain"], input=json.dumps(planar_chain.Scene.to_dict(scene)), stdout=subprocess.PIPE,
                         stderr=subprocess.PIPE, universal_newlines=True, check=False)
    if run.returncode != 0:
        raise RuntimeError(run.stderr.strip())
    return json.loads(run.stdout)
