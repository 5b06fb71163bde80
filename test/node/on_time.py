#!/usr/bin/python3
"""A rope of 1000 links, let go level, in the node on one core, for a minute: how late its ticks come.

    on_time.py [SECONDS]

Tolerance 1e-6, which may yield to 1e-2; 200 Hz. Then prints how far its angles are from those of a run at 1e-9.
"""
import csv
import itertools
import json
import os
import signal
import subprocess
import sys
import tempfile
import time

import rosbag

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../support"))
from own_master import Master  # noqa: E402

RATE, EVERY = 200, 5  # Hz, s
ROD = {"mass": 0.1, "inertia": 0.1 * 0.1 ** 2 / 12, "com": [0.05, 0], "pin": [0.1, 0], "repeat": 1000}
SCENE = {"chain": ["rod"], "links": {"rod": ROD}, "integrator": {"tolerance": 1e-6, "loosest_tolerance": 1e-2},
         "publish": {"rate": RATE, "status_rate": 10}}


def record(folder, seconds):
    """The bag of a node that runs by itself on core 0."""
    bag = os.path.join(folder, "run.bag")
    subprocess.run(["rosparam", "load", os.path.join(folder, "scene.yaml"), "/planar_chain"], check=True)
    recorder = subprocess.Popen(["rosbag", "record", "--tcpnodelay", "--duration", str(seconds + 5), "-O", bag, "/joint_states",
                                 "/planar_chain/status", "/planar_chain/commands_taken"], stdout=subprocess.DEVNULL)
    time.sleep(3)
    node = subprocess.Popen(["taskset", "-c", "0", "rosrun", "planar_chain", "planar_chain_node"])
    recorder.wait()
    node.send_signal(signal.SIGINT)
    node.wait()
    return bag


def absolute(q):
    return list(itertools.accumulate(q))


def read(bag):
    """Prints how late the ticks came. Returns the absolute angles every so many seconds."""
    with rosbag.Bag(bag) as messages:
        ticks = [(message.header.stamp.to_sec(), arrival.to_sec(), message.position)
                 for _, message, arrival in messages.read_messages("/joint_states")]
        states = [status for _, status, _ in messages.read_messages("/planar_chain/status")]
    start = states[-1].tick_stamp.to_sec() - states[-1].scene_time
    late = max(arrival - stamp for stamp, arrival, _ in ticks)
    (first, begin, _), (last, end, _) = ticks[RATE], ticks[-1]
    print(f"{len(ticks)} ticks, the latest {1e3 * late:.1f} ms late; after 1 s the real-time factor was "
          f"{(last - first) / (end - begin):.5f}; tolerances up to {max(state.tolerance for state in states):g}")
    numbers = [round((stamp - start) * RATE) for stamp, *_ in ticks]
    return {number // RATE: absolute(q) for number, (_, _, q) in zip(numbers, ticks) if number % (EVERY * RATE) == 0}


def compute(folder, seconds):
    """Returns the angles of read() by a run at 1e-9."""
    path = os.path.join(folder, "exact.csv")
    subprocess.run(["rosrun", "planar_chain", "simulate", os.path.join(folder, "scene.yaml"), "--tolerance", "1e-9",
                    "--duration", str(seconds), "--rate", "10", "--csv", path], stdout=subprocess.DEVNULL, check=True)
    with open(path, newline="") as file:
        _, *rows = csv.reader(file)
    return {round(float(row[0])): absolute(map(float, row[1:1 + ROD["repeat"]])) for row in rows[::10 * EVERY]}


def main():
    seconds = int(sys.argv[1]) if len(sys.argv) > 1 else 60
    with tempfile.TemporaryDirectory() as folder, Master():
        with open(os.path.join(folder, "scene.yaml"), "w") as file:
            json.dump(SCENE, file)
        got, exact = read(record(folder, seconds)), compute(folder, seconds)
    for t in sorted(got.keys() & exact.keys()):
        print(f"t = {t} s: {max(abs(a - b) for a, b in zip(got[t], exact[t])):.1e} rad from a run at 1e-9")


if __name__ == "__main__":
    main()
