#!/usr/bin/python3
"""What nobody listens to is not made, by callgrind."""

import os
import tempfile
import unittest

import rospy
import rostest
from planar_chain.msg import LinkStates, SimStatus
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage

import callgrind
from ros_node import Listener, Node, rod

# topic: (its type, what makes it)
MESSAGES = {
    '/joint_states': (JointState, 'planar_chain::Messages::jointStates('),
    '/tf': (TFMessage, 'planar_chain::Messages::transforms('),
    '/planar_chain/link_states': (LinkStates, 'planar_chain::Messages::linkStates('),
    '/planar_chain/status': (SimStatus, 'planar_chain::describe('),
}


def made(*topics):
    """The topics whose messages are made in the ticks of a node while somebody listens to these."""
    listeners = [Listener(topic, MESSAGES[topic][0]) for topic in topics]
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, 'out')
        with Node(rod(), prefix=callgrind.prefix('planar_chain::Node::serveTicks*', out)):
            for listener in listeners:
                listener.wait_for_count(2)
        functions = {function for function, _ in callgrind.read(out).where}
    for listener in listeners:
        listener.close()
    return {topic for topic, (_, maker) in MESSAGES.items()
            if any(function.startswith(maker) for function in functions)}


class LeftOut(unittest.TestCase):
    def check(self, *topics):
        self.assertEqual(made(*topics), set(topics))

    def test_joint_states_and_tf_alone(self):
        self.check('/joint_states', '/tf')

    def test_link_states_and_status_alone(self):
        self.check('/planar_chain/link_states', '/planar_chain/status')


if __name__ == '__main__':
    rospy.init_node('ros_left_out', anonymous=True)
    rostest.rosrun('planar_chain', 'ros_left_out', LeftOut)
