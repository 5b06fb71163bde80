#!/usr/bin/python3
"""The node of a machine: rest, the wrench on the base, effort limits, driven joints."""

import math
import unittest

import rospy
import rostest
from geometry_msgs.msg import WrenchStamped
from planar_chain.msg import CommandTaken, JointTorque, LinkStates, SimStatus
from planar_chain.srv import SetState, Step
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import Trigger

from ros_node import Listener, Node, ROD_INERTIA, nanoseconds, publisher, rod, service

LINK = {'mass': 2.0, 'inertia': 0.3, 'com': [0.4, 0.0], 'pin': [1.0, 0.0]}


def link(joint=(), **more):
    return dict(LINK, joint=dict(joint), **more)


def machine(links, **more):
    return rod(**dict({'chain': sorted(links), 'links': links}, **more))


class Machines(unittest.TestCase):
    def setUp(self):
        self.states = Listener('/joint_states', JointState)
        self.statuses = Listener('/planar_chain/status', SimStatus)

    def tearDown(self):
        self.states.close()
        self.statuses.close()

    def next_status(self, holds=lambda status: True):
        return self.statuses.messages[self.statuses.wait_for(holds, len(self.statuses.messages) + 1)]

    def ask(self, name, success=True):
        answer = service(name, Trigger)()
        self.assertEqual(answer.success, success, answer.message)
        return answer.message

    # ---- Rest ------------------------------------------------------------------------------------

    def test_settle_puts_the_chain_at_rest_and_shows_it_once(self):
        with Node(rod(gravity=[0.0, -9.81])):
            self.states.wait_for_count(20)
            self.ask('pause')
            still = self.next_status(lambda status: status.paused)
            self.next_status()  # and what is under way has come
            seen = len(self.states.messages)
            self.assertIn('equilibrium', self.ask('settle'))
            self.states.wait_for_count(seen + 1)
            settled = self.states.messages[seen]
            self.assertAlmostEqual(settled.position[0], -math.pi / 2, delta=1e-12)
            self.assertEqual(settled.velocity, (0.0,))
            after = self.next_status(lambda status: status.tick == still.tick + 1)
            self.assertEqual(after.scene_time, still.scene_time)
            self.next_status()
            self.assertEqual(len(self.states.messages), seen + 1)
            # It stays there. Before it has been shown, a step shows it as the tick before.
            self.ask('settle')
            step = service('step', Step)
            for state in step([], 100).states:
                self.assertAlmostEqual(state.position[0], -math.pi / 2, delta=1e-12)
            self.ask('resume')
            self.states.wait_for_count(len(self.states.messages) + 20)
        stamps = list(map(nanoseconds, self.states.messages))
        self.assertTrue(all(later > sooner for sooner, later in zip(stamps, stamps[1:])))

    def test_settle_where_there_is_no_rest_changes_nothing(self):
        with Node(rod(loads={'motor': {'joint': 'rod_joint', 'torque': 1.0}})):
            self.states.wait_for_count(20)
            self.ask('pause')
            step = service('step', Step)
            before = step([], 1).states[0]
            self.assertGreater(len(self.ask('settle', success=False)), 20)
            after = step([], 1).states[0]
            self.assertAlmostEqual(after.velocity[0] - before.velocity[0], 0.005 / ROD_INERTIA, delta=1e-12)
            self.assertGreater(after.position[0], before.position[0])

    # ---- The base ----------------------------------------------------------------------------------

    def test_the_wrench_is_what_the_chain_does_to_the_base(self):
        scene = machine({'a': link({'rotor_inertia': 0.5}), 'b': link()}, gravity=[0.0, -9.81],
                        base={'x': {'amplitude': 0.1, 'frequency': 2.0}})
        with Node(scene):
            self.ask('pause')
            wrenches = Listener('/planar_chain/base_wrench', WrenchStamped)
            links = Listener('/planar_chain/link_states', LinkStates)
            self.addCleanup(wrenches.close)
            self.addCleanup(links.close)
            wrenches.wait_for_publisher()
            links.wait_for_publisher()
            self.ask('resume')
            wrenches.wait_for_count(100)
            links.wait_for(lambda message: nanoseconds(message) >= nanoseconds(wrenches.messages[99]))
            self.states.wait_for(lambda message: nanoseconds(message) >= nanoseconds(wrenches.messages[99]))
        efforts = {nanoseconds(state): state.effort for state in self.states.messages}
        motions = {nanoseconds(message): message for message in links.messages}
        for message in wrenches.messages[10:100]:
            self.assertEqual(message.header.frame_id, 'base_link')
            wrench, motion = message.wrench, motions[nanoseconds(message)]
            # Newton: what the base does to the chain moves the chain's mass against gravity.
            for mine, part, weight in ((wrench.force.x, 'x', 0.0), (wrench.force.y, 'y', 4 * 9.81)):
                push = sum(2.0 * getattr(entry.linear, part) for entry in motion.acceleration) + weight
                self.assertAlmostEqual(mine, -push, delta=1e-9)
            turned = 0.5 * motion.acceleration[0].angular.z
            self.assertAlmostEqual(wrench.torque.z, turned - efforts[nanoseconds(message)][0], delta=1e-9)
            self.assertEqual((wrench.force.z, wrench.torque.x, wrench.torque.y), (0, 0, 0))

    # ---- Torques -----------------------------------------------------------------------------------

    def test_torques_beyond_the_limit_are_cut_off_counted_and_named(self):
        scene = machine({'a': link({'effort_limit': 0.5}), 'b': link({'effort_limit': 3.0, 'name': 'elbow'})})
        with Node(scene):
            torques = publisher('/planar_chain/joint_torques', Float64MultiArray)
            torques.publish(data=[0.5, 2.0])
            self.states.wait_for(lambda state: state.effort == (0.5, 2.0))
            status = self.next_status()
            self.assertEqual((status.torques_cut_off, status.joints_cut_off), (0, []))
            torques.publish(data=[0.4, -7.0])
            self.states.wait_for(lambda state: state.effort == (0.4, -3.0))
            status = self.next_status()
            self.assertEqual((status.torques_cut_off, status.joints_cut_off), (1, ['elbow']))
            publisher('/planar_chain/joint_torque', JointTorque).publish(joint='a_joint', torque=0.2, duration=0.1)
            status = self.next_status(lambda status: status.torques_cut_off == 2)
            self.assertEqual(status.joints_cut_off, ['a_joint', 'elbow'])
            self.ask('reset')
            status = self.next_status()
            self.assertEqual((status.torques_cut_off, status.joints_cut_off), (0, []))

    def test_a_torque_in_a_driven_joint_is_refused(self):
        with Node(machine({'a': link(), 'b': link({'drive': {'amplitude': 0.2, 'frequency': 1.0}})})):
            torques = publisher('/planar_chain/joint_torques', Float64MultiArray)
            torques.publish(data=[0.3, 1.5])
            status = self.next_status(lambda status: status.rejected_commands == 1)
            self.assertIn('joint_torques/data[1]: expected 0 N m in a driven joint, got 1.5', status.last_rejection)
            publisher('/planar_chain/joint_torque', JointTorque).publish(joint='b_joint', torque=1.0)
            status = self.next_status(lambda status: status.rejected_commands == 2)
            self.assertIn('joint_torque/joint: expected a joint that is not driven, got "b_joint"',
                          status.last_rejection)
            self.assertEqual({state.effort[0] for state in self.states.messages}, {0.0})
            torques.publish(data=[0.3, 0.0])
            self.states.wait_for(lambda state: state.effort[0] == 0.3)


if __name__ == '__main__':
    rospy.init_node('ros_machines', anonymous=True)
    rostest.rosrun('planar_chain', 'ros_machines', Machines)
