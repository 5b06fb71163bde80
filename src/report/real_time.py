"""Measures how late the node's ticks come: roslaunch starts a node and rosbag record, a cell at a time.

A cell is a rope of so many rods of 0.1 m at so many ticks a second, with a loosest_tolerance or none.
"""
import os
import pathlib
import shutil
import socket
import struct
import subprocess
import tempfile

# A row says which share of the ticks comes later than its seconds; share 0 is the worst tick.
SHARES = (1, 0.9, 0.75, 0.5, 0.25, 0.1, 0.03, 0.01, 0.003, 0.001, 0.0003, 0.0001, 0)
SETTLING = 2  # s, in which processes start and connect

SCENE = """chain: [first, rod]
links:
  first: {{mass: 0.1, inertia: 8.333333333333333e-5, com: [0.05, 0], pin: [0.1, 0], initial: {{angle: -1.0}}}}
  rod: {{mass: 0.1, inertia: 8.333333333333333e-5, com: [0.05, 0], pin: [0.1, 0], repeat: {more}}}
integrator: {{tolerance: 1.0e-8{yields}}}
publish: {{rate: {rate}, tf: false, link_states: false, status_rate: 10.0}}
"""
LAUNCH = """<launch>
  <node pkg="planar_chain" type="planar_chain_node" name="planar_chain"><rosparam file="{folder}/scene.yaml"/></node>
  <node pkg="rosbag" type="record" name="record" required="true"
    args="--tcpnodelay --duration {seconds} -O {folder}/ticks.bag /joint_states /planar_chain/status"/>
</launch>
"""


def why_not(here):
    """Returns why the study cannot be made; empty if it can."""
    if not (here / "planar_chain_node").exists():
        return "the package was built without ROS"
    return "" if shutil.which("roslaunch") else "roslaunch was not found"


def cells(is_quick):
    """(links, ticks a second, loosest_tolerance)"""
    return [(n, rate, loosest) for n in ((2, 100) if is_quick else (2, 10, 100, 1000)) for rate in (200, 1000)
            for loosest in ("none", "0.01")]


def read(path):
    """(stamp, arrival) of each tick after settling, s; how often the node overran meanwhile."""
    import rosbag  # pylint: disable=import-outside-toplevel  # the other studies need no ROS
    with rosbag.Bag(str(path)) as bag:
        begin = bag.get_start_time() + SETTLING
        ticks = [(struct.unpack_from("<II", message[1], 4), arrival.to_sec()) for _, message, arrival
                 in bag.read_messages("/joint_states", raw=True) if arrival.to_sec() > begin]
        overruns = [status.overruns for _, status, arrival in bag.read_messages("/planar_chain/status")
                    if arrival.to_sec() > begin]
    return [(s + 1e-9 * ns, arrival) for (s, ns), arrival in ticks], overruns[-1] - overruns[0]


def measure(links, rate, loosest, is_quick):
    """The table of a cell, with a header. Raises OSError when no tick comes."""
    yields = "" if loosest == "none" else f", loosest_tolerance: {loosest}"
    with tempfile.TemporaryDirectory() as folder:
        room = pathlib.Path(folder)
        (room / "scene.yaml").write_text(SCENE.format(more=links - 1, rate=float(rate), yields=yields), encoding="utf-8")
        (room / "run.launch").write_text(LAUNCH.format(folder=folder, seconds=SETTLING + (2 if is_quick else 10)),
                                         encoding="utf-8")
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = str(free.getsockname()[1])
        result = subprocess.run(["roslaunch", "--port", port, str(room / "run.launch")], stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT, universal_newlines=True, timeout=120, check=False,
                                env={**os.environ, "ROS_HOSTNAME": "localhost", "ROS_HOME": folder,
                                     "ROS_LOG_DIR": folder})
        if not (room / "ticks.bag").exists():
            raise OSError(f"real time, {links} links at {rate} Hz, loosest_tolerance {loosest}: {result.stdout[-2000:]}")
        ticks, overruns = read(room / "ticks.bag")
    late = sorted(arrival - stamp for stamp, arrival in ticks)
    missing = round((ticks[-1][0] - ticks[0][0]) * rate) + 1 - len(ticks)
    facts = f"{links},{rate},{loosest},{len(late)},{sum(each > 1 / rate for each in late)},{missing},{overruns}"
    rows = [f"{facts},{share:g},{late[min(len(late) - 1, int((1 - share) * len(late)))]:.4e}\n" for share in SHARES]
    return "links,rate,loosest_tolerance,ticks,beyond_a_period,missing,overruns,share,seconds\n" + "".join(rows)
