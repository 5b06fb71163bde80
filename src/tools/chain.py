"""The chain of a scene, as `equations --chain` writes it out."""

import json
import pathlib
import subprocess
import sys

from files import notes_by

EQUATIONS = pathlib.Path(sys.argv[0]).absolute().parent / "equations"  # beside the program that was started


class NoChain(Exception):
    """Why `equations` refused the scene."""


def read_chain(scene, text=None):
    """scene: as of `equations`, or /dev/stdin for text."""
    run = subprocess.run([str(EQUATIONS), scene, "--chain"], input=text, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                         universal_newlines=True, check=False)
    if run.returncode != 0:
        raise NoChain(run.stderr.strip())
    return json.loads(run.stdout)


def scene_from(path, say):
    """The Scene of a path, whose notes it says. A URDF in it is written out as links: their numbers may vary."""
    from planar_chain import Scene  # pylint: disable=import-outside-toplevel  # plot does not need it
    with notes_by(say):
        scene = Scene.from_file(path)
    values = scene.to_dict()
    if values.pop("robot_description", None) is None:
        return scene
    chain, links = read_chain(path), {}
    for link, q, qd in zip(chain["links"], chain["q"], chain["qd"]):
        joint = {key: value for key, value in link["joint"].items() if value or value == 0 and key in ("lower", "upper")}
        initial = {"position" if "axis" in joint else "angle": q, "velocity": qd}
        name = link.pop("name")
        links[name] = {**link, "joint": joint, **({} if "drive" in joint else {"initial": initial})}
    with notes_by(lambda note: None):  # they came
        return Scene({**values, "chain": list(links), "gravity": chain["gravity"], "links": links})
