#!/usr/bin/python3
"""Commands: what the real rostopic publishes acts as M q̈ = f says, exactly as long as it should; what is
wrong with a command changes nothing and is counted."""

import re
import threading

import rospy
import rostest
from geometry_msgs.msg import Point, Vector3
from planar_chain.msg import CommandTaken, JointTorque, LinkForce
from planar_chain.srv import SetState, Step
from rosgraph_msgs.msg import Log
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint, MultiDOFJointTrajectory, MultiDOFJointTrajectoryPoint

from ros_node import Listener, Node, ROD_INERTIA, Running, Watching, nanoseconds, publisher, rod, service

NAN = float('nan')
NOW = rospy.Time()


class Commands(Watching):
    def seconds_between(self, i, j):
        return (nanoseconds(self.states.messages[j]) - nanoseconds(self.states.messages[i])) * 1e-9

    def assert_constant_torque(self, first, last, torque):
        """Asserts that from state `first` to state `last` the rod gains the speed that the torque gives it."""
        speed = self.states.messages[first].velocity[0]
        for i in range(first, last + 1):
            expected = speed + torque / ROD_INERTIA * self.seconds_between(first, i)
            # Stamps are whole ns.
            self.assertAlmostEqual(self.states.messages[i].velocity[0], expected, delta=2e-9)

    def test_commands_during_a_long_step_all_wait(self):
        many = 20500  # roscpp would keep 20000, and drop others without a word
        scene = rod(integrator={'method': 'rk4', 'step': 4e-6})  # some milliseconds a tick
        scene['links']['rod'].update(repeat=100)
        taken = Listener('/planar_chain/commands_taken', CommandTaken)
        expected = [k * 1e-9 for k in range(many)]
        with Node(scene):
            torques = publisher('/planar_chain/joint_torque', JointTorque, queue=None)
            step, resume = service('step', Step), service('resume', Trigger)
            caller = threading.Thread(target=lambda: step(n=1000))  # ten times as long as publishing them
            caller.start()
            self.statuses.wait_for(lambda status: status.paused and status.tick > 2)
            self.assertIn('a long tick is running', resume().message)
            message = JointTorque(joint='rod_1_joint')
            for message.torque in expected:
                torques.publish(message)
            self.statuses.wait_for_count(len(self.statuses.messages) + 5)
            self.assertLess(self.statuses.messages[-1].tick, 1000)
            self.assertEqual(len(taken.messages), 1)
            caller.join()
            taken.wait_for_count(1 + many)
        taken.close()
        self.assertEqual([command.joint_torque[0].torque for command in taken.messages[1:]], expected)
        self.assertEqual(self.statuses.messages[-1].rejected_commands, 0)

    def test_held_torque_from_rostopic_accelerates_as_the_equation_says(self):
        with Node(rod()):
            with Running('rostopic', 'pub', '/planar_chain/joint_torques',
                         'std_msgs/Float64MultiArray', '{data: [0.31]}'):
                first = self.states.wait_for(lambda state: state.effort[0] == 0.31)
            self.states.wait_for_count(first + 100)
            # In force since the state before the first that shows it.
            self.assertEqual(self.states.messages[first - 1].velocity[0], 0.0)
            self.assert_constant_torque(first - 1, first + 99, 0.31)

    def test_a_held_torque_lapses_after_the_command_timeout(self):
        with Node(rod(command_timeout=0.2)):
            with Running('rostopic', 'pub', '/planar_chain/joint_torques',
                         'std_msgs/Float64MultiArray', '{data: [0.31]}'):
                first = self.states.wait_for(lambda state: state.effort[0] == 0.31)
            after = self.states.wait_for(lambda state: state.effort[0] == 0, first)
            self.states.wait_for_count(after + 20)
            self.assert_constant_torque(after, after + 19, 0.0)
            self.assertAlmostEqual(self.states.messages[after].velocity[0],
                                   0.31 / ROD_INERTIA * 0.2, delta=1e-9)
            late = self.statuses.wait_for(lambda status: status.joint_torques_age > 0.2)
            self.assertEqual(self.statuses.messages[late].joint_torque_age, -1)

    def test_a_timed_torque_adds_for_exactly_its_duration(self):
        with Node(rod()):
            held = publisher('/planar_chain/joint_torques', Float64MultiArray)
            timed = publisher('/planar_chain/joint_torque', JointTorque)
            held.publish(data=[0.1])
            first = self.states.wait_for(lambda state: state.effort[0] == 0.1)
            # 0.123 s is no multiple of the tick.
            timed.publish(joint='rod_joint', torque=0.5, duration=0.123)
            both = self.states.wait_for(lambda state: state.effort[0] > 0.5, first)
            after = self.states.wait_for(lambda state: state.effort[0] == 0.1, both)
            gained = self.states.messages[after].velocity[0]
            steady = 0.1 / ROD_INERTIA * self.seconds_between(first - 1, after)
            self.assertAlmostEqual(gained - steady, 0.5 * 0.123 / ROD_INERTIA, delta=3e-9)

    def test_a_pause_moves_the_start_of_a_waiting_command(self):
        taken = Listener('/planar_chain/commands_taken', CommandTaken)
        with Node(rod()):
            timed = publisher('/planar_chain/joint_torque', JointTorque)
            pause, resume = service('pause', Trigger), service('resume', Trigger)
            self.states.wait_for_count(1)
            sent = len(self.states.messages) - 1
            start = self.states.messages[sent].header.stamp + rospy.Duration(0.5)
            timed.publish(joint='rod_joint', torque=0.5, duration=0.1, start=start)
            taken.wait_for_count(1)
            self.assertTrue(pause().success)
            self.statuses.wait_for_count(len(self.statuses.messages) + 10)
            self.assertTrue(resume().success)
            moving = self.states.wait_for(lambda state: state.velocity[0] > 0)
            self.assertEqual(moving - sent, 101, '0.5 s of 200 ticks a second, and one')
            self.assertGreater(self.states.messages[moving].header.stamp, start + rospy.Duration(0.3))
        taken.close()

    def test_a_force_pulse_gives_its_exact_impulse(self):
        with Node(rod()):
            # So weak that the rod turns by 2.5e-5 rad meanwhile: the arm stays 1 m within 1e-9.
            force, before = 0.005 * ROD_INERTIA, self.states
            before.wait_for_count(2)
            with Running('rostopic', 'pub', '/planar_chain/link_force', 'planar_chain/LinkForce',
                         '{link: rod, point: {x: 1.0}, force: {y: %r}, duration: 0.1}' % force):
                first = before.wait_for(lambda state: state.velocity[0] > 0)
            last = self.states.wait_for(
                lambda state: state.header.stamp.to_sec() > 0.15 + first_stamp(before, first))
            speed = self.states.messages[last].velocity[0]
            self.assertAlmostEqual(speed / (force * 1.0 * 0.1 / ROD_INERTIA), 1, delta=1e-9)

    def test_a_moment_turns_the_link_it_acts_on(self):
        with Node(rod()):
            out = publisher('/planar_chain/link_force', LinkForce)
            out.publish(link='rod', moment=31.0, duration=0.1)
            first = self.states.wait_for(lambda state: state.velocity[0] > 0)
            last = self.states.wait_for(
                lambda state: state.header.stamp.to_sec() > 0.15 + first_stamp(self.states, first))
            self.assertAlmostEqual(self.states.messages[last].velocity[0],
                                   31.0 * 0.1 / ROD_INERTIA, delta=1e-9)

    def test_a_wrong_command_changes_nothing_and_is_counted(self):
        with Node(rod()):
            torques = publisher('/planar_chain/joint_torques', Float64MultiArray)
            torque = publisher('/planar_chain/joint_torque', JointTorque)
            force = publisher('/planar_chain/link_force', LinkForce)
            self.states.wait_for_count(1)  # one before the command
            torques.publish(data=[0.31])
            first = self.states.wait_for(lambda state: state.effort[0] == 0.31)

            def wrong_force(**parts):
                return force, LinkForce(**dict({'link': 'rod', 'force': Vector3(0, 1, 0)}, **parts))

            wrong = [
                ((torques, Float64MultiArray(data=[NAN])), 'joint_torques/data[0]', 'nan'),
                ((torques, Float64MultiArray(data=[1, 2])), 'expected 1 torques', 'got 2'),
                ((torques, Float64MultiArray(data=[])), 'expected 1 torques', 'got 0'),
                ((torque, JointTorque('elbow', 1, 0, NOW)), 'expected a joint of the chain (rod_joint)', 'got "elbow"'),
                ((torque, JointTorque('rod_joint', NAN, 0, NOW)), 'joint_torque/torque', 'got nan'),
                ((torque, JointTorque('rod_joint', 1, -1, NOW)), 'joint_torque/duration', 'got -1'),
                ((torque, JointTorque('rod_joint', 1, NAN, NOW)), 'joint_torque/duration', 'got nan'),
                (wrong_force(link='arm'), 'expected a link of the chain (rod)', 'got "arm"'),
                (wrong_force(force=Vector3(0, NAN, 0)), 'link_force/force/y', 'got nan'),
                (wrong_force(force=Vector3(0, 1, 2)), 'link_force/force/z: expected 0', 'got 2'),
                (wrong_force(point=Point(0, 0, NAN)), 'link_force/point/z: expected 0', 'got nan'),
                (wrong_force(moment=float('inf')), 'link_force/moment', 'got inf'),
                (wrong_force(point=Point(1e308, 0, 0)), 'link_force/point/x: expected a number from -1e100 to 1e100, m', 'got 1e+308'),
                (wrong_force(duration=-0.5), 'link_force/duration', 'got -0.5'),
            ]
            for count, ((out, message), expected, found) in enumerate(wrong, 1):
                out.publish(message)
                at = self.statuses.wait_for(lambda status: status.rejected_commands >= count)
                status = self.statuses.messages[at]
                self.assertEqual(status.rejected_commands, count)
                self.assertIn(expected, status.last_rejection)
                self.assertIn(found, status.last_rejection)
            # What was held before is what acts, from the first command to this moment.
            last = len(self.states.messages) - 1
            self.assert_constant_torque(first - 1, last, 0.31)
            self.assertEqual({state.effort[0] for state in self.states.messages[first:last]}, {0.31})

    def test_the_log_counts_every_refusal(self):
        log = Listener('/rosout', Log)
        self.addCleanup(log.close)

        def told():
            said = [line.msg for line in log.messages if line.msg.startswith('command refused: ')]
            self.assertTrue(all('joint_torque/joint: expected a joint of the chain (rod_joint), got "elbow_' in line for line in said))
            return sum(1 + int((re.findall(r' \(and (\d+) more\)$', line) or [0])[0]) for line in said), len(said)

        with Node(rod()):
            torque = publisher('/planar_chain/joint_torque', JointTorque)
            for k in range(7):
                torque.publish(joint='elbow_%d' % k, torque=1)
            log.wait_for(lambda line: told()[0] == 7)
        self.assertLess(told()[1], 7)

    def test_what_cannot_be_read_is_refused_and_counted_too(self):
        class Torn(Float64MultiArray):
            def serialize(self, buff):
                buff.write(bytes(7))

        class TornForce(LinkForce):
            def serialize(self, buff):
                buff.write(b'\xff\xff\xff\xff')

        with Node(rod()):
            torques = publisher('/planar_chain/joint_torques', Float64MultiArray)
            wrong = [
                (publisher('/planar_chain/joint_trajectory', JointTrajectory), JointTrajectory(points=[JointTrajectoryPoint()] * 300000),
                 'joint_trajectory: expected at most 161319 entries in a list, got 300000'),
                (publisher('/planar_chain/base_trajectory', MultiDOFJointTrajectory),
                 MultiDOFJointTrajectory(points=[MultiDOFJointTrajectoryPoint()] * 209716),
                 'base_trajectory: expected at most 209715 entries in a list, got 209716'),
                (torques, Float64MultiArray(data=[0.0] * 2097153),
                 'joint_torques: expected at most 2097152 entries in a list, got 2097153'),
                (torques, Torn(), 'joint_torques: expected a whole message, got Buffer Overrun'),
                (publisher('/planar_chain/link_force', LinkForce), TornForce(),
                 'link_force: expected a whole message, got Buffer Overrun'),
            ]
            for count, (out, message, refusal) in enumerate(wrong, 1):
                out.publish(message)
                at = self.statuses.wait_for(lambda status: status.rejected_commands >= count)
                self.assertEqual(self.statuses.messages[at].rejected_commands, count)
                self.assertEqual(self.statuses.messages[at].last_rejection[:len(refusal)], refusal)
            answer = service('set_state', SetState)(q=[0.0] * 2097153, qd=[0.0])
            self.assertFalse(answer.success)
            self.assertEqual(answer.message, 'set_state: expected at most 2097152 entries in a list, got 2097153')

    def test_two_hundred_commands_in_a_tick_all_act_and_end_to_rounding(self):
        taken = Listener('/planar_chain/commands_taken', CommandTaken)
        self.addCleanup(taken.close)
        with Node(rod(publish={'rate': 100.0})):
            torque = publisher('/planar_chain/joint_torque', JointTorque)
            force = publisher('/planar_chain/link_force', LinkForce)
            taken.wait_for_publisher()
            self.assertTrue(service('pause', Trigger)().success)
            step = service('step', Step)
            impulse = 0.0
            for tick in range(1, 6):
                for i in range(100):
                    torque.publish(joint='rod_joint', torque=0.01 * i, duration=0.0373)
                    force.publish(link='rod', moment=-0.02 * i, duration=0.0373)
                taken.wait_for_count(201 * tick - 1)  # ~step is one, too
                step(n=1)
                impulse -= 0.01 * sum(range(100)) * 0.0373
            # The first push has ended in the fourth tick after it, the last one does so here.
            state = step(n=4).states[-1]
        first = taken.messages[0].tick
        self.assertEqual([entry.tick - first for entry in taken.messages[:1005]], [k for k in range(5) for _ in range(201)])
        self.assertEqual(state.effort[0], 0.0)
        self.assertAlmostEqual(state.velocity[0] * ROD_INERTIA, impulse, delta=1e-12)

    def test_more_timed_commands_than_there_is_room_for_are_refused(self):
        with Node(rod()):
            out = publisher('/planar_chain/joint_torque', JointTorque)
            for _ in range(1024):
                out.publish(joint='rod_joint', torque=0.001, duration=1000)
            full = self.states.wait_for(lambda state: abs(state.effort[0] - 1.024) < 1e-9)
            out.publish(joint='rod_joint', torque=0.001, duration=1000)
            at = self.statuses.wait_for(lambda status: status.rejected_commands == 1)
            self.assertIn('at most 1024', self.statuses.messages[at].last_rejection)
            self.states.wait_for_count(full + 100)
            self.assertAlmostEqual(self.states.messages[-1].effort[0], 1.024, delta=1e-9)


def first_stamp(states, index):
    return states.messages[index].header.stamp.to_sec()


if __name__ == '__main__':
    rospy.init_node('ros_commands', anonymous=True)
    rostest.rosrun('planar_chain', 'ros_commands', Commands)
