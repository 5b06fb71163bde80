#!/usr/bin/python3
"""Scenes through the parameter server: what is wrong with one is said in the same words as for a file, and
ends the node; every scene that ships runs."""

import contextlib
import glob
import math
import os
import unittest

import rosparam
import rospy
import rostest
from planar_chain.msg import SimStatus
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from ros_node import Listener, Node, nanoseconds, rod

TEST = os.path.join(os.path.dirname(os.path.realpath(__file__)), '..')
BAD = sorted(glob.glob(os.path.join(TEST, 'bad_scenes', '*.yaml')))
GOOD = sorted(glob.glob(os.path.join(TEST, '..', 'config', 'scenes', '*.yaml')))

# rosparam itself cannot load these, or loses what is wrong with them.
ONLY_FILES = ('broken_', 'duplicate_')

AT_ONCE = 8  # nodes that end by themselves


def load(path):
    (scene, _), = rosparam.load_file(path)
    return scene


def has_empty_map(value):
    """rosparam does not hand over an empty map: to the node it is absent."""
    if isinstance(value, dict):
        return not value or any(map(has_empty_map, value.values()))
    return isinstance(value, list) and any(map(has_empty_map, value))


def expected_faults(path):
    """A trailing ... stands for any rest."""
    mark = '# expect: '
    with open(path, encoding='utf-8') as lines:
        return [line[len(mark):].strip() for line in lines if line.startswith(mark)]


class Scenes(unittest.TestCase):
    def assert_refused(self, node, faults):
        status, output = node.wait()
        self.assertEqual(status, 2, output)
        for fault in faults:
            self.assertIn(fault[:-3] if fault.endswith('...') else fault, output)
        self.assertEqual(output.count('FATAL'), len(faults), output)

    def test_every_bad_scene_ends_the_node_with_every_fault(self):
        bad = [path for path in BAD if not os.path.basename(path).startswith(ONLY_FILES)]
        bad = [path for path in bad if not has_empty_map(load(path))]
        self.assertGreater(len(bad), 20)
        for first in range(0, len(bad), AT_ONCE):
            with contextlib.ExitStack() as stack:
                nodes = [(path, stack.enter_context(Node(load(path), '/bad_%d' % k)))
                         for k, path in enumerate(bad[first:first + AT_ONCE])]
                for path, node in nodes:
                    with self.subTest(os.path.basename(path)):
                        self.assertTrue(expected_faults(path))
                        self.assert_refused(node, expected_faults(path))

    def test_without_a_scene_the_node_says_how_to_load_one(self):
        with Node({}) as node:
            self.assert_refused(node, ['/planar_chain/chain: expected a scene in the node\'s parameters '
                                       '(roslaunch planar_chain sim.launch scene:=double_pendulum'])

    def test_every_scene_that_ships_runs(self):
        self.assertTrue(GOOD)
        for path in GOOD:
            with self.subTest(os.path.basename(path)):
                states = Listener('/joint_states', JointState)
                statuses = Listener('/planar_chain/status', SimStatus)
                with Node(load(path)):
                    states.wait_for_count(20)
                    later = statuses.wait_for(lambda status: status.sim_time > 0)
                states.close()
                statuses.close()
                self.assertEqual(statuses.messages[later].fault, '')
                for state in states.messages:
                    values = state.position + state.velocity + state.effort
                    self.assertTrue(all(map(math.isfinite, values)))


    def test_a_failed_integration_keeps_the_last_good_state_and_says_so(self):
        # Beyond all numbers from a time on.
        scene = rod(loads={'blast': {'joint': 'rod_joint', 'torque': 1e200, 'start': 0.3}})
        states = Listener('/joint_states', JointState)
        statuses = Listener('/planar_chain/status', SimStatus)
        with Node(scene):
            fault = statuses.wait_for(lambda status: status.fault)
            # The status goes on, with time and stamps of states standing still.
            statuses.wait_for_count(fault + 10)
        states.close()
        statuses.close()
        first, later = statuses.messages[fault], statuses.messages[fault + 9]
        self.assertIn('the last good state is kept', first.fault)
        self.assertEqual(later.sim_time, first.sim_time)
        self.assertGreater(nanoseconds(later), nanoseconds(first))
        self.assertLess(nanoseconds(states.messages[-1]), nanoseconds(first) + 1)
        for state in states.messages:
            self.assertTrue(all(map(math.isfinite, state.position + state.velocity + state.effort)))
        for status in statuses.messages:
            self.assertTrue(all(map(math.isfinite, (
                status.kinetic, status.potential, status.work_supplied, status.dissipated,
                status.energy_balance, status.error_estimate, status.sim_time))))

    def test_a_scene_too_heavy_for_the_machine_falls_behind_and_still_listens(self):
        scene = rod(integrator={'method': 'rk4', 'step': 2e-6})
        scene['links']['rod'].update(repeat=200)
        scene['publish'] = {'rate': 1000.0}
        for clock in ({}, {'real_time_factor': 0.8}):
            statuses = Listener('/planar_chain/status', SimStatus)
            out = rospy.Publisher('/planar_chain/joint_torques', Float64MultiArray, queue_size=10, latch=True)
            with self.subTest(clock), Node(dict(scene, **clock)):
                out.publish(data=[1.0])
                refused = statuses.wait_for(lambda status: status.rejected_commands > 0)
                slow = statuses.wait_for(lambda status: status.lag > 1.5, refused)
                self.assertGreater(statuses.messages[slow].overruns, 0)
                self.assertLess(statuses.messages[slow].real_time_factor, 0.7)
            out.unregister()
            statuses.close()


if __name__ == '__main__':
    rospy.init_node('ros_scenes', anonymous=True)
    rostest.rosrun('planar_chain', 'ros_scenes', Scenes)
