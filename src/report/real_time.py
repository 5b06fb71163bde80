"""Measures how late the node's ticks come and what each costs: roslaunch starts a node and a listener, a cell at a time.

A cell is a rope of so many rods of 0.1 m at so many ticks a second.
"""
import os
import pathlib
import shutil
import socket
import subprocess
import tempfile

COLUMNS = ("links", "rate", "quantity", "ticks", "beyond_a_period", "missing", "overruns", "share", "seconds")
# A row says which share of the ticks takes longer than its seconds; share 0 is the worst tick.
SHARES = (1, 0.9, 0.75, 0.5, 0.25, 0.1, 0.03, 0.01, 0.003, 0.001, 0.0003, 0.0001, 0)

SCENE = """chain: [first, rod]
links:
  first: {{mass: 0.1, inertia: 8.333333333333333e-5, com: [0.05, 0], pin: [0.1, 0], initial: {{angle: -1.0}}}}
  rod: {{mass: 0.1, inertia: 8.333333333333333e-5, com: [0.05, 0], pin: [0.1, 0], repeat: {more}}}
publish: {{rate: {rate}, tf: false, link_states: false, status_rate: 10.0}}
"""
LAUNCH = """<launch>
  <node pkg="planar_chain" type="planar_chain_node" name="planar_chain"><rosparam file="{folder}/scene.yaml"/></node>
  <node pkg="planar_chain" type="report_listen" name="report_listen" required="true"
    args="{folder}/ticks {seconds} {folder}/scene.yaml"/>
</launch>
"""


def why_not(here):
    """Returns why the study cannot be made; empty if it can."""
    if not (here / "planar_chain_node").exists():
        return "the package was built without ROS"
    return "" if shutil.which("roslaunch") else "roslaunch was not found"


def cells(is_quick):
    """(links, ticks a second)"""
    return [(n, rate) for n in ((2, 100) if is_quick else (2, 10, 100, 1000))
            for rate in ((100, 1000) if is_quick else (100, 500, 1000))]


def free_port():
    with socket.socket() as opened:
        opened.bind(("127.0.0.1", 0))
        return opened.getsockname()[1]


def measure(links, rate, is_quick):
    """Returns the rows of a cell. Raises OSError when no tick comes."""
    with tempfile.TemporaryDirectory() as folder:
        room = pathlib.Path(folder)
        (room / "scene.yaml").write_text(SCENE.format(more=links - 1, rate=float(rate)), encoding="utf-8")
        (room / "run.launch").write_text(LAUNCH.format(folder=folder, seconds=2 if is_quick else 10), encoding="utf-8")
        result = subprocess.run(["roslaunch", "--port", str(free_port()), str(room / "run.launch")],
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True, timeout=120,
                                check=False, env={**os.environ, "ROS_HOSTNAME": "localhost", "ROS_HOME": folder,
                                                  "ROS_LOG_DIR": folder})
        if not (room / "ticks").exists():
            raise OSError(f"real time, {links} links at {rate} Hz: {result.stdout[-2000:]}")
        lines = [line.split() for line in (room / "ticks").read_text(encoding="utf-8").splitlines()]
    counts = {word: value for word, value in lines if word in ("missing", "overruns")}
    rows = []
    for quantity in ("late", "work"):
        values = sorted(float(value) for word, value in lines if word == quantity)
        beyond = sum(value > 1 / rate for value in values)
        for share in SHARES:
            exceeded = values[min(len(values) - 1, int((1 - share) * len(values)))]
            rows.append((str(links), str(rate), quantity, str(len(values)), str(beyond), counts["missing"],
                         counts["overruns"], f"{share:g}", f"{exceeded:.4e}"))
    return rows
