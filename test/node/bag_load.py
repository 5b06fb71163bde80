#!/usr/bin/python3
"""A chain of ten links, at 1000 Hz if nothing else is said, recorded by the real rosbag: no stamp lost, none doubled, sim time as
fast as wall time, and what it costs.

    bag_load.py [SECONDS [HZ]]

needs a master (roscore) and runs the node itself. Ends with status 1 when something is amiss. At 1000 Hz
the machine must have nothing else to do: rosbag keeps 100 messages a topic, so what it may wait for a
processor is 0.1 s.
"""

import os
import sys
import tempfile
import time

import rosbag
import rospy
from planar_chain.msg import LinkStates
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage

from ros_node import LIMIT, Listener, Node, Running, nanoseconds

TF_RATE = 100


def scene_at(rate):
    return {
        'chain': ['link'],
        'links': {'link': {'mass': 0.2, 'inertia': 0.001, 'com': [0.1, 0.0], 'pin': [0.2, 0.0],
                           'repeat': 10, 'joint': {'damping': 0.01}}},
        'publish': {'rate': rate, 'tf_rate': TF_RATE},
    }


def cpu_seconds(pid):
    """Time that a process has spent computing, user and system."""
    with open('/proc/%d/stat' % pid) as stat:
        fields = stat.read().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def record(path, seconds, rate):
    """Runs node and rosbag for so long; returns the node's share of a processor."""
    states = Listener('/joint_states', JointState)
    with Node(scene_at(rate)) as node:
        with Running('rosbag', 'record', '-q', '-O', path, '/joint_states',
                     '/planar_chain/link_states', '/tf', '/tf_static'):
            wait_for_recorder()
            states.wait_for_count(1)
            states.close()
            began, computed = time.monotonic(), cpu_seconds(node.process.pid)
            rospy.rostime.wallsleep(seconds)
            return (cpu_seconds(node.process.pid) - computed) / (time.monotonic() - began)


def wait_for_recorder():
    """Until rosbag has subscribed to the last of its topics."""
    waited = time.monotonic()
    master = rospy.get_master()
    while True:
        subscribers = dict(master.getSystemState()[2][1])
        if any(name.startswith('/record') for name in subscribers.get('/tf_static', [])):
            return
        if time.monotonic() - waited > LIMIT:
            raise RuntimeError('rosbag record does not subscribe')
        rospy.rostime.wallsleep(0.05)


def faults_in(stamps, rate, topic):
    """What is wrong with stamps (ns) that should follow each other at `rate`."""
    step = 1e9 / rate
    faults = []
    for i in range(1, len(stamps)):
        ticks = (stamps[i] - stamps[i - 1]) / step
        if abs(ticks - 1) > 1e-5:
            faults.append('%s: message %d comes %.5f ticks after the one before' % (topic, i, ticks))
    return faults


def check(path, rate):
    """@returns the faults of a bag, the messages on joint_states, and their real-time factor."""
    stamps = {'/joint_states': [], '/planar_chain/link_states': [], '/tf': []}
    received = []
    with rosbag.Bag(path) as bag:
        for topic, message, time_received in bag.read_messages(topics=list(stamps)):
            first = message.transforms[0] if topic == '/tf' else message
            stamps[topic].append(nanoseconds(first))
            if topic == '/joint_states':
                received.append(time_received.to_nsec())
    faults = []
    for topic, its_rate in (('/joint_states', rate), ('/planar_chain/link_states', rate), ('/tf', TF_RATE)):
        if len(stamps[topic]) < 2:
            faults.append(topic + ': nothing recorded')
        faults += faults_in(stamps[topic], its_rate, topic)
    of_joints = stamps['/joint_states']
    factor = (of_joints[-1] - of_joints[0]) / (received[-1] - received[0])
    return faults, len(of_joints), factor


def main():
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 60.0
    rate = float(sys.argv[2]) if len(sys.argv) > 2 else 1000.0
    rospy.init_node('bag_load', anonymous=True)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, 'load.bag')
        share = record(path, seconds, rate)
        faults, count, factor = check(path, rate)
    # The first and last message may each be received some 10 ms late.
    allowed = max(0.001, 0.02 / seconds)
    if abs(factor - 1) > allowed:
        faults.append('real-time factor %.5f, not within %.4f of 1' % (factor, allowed))
    print('10 links at %g Hz, %g s: %d messages on joint_states, real-time factor %.5f, '
          'node takes %.1f %% of a processor' % (rate, seconds, count, factor, 100 * share))
    for fault in faults[:20]:
        print(fault)
    sys.exit(1 if faults else 0)


if __name__ == '__main__':
    main()
