"""The identified model of a real double pendulum, driven by the torques that its motors reported.

The recordings and their source: test/reference/robot.
"""
import bisect
import csv
import json
import math
import pathlib
import subprocess
import tempfile

RUNS = {"swing_up_01": "a swing-up", "sysid_143339": "an identification run"}
MODELS = {"friction": {}, "without": {"friction": False}}
ROWS = 2000  # per second, of the computed motion: finer than the measured one by four
GEAR_RATIO, ROTOR = 6, 6.2872e-5  # kg m², of the motor
# (mass, inertia about the inner joint, centre of mass, length; damping, friction): kg, kg m², m, m; N m s/rad, N m
LINKS = {"upper": (0.52346, 0.031887, 0.2, 0.2, 0.001, 0.16),
         "lower": (0.62557, 0.050870, 0.25569, 0.3, 0.001, 0.12)}


def measured(path):
    """The first second of a recording: columns by their names."""
    with open(path, encoding="utf-8", newline="") as file:
        rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
    rows = [row for row in rows if row["t"] <= rows[0]["t"] + 1]
    return {name: [row[name] for row in rows] for name in rows[0]}


def scene(data, friction=True, rotors=True):
    """The model, from the first measured state on, with the measured torques. x points down: q = 0 hangs."""
    times = [t - data["t"][0] for t in data["t"]]
    links, loads = {}, {}
    for i, (name, (mass, inertia, com, length, damping, coulomb)) in enumerate(LINKS.items(), 1):
        joint = {"damping": damping}
        if friction:
            joint["friction"] = coulomb
        if rotors:
            joint["rotor_inertia"] = GEAR_RATIO ** 2 * ROTOR
        links[name] = {"mass": mass, "inertia": inertia - mass * com ** 2, "com": [com, 0], "pin": [length, 0],
                       "joint": joint, "initial": {"angle": data[f"q{i}"][0], "velocity": data[f"qd{i}"][0]}}
        loads[f"motor_{i}"] = {"joint": f"{name}_joint", "torque": 1, "times": times, "values": data[f"tau{i}"]}
    return {"chain": list(LINKS), "links": links, "loads": loads, "gravity": [9.81, 0]}


def between(times, values, t):
    """Linear between the values."""
    k = min(max(bisect.bisect_right(times, t), 1), len(times) - 1)
    share = (t - times[k - 1]) / (times[k] - times[k - 1])
    return values[k - 1] + share * (values[k] - values[k - 1])


def computed(simulate, data, **options):
    """Both angles at the measured times, rad, by the tool at the path `simulate`."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "scene.yaml").write_text(json.dumps(scene(data, **options)), encoding="utf-8")
        subprocess.run([simulate, folder / "scene.yaml", "--duration", "1", "--rate", str(ROWS), "--csv",
                        folder / "out.csv"], stdout=subprocess.DEVNULL, check=True, timeout=60)
        with open(folder / "out.csv", encoding="utf-8", newline="") as file:
            _, *rows = csv.reader(file)
    t, *angles = [[float(row[k]) for row in rows] for k in range(3)]
    return [[between(t, q, time - data["t"][0]) for time in data["t"]] for q in angles]


def misses(data, angles):
    """The root mean square of the error of each angle, rad."""
    return [math.sqrt(sum((a - b) ** 2 for a, b in zip(q, data[f"q{i}"])) / len(q)) for i, q in enumerate(angles, 1)]


def measure(simulate, folder):
    """A table with a header: both angles, measured and computed, at every other measured time; folder: the recordings'."""
    table = ["run,t" + "".join(f",{motion}_{k}" for motion in ("measured", *MODELS) for k in (1, 2)) + "\n"]
    for run in RUNS:
        data = measured(folder / f"{run}.csv")
        angles = [data["q1"], data["q2"], *(q for options in MODELS.values() for q in computed(simulate, data, **options))]
        table += [f"{run},{t - data['t'][0]:.4f}," + ",".join(f"{q:.5f}" for q in row) + "\n"
                  for t, *row in list(zip(data["t"], *angles))[::2]]
    return "".join(table)
