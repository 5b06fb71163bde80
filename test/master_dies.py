#!/usr/bin/python3
"""What is left of a running node when the master is killed and another one takes its place. By hand: starts masters,
node and subscribers of its own, on a free port.
"""

import os
import socket
import subprocess
import sys
import tempfile
import time

import rosgraph
import rospy
from sensor_msgs.msg import JointState

from ros_node import Listener, Node, rod


def free_port():
    with socket.socket() as one:
        one.bind(('', 0))
        return one.getsockname()[1]


def start_master():
    """A bare rosmaster, so that nothing else tidies up."""
    master = subprocess.Popen(['rosmaster', '--core', '-p', os.environ['ROS_MASTER_URI'].rpartition(':')[2]],
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while not rosgraph.is_master_online():
        time.sleep(0.05)
    return master


def newcomer_hears(seconds):
    """Whether a subscriber that comes now gets a message."""
    topic = subprocess.Popen(['timeout', str(seconds), 'rostopic', 'echo', '-n', '1', '/joint_states'],
                             stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return topic.wait() == 0


def main():
    os.environ['ROS_MASTER_URI'] = 'http://localhost:%d' % free_port()
    os.environ['ROS_LOG_DIR'] = tempfile.mkdtemp()
    answers = []

    def tell(what, holds):
        answers.append(holds)
        print('%-75s %s' % (what, 'yes' if holds else 'no'), flush=True)

    master = start_master()
    try:
        rospy.init_node('master_dies')
        states = Listener('/joint_states', JointState)
        with Node(rod()) as node:
            states.wait_for_count(10)
            tell('a subscriber that comes hears the node', newcomer_hears(20))
            master.kill()
            master.wait()
            seen = len(states.messages)
            states.wait_for_count(seen + 400)
            tell('without a master, those who were connected hear it', True)
            master = start_master()
            seen = len(states.messages)
            states.wait_for_count(seen + 400)
            tell('with another master, those who were connected hear it', True)
            tell('with another master, the node is registered again', '/planar_chain' in {
                name for _, names in rosgraph.Master('/test').getSystemState()[0] for name in names})
            tell('with another master, a subscriber that comes hears it', newcomer_hears(5))
            tell('the node goes on', node.process.poll() is None)
    finally:
        master.kill()
        master.wait()
    sys.exit(0 if answers == [True, True, True, False, False, True] else 1)


if __name__ == '__main__':
    main()
