#!/usr/bin/python3
"""A master that dies, and another that takes its place: the node goes on, those who were connected hear nothing of it,
and those who come then find it. ROS's environment is needed, and no master.
"""

import subprocess
import time
import unittest

import rosgraph
import rospy
from planar_chain.msg import JointTorque
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from bag_load import faults_in
from own_master import Master
from ros_node import LIMIT, Listener, Node, nanoseconds, publisher, rod

FOREIGNER = '/somebody'


def known_to_the_master(kind):
    """Names of topics or services that it knows the node for."""
    entries = rosgraph.Master(FOREIGNER).getSystemState()[['published', 'subscribed', 'served'].index(kind)]
    return {name for name, nodes in entries if '/planar_chain' in nodes}


def everything_known():
    return {kind: known_to_the_master(kind) for kind in ('published', 'subscribed', 'served')}


def wait_until(holds):
    began = time.monotonic()
    while not holds():
        if time.monotonic() - began > LIMIT:
            raise AssertionError('waited in vain')
        time.sleep(0.05)


class MasterDies(unittest.TestCase):
    def newcomer(self, *command):
        """What a program says that is started now."""
        return subprocess.run(command, check=True, stdout=subprocess.PIPE, universal_newlines=True, timeout=LIMIT).stdout

    def test_the_node_is_registered_again_and_loses_nothing(self):
        with Master() as master:
            rospy.init_node('master_dies', disable_signals=True)
            states = Listener('/joint_states', JointState)
            with Node(rod()) as node:
                known_before = set()

                def all_is_known():
                    nonlocal known_before
                    before, known_before = known_before, everything_known()
                    return before == known_before and len(known_before['served']) > 8
                torques = publisher('/planar_chain/joint_torques', Float64MultiArray)
                states.wait_for_count(10)
                wait_until(all_is_known)
                parameters = rospy.get_param('/planar_chain')

                master.kill()
                states.wait_for_count(len(states.messages) + 400)
                master.start()
                torque = publisher('/planar_chain/joint_torque', JointTorque)  # sooner at the master than the node
                wait_until(lambda: everything_known() == known_before)

                # Those who come
                self.assertIn('position', self.newcomer('rostopic', 'echo', '-n', '1', '/joint_states'))
                self.assertIn('<robot', self.newcomer('rosparam', 'get', '/robot_description'))
                self.assertEqual(rosgraph.Master(FOREIGNER).getParam('/planar_chain'), parameters)
                # Those who were there, as nobody else has published the topic since
                torques.publish(data=[0.25])
                states.wait_for(lambda state: state.effort == (0.25,))
                torque.publish(joint='rod_joint', torque=0.5)
                states.wait_for(lambda state: state.effort == (0.5,))
                self.assertIn('success: True', self.newcomer('rosservice', 'call', '/planar_chain/pause'))
                self.assertIn('success: True', self.newcomer('rosservice', 'call', '/planar_chain/step', '{n: 2}'))
                self.assertEqual(faults_in(list(map(nanoseconds, states.messages)), 200, '/joint_states'), [])
            status, log = node.wait()
        self.assertEqual(status, 0, log)
        self.assertEqual(log.count('registered again'), 1, log)


if __name__ == '__main__':
    unittest.main(warnings='ignore')  # of sockets that ROS leaves open
