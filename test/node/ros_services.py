#!/usr/bin/python3
"""Services: pause, resume, reset, set_state, clear_commands and step say whether and why; the way a reset leads back
to is the first one, bit for bit; stamps never go back."""

import math

import rospy
import rostest
from planar_chain.msg import JointTorque
from planar_chain.srv import Equations, SetState, Step
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

from ros_node import Listener, Node, ROD_INERTIA, Watching, nanoseconds, publisher, rod, service, spinning, upload

NAN = float('nan')
PENDULUM = rod(gravity=[0.0, -9.81], loads={
    'push': {'joint': 'rod_joint', 'torque': 3.0, 'start': 0.0123, 'stop': 0.1456},
    'shake': {'joint': 'rod_joint', 'torque': 2.0, 'frequency': 3.0}})


def motion(states):
    return [(state.position, state.velocity, state.effort) for state in states]


class Services(Watching):
    def setUp(self):
        super().setUp()
        self.transforms = Listener('/tf', TFMessage)

    def tearDown(self):
        super().tearDown()
        self.transforms.close()
        stamps = list(map(nanoseconds, self.states.messages))
        self.assertTrue(all(later > sooner for sooner, later in zip(stamps, stamps[1:])))
        times = [status.sim_time for status in self.statuses.messages]
        self.assertEqual(times, sorted(times))

    def test_a_pause_is_not_in_the_real_time_factor(self):
        with Node(PENDULUM):
            self.statuses.wait_for(lambda status: status.real_time_factor > 0.9)
            self.ask('pause')
            self.statuses.wait_for_count(len(self.statuses.messages) + 40)  # 4 s
            self.ask('resume')
            seen = len(self.statuses.messages)
            self.statuses.wait_for_count(seen + 5)
            self.assertGreater(min(status.real_time_factor for status in self.statuses.messages[seen:]), 0.75)

    def test_the_log_says_when_the_motion_ends_and_how_to_repeat_it(self):
        scene = rod(base={'x': {'times': [0.0, 0.1], 'values': [0.0, 0.2]}})
        with Node(scene) as node:
            self.states.wait_for_count(60)
            self.ask('reset')
            self.states.wait_for_count(len(self.states.messages) + 60)
        said = node.wait()[1]
        self.assertEqual(said.count("the scene's motion has ended at 0.1 s; rosservice call /planar_chain/reset"), 2, said)

    def ask(self, name, success=True):
        answer = service(name, Trigger)()
        self.assertEqual(answer.success, success, answer.message)
        self.assertNotEqual(answer.message, '')
        return answer.message

    def next_status(self, holds=lambda status: True):
        return self.statuses.messages[self.statuses.wait_for(holds, len(self.statuses.messages) + 1)]

    def last_turn(self, holds, after=0):
        """A status of a rod that turns at 1 rad/s and stands still now; returns when its last state is here too."""
        still = self.next_status(holds)
        self.states.wait_for(lambda state: abs(state.position[0] - still.scene_time) < 1e-9, after)
        return still

    def test_paused_nothing_moves_and_nothing_is_stamped(self):
        with Node(rod(links=spinning(), publish={'rate': 200.0, 'tf_rate': 200.0, 'status_rate': 20.0})):
            self.states.wait_for_count(10)
            self.ask('pause')
            still = self.last_turn(lambda status: status.paused)
            self.assertEqual(still.standstill, 'paused')
            states = len(self.states.messages)
            last = self.states.messages[-1].header.stamp
            transforms = 1 + self.transforms.wait_for(
                lambda message: any(frame.header.stamp == last for frame in message.transforms))
            self.statuses.wait_for_count(len(self.statuses.messages) + 10)
            self.assertEqual((len(self.states.messages), len(self.transforms.messages)), (states, transforms))
            self.assertEqual(self.statuses.messages[-1].sim_time, still.sim_time)
            self.assertEqual(self.statuses.messages[-1].lag, 0)
            paused = self.states.messages[-1]
            self.assertIn('already', self.ask('pause'))

            self.ask('resume')
            self.states.wait_for_count(states + 50)
            # By one tick, and stamped with the time of day.
            after = self.states.messages[states]
            self.assertAlmostEqual(after.position[0], paused.position[0] + 0.005, delta=1e-12)
            self.assertGreater(nanoseconds(after) - nanoseconds(paused), 0.3e9)
            self.assertFalse(self.next_status().paused)
            self.assertIn('already', self.ask('resume'))

    def test_reset_leads_to_the_first_motion_bit_for_bit(self):
        # The first node is stepped from a reset, the second runs freely before and after its own.
        with Node(PENDULUM):
            self.ask('pause')
            self.ask('reset')
            first = motion(service('step', Step)(n=200).states)
        self.tearDown()
        self.setUp()
        with Node(PENDULUM):
            torque = publisher('/planar_chain/joint_torque', JointTorque)
            torque.publish(joint='rod_joint', torque=7.0, duration=1000.0)
            self.states.wait_for(lambda state: state.effort[0] > 6)
            begun = len(self.states.messages)
            self.ask('reset')
            zero = self.states.wait_for(lambda state: state.position == (0.0,), begun)
            self.states.wait_for_count(zero + 201)
            again = motion(self.states.messages[zero:zero + 201])
            self.assertEqual(again[1:], first)
            status = self.next_status()
            self.assertLess(status.scene_time, status.sim_time)
            self.assertEqual(status.joint_torque_age, -1)

    def test_a_reset_while_paused_is_shown_once(self):
        with Node(rod(links=spinning())):  # TF at every fourth tick
            self.states.wait_for_count(10)
            self.ask('pause')
            still = self.last_turn(lambda status: status.paused)
            self.statuses.wait_for_count(len(self.statuses.messages) + 10)  # and what is under way has come
            for _ in range(3):
                states, transforms = len(self.states.messages), len(self.transforms.messages)
                self.ask('reset')
                self.states.wait_for_count(states + 1)
                self.transforms.wait_for_count(transforms + 1)
                shown = self.states.messages[states]
                self.assertEqual((shown.position, shown.velocity), ((0.0,), (1.0,)))
                self.assertGreaterEqual(nanoseconds(shown), nanoseconds(still))  # the time of day, as after a resume
                self.statuses.wait_for_count(len(self.statuses.messages) + 10)
                self.assertEqual(len(self.states.messages), states + 1)
                self.assertEqual(len(self.transforms.messages), transforms + 1)
            # A step continues from there.
            self.assertAlmostEqual(service('step', Step)(n=1).states[0].position[0], 0.005, delta=1e-12)

    def test_reset_reads_changed_parameters_or_refuses_all(self):
        with Node(rod(links=spinning())):
            self.ask('pause')
            rospy.set_param('/planar_chain/links/rod/mass', -1.0)
            rospy.set_param('/planar_chain/links/rod/inertia', 'heavy')
            rospy.set_param('/planar_chain/publish/rate', 50.0)
            message = self.ask('reset', success=False)
            for fault in ('links/rod/mass: expected', 'links/rod/inertia: expected', 'publish: expected'):
                self.assertIn(fault, message)
            step = service('step', Step)
            self.assertAlmostEqual(step(n=1).states[0].velocity[0], 1.0, delta=1e-12)

            upload(dict(rod(), chain=['rod', 'tip'], links={
                'rod': dict(spinning()['rod'], initial={'angle': 0.5}),
                'tip': {'mass': 0.1, 'inertia': 0.01, 'com': [0.1, 0.0], 'pin': [0.2, 0.0],
                        'joint': {'name': 'wrist'}, 'initial': {'velocity': 2.0}}}), '/planar_chain')
            seen = len(self.states.messages)
            self.assertIn('of the scene in the changed parameters', self.ask('reset'))
            self.states.wait_for_count(seen + 1)
            new = self.states.messages[seen]
            self.assertEqual((new.name, new.position, new.velocity), (['rod_joint', 'wrist'], (0.5, 0.0), (0.0, 2.0)))
            self.assertEqual(len(step(torques=[0.0, 0.1], n=3).states[-1].position), 2)
            self.assertTrue(service('set_state', SetState)([0.1, 0.2], [0.0, 0.0]).success)
            self.assertEqual(len(service('equations', Equations)([], []).q), 2)
            self.assertIn('<link name="tip">', rospy.get_param('/robot_description'))
            torque = publisher('/planar_chain/joint_torque', JointTorque)
            torque.publish(joint='wrist', torque=0.3, duration=0.0)
            self.next_status(lambda status: status.joint_torque_age >= 0)
            # Unchanged since: the same scene again.
            self.assertNotIn('changed', self.ask('reset'))
            self.assertEqual(len(step(n=1).states[0].position), 2)
            rospy.delete_param('/planar_chain')
            self.assertIn("expected a scene in the node's parameters", self.ask('reset', success=False))
            self.assertEqual(len(step(n=1).states[0].position), 2)

    def test_the_method_is_named_before_its_first_step(self):
        link = {'mass': 1.0, 'inertia': 0.1, 'com': [0.5, 0.0], 'pin': [1.0, 0.0]}
        scene = dict(rod(gravity=[0.0, -9.81]), chain=['upper', 'lower'], links={'upper': link, 'lower': link})
        with Node(scene):
            self.ask('pause')
            self.ask('reset')
            first = self.next_status(lambda status: status.steps == 0)
            service('step', Step)(n=1)
            running = self.next_status(lambda status: 0 < status.steps < 25)  # before auto's first trial
            self.assertEqual(first.method, running.method)
            self.assertNotEqual(first.method, 'rodas5p')

    def test_reset_leads_back_from_a_fault(self):
        scene = rod(links=spinning(), loads={'blast': {'joint': 'rod_joint', 'torque': 1e200, 'start': 0.3}})
        with Node(scene):
            fault = self.last_turn(lambda status: status.fault)
            self.assertEqual(fault.standstill, 'the integration has failed')
            self.assertIn('the last good state is kept', self.ask('resume', success=False))
            refused = service('step', Step)(n=1)
            self.assertFalse(refused.success)
            self.assertIn('the last good state is kept', refused.message)
            self.assertEqual(refused.states, [])
            seen = len(self.states.messages)
            self.ask('reset')
            self.states.wait_for_count(seen + 20)
            self.last_turn(lambda status: status.fault, seen)
            seen = len(self.states.messages)
            self.assertTrue(service('set_state', SetState)([0.5], [0.0]).success)
            # The blast goes on: it fails again at once, at the state that was set.
            self.next_status(lambda status: status.fault)
            self.assertEqual(len(self.states.messages), seen)
        for state in self.states.messages:
            self.assertTrue(all(map(math.isfinite, state.position + state.velocity + state.effort)))

    def test_set_state_sets_all_or_nothing(self):
        with Node(rod()):
            self.ask('pause')
            set_state = service('set_state', SetState)
            self.assertTrue(set_state([0.25], [2.0]).success)
            step = service('step', Step)
            self.assertAlmostEqual(step(n=1).states[0].position[0], 0.26, delta=1e-12)
            for q, qd, faults in (([], [0.0], ['q: expected 1 angles', 'got 0']),
                                  ([NAN], [1.0, 2.0], ['q[0]: expected a finite number', 'got nan',
                                                       'qd: expected 1 rates', 'got 2']),
                                  ([0.0], [1e200], ['finite energy'])):
                answer = set_state(q, qd)
                self.assertFalse(answer.success)
                for fault in faults:
                    self.assertIn(fault, answer.message)
            self.assertAlmostEqual(step(n=1).states[0].position[0], 0.27, delta=1e-12)

    def test_clear_commands_lets_go_of_all_kinds(self):
        with Node(rod()):
            held = publisher('/planar_chain/joint_torques', Float64MultiArray)
            timed = publisher('/planar_chain/joint_torque', JointTorque)
            held.publish(data=[0.1])
            timed.publish(joint='rod_joint', torque=0.2, duration=1000.0)
            both = self.states.wait_for(lambda state: state.effort[0] > 0.25)
            soon = self.states.messages[both].header.stamp + rospy.Duration(1.0)
            timed.publish(joint='rod_joint', torque=10.0, duration=0, start=soon)
            self.next_status(lambda status: status.joint_torque_age >= 0)
            self.ask('clear_commands')
            free = self.states.wait_for(lambda state: state.effort[0] == 0, both)
            last = self.states.wait_for(lambda state: state.header.stamp > soon + rospy.Duration(0.1))
            self.assertEqual({state.effort[0] for state in self.states.messages[free:last]}, {0.0})

    def test_step_is_exact_atomic_and_pauses(self):
        with Node(rod()):
            self.states.wait_for_count(3)
            step = service('step', Step)
            first = step(torques=[0.31], n=4)
            self.assertEqual(first.motor_torques, (0.31,))
            self.assertTrue(first.success)
            self.assertIn('paused', first.message)
            self.assertEqual(len(first.states), 4)
            rate = 0.31 / ROD_INERTIA * 0.005
            speeds = [state.velocity[0] for state in first.states]
            for k, speed in enumerate(speeds, 1):
                self.assertAlmostEqual(speed, k * rate, delta=1e-12)
            # Held on; then let go.
            self.assertAlmostEqual(step(n=2).states[-1].velocity[0], 6 * rate, delta=1e-12)
            last = step(torques=[0.0], n=3)
            self.assertEqual(last.message, 'done; it is paused')
            self.assertAlmostEqual(last.states[-1].velocity[0], 6 * rate, delta=1e-12)
            # What was answered is what was published.
            seen = self.states.wait_for(lambda state: state.header.stamp == last.states[-1].header.stamp)
            self.assertEqual(motion(self.states.messages[seen - 8:seen + 1]),
                             motion(first.states[:4] + self.states.messages[seen - 4:seen - 2] + last.states))

            for torques, n, faults in (([], 0, ['n: expected from 1 to 10000 ticks, got 0']),
                                       ([], 10001, ['got 10001']),
                                       ([1.0, 2.0], 1, ['torques: expected 1 torques', 'got 2']),
                                       ([NAN], 0, ['torques[0]: expected a finite', 'n: expected'])):
                answer = step(torques=torques, n=n)
                self.assertFalse(answer.success)
                self.assertEqual(answer.states, [])
                for fault in faults:
                    self.assertIn(fault, answer.message)
            self.assertAlmostEqual(step(n=1).states[-1].velocity[0], 6 * rate, delta=1e-12)
            self.assertTrue(self.next_status().paused)
            # Two seconds ahead of the wall clock, and stamps increase all the same: see tearDown.
            ahead = step(n=400).states[-1]
            self.ask('resume')
            self.states.wait_for(lambda state: state.header.stamp > ahead.header.stamp)
            self.states.wait_for_count(len(self.states.messages) + 20)


if __name__ == '__main__':
    rospy.init_node('ros_services', anonymous=True)
    rostest.rosrun('planar_chain', 'ros_services', Services)
