#!/usr/bin/python3
"""Stamps: evenly spaced from the index, strictly increasing, none lost or doubled, live and in a bag of the
real rosbag."""

import os
import tempfile
import unittest

import numpy as np
import rospy
import rostest
from planar_chain.msg import SimStatus
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

import bag_load
from ros_node import Listener, Node, nanoseconds, rod, service, spinning


class Stamps(unittest.TestCase):
    def run_rod(self, rate, tf_rate, count):
        """Returns the messages that arrive while `count` messages of joint_states are published."""
        states = Listener('/joint_states', JointState)
        transforms = Listener('/tf', TFMessage)
        with Node(rod(publish={'rate': rate, 'tf_rate': tf_rate})):
            states.wait_for_count(count)
        states.close()
        transforms.close()
        return ([nanoseconds(message) for message in states.messages],
                [nanoseconds(message.transforms[0]) for message in transforms.messages])

    def test_stamps_are_the_start_and_whole_ticks(self):
        # 3 ticks make 10 ms only when each is rounded by itself: nothing adds up.
        states, transforms = self.run_rod(300.0, 100.0, 300)
        self.assertGreater(states[0], 0)
        for i, stamp in enumerate(states):
            # Less than a nanosecond from tick to tick, however many there were.
            self.assertLessEqual(abs(stamp - states[0] - i * 1e9 / 300), 1)
        self.assertTrue(all(later > sooner for sooner, later in zip(transforms, transforms[1:])))
        meanwhile = {stamp for stamp in transforms if states[0] <= stamp <= states[-1]}
        self.assertLessEqual(meanwhile, set(states))
        self.assertEqual(bag_load.faults_in(transforms, 100, '/tf'), [])

    def test_tf_rate_need_not_divide_the_rate(self):
        states, transforms = self.run_rod(200.0, 70.0, 400)
        gaps = {round((later - sooner) / 5e6) for sooner, later in zip(transforms, transforms[1:])}
        self.assertEqual(gaps, {2, 3})
        seconds = (transforms[-1] - transforms[0]) * 1e-9
        self.assertAlmostEqual((len(transforms) - 1) / seconds, 70, delta=0.7)

    def test_a_measurement_from_before_a_pause_has_the_stamp_of_its_state(self):
        states, measured = Listener('/joint_states', JointState), Listener('/planar_chain/arm', JointState)
        statuses = Listener('/planar_chain/status', SimStatus)
        with Node(rod(links=spinning(), sensors={'arm': {'joints': 'all', 'rate': 200.0, 'delay': 0.3}})):
            measured.wait_for_count(50)
            self.assertTrue(service('pause', Trigger)().success)
            statuses.wait_for_count(len(statuses.messages) + 10)
            self.assertTrue(service('resume', Trigger)().success)
            measured.wait_for_count(len(measured.messages) + 100)
        for one in (states, measured, statuses):
            one.close()
        self.assertGreater(max(np.diff([nanoseconds(state) for state in states.messages])), 0.3e9, 'the pause')
        positions = {nanoseconds(state): state.position for state in states.messages}
        first = min(positions)
        for one in measured.messages:
            if nanoseconds(one) > first:
                self.assertEqual(one.position, positions[nanoseconds(one)])

    def test_rosbag_loses_and_doubles_nothing(self):
        # At 200 Hz rosbag's own queue of 100 messages lasts half a second, however busy the machine.
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, 'load.bag')
            bag_load.record(path, 5.0, 200.0)
            faults, count, _ = bag_load.check(path, 200.0)
        self.assertEqual(faults, [])
        self.assertGreater(count, 200)


if __name__ == '__main__':
    rospy.init_node('ros_stamps', anonymous=True)
    rostest.rosrun('planar_chain', 'ros_stamps', Stamps)
