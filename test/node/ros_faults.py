#!/usr/bin/python3
"""What goes wrong: an integration that fails, an end in the middle of a tick, a subscriber that does not read."""

import math
import os
import signal
import struct
import subprocess
import threading
import time
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from planar_chain.msg import LinkForce, LinkStates, SimStatus
from planar_chain.srv import SetState, SetStateRequest, Step
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

from bag_load import cpu_seconds
from ros_node import LIMIT, Listener, Node, nanoseconds, publisher, rod, service


def numbers(message):
    """Every number of a message, those of messages in it included."""
    if isinstance(message, (list, tuple)):
        for part in message:
            yield from numbers(part)
    elif hasattr(message, '__slots__'):
        for name in message.__slots__:
            yield from numbers(getattr(message, name))
    elif isinstance(message, float):
        yield message


def resident_bytes(pid):
    with open('/proc/%d/statm' % pid, encoding='ascii') as sizes:
        return int(sizes.read().split()[1]) * os.sysconf('SC_PAGE_SIZE')


def peak_bytes(pid):
    with open('/proc/%d/status' % pid, encoding='ascii') as lines:
        return next(int(line.split()[1]) * 1024 for line in lines if line.startswith('VmHWM:'))


class LyingTorques(Float64MultiArray):
    """Says that 32 GB of numbers follow, and ends."""

    def serialize(self, buff):
        buff.write(struct.pack('<III', 0, 0, 2**32 - 1))


class LyingState(SetStateRequest):
    def serialize(self, buff):
        buff.write(struct.pack('<I', 2**32 - 1))


class LyingSetState(SetState):
    _request_class = LyingState


WITHOUT_END = rod(integrator={'method': 'rk4', 'step': 1e-9}, publish={'rate': 0.01, 'status_rate': 0.01})


def level(diagnostics):
    return diagnostics.status[0].level


class Faults(unittest.TestCase):
    def listen(self, topic, message_type):
        listener = Listener(topic, message_type)
        self.addCleanup(listener.close)
        return listener

    def test_a_failure_is_named_everywhere_and_reset_leads_back(self):
        topics = [self.listen('/joint_states', JointState), self.listen('/tf', TFMessage),
                  self.listen('/planar_chain/link_states', LinkStates),
                  self.listen('/planar_chain/status', SimStatus)]
        diagnostics = self.listen('/diagnostics', DiagnosticArray)
        ok, error = DiagnosticStatus.OK, DiagnosticStatus.ERROR
        with Node(rod(loads={'blast': {'joint': 'rod_joint', 'torque': 1e200, 'start': 1.3}})):
            well = diagnostics.wait_for(lambda message: level(message) == ok)
            self.assertEqual(diagnostics.messages[well].status[0].name, 'planar_chain: simulation')
            failed = diagnostics.wait_for(lambda message: level(message) == error, well)
            self.assertIn('the last good state is kept', diagnostics.messages[failed].status[0].message)
            status = topics[-1].wait_for(lambda message: message.fault)
            self.assertIn(topics[-1].messages[status].fault, diagnostics.messages[failed].status[0].message)
            publisher('/planar_chain/joint_torques', Float64MultiArray).publish(data=[1.0])
            refused = topics[-1].wait_for(lambda message: message.rejected_commands == 1)
            self.assertIn('call ~reset, ~settle or ~set_state', topics[-1].messages[refused].last_rejection)
            self.assertTrue(service('reset', Trigger)().success)
            diagnostics.wait_for(lambda message: level(message) == ok, failed)
        for topic in topics:
            self.assertGreater(len(topic.messages), 5)
            for message in topic.messages:
                self.assertTrue(all(map(math.isfinite, numbers(message))))

    def call_a_step_that_would_take_for_ever(self, node, ticks=1):
        """@returns the thread that calls, and its answer in a list"""
        step, answers = service('step', Step), []

        def call():
            try:
                answers.append(step(n=ticks))
            except rospy.ServiceException as failure:
                answers.append(failure)
        caller = threading.Thread(target=call)
        caller.start()
        idle = cpu_seconds(node.process.pid)
        while cpu_seconds(node.process.pid) < idle + 0.5 and node.process.poll() is None:
            rospy.rostime.wallsleep(0.05)
        self.assertEqual(answers, [])
        return caller, answers

    def test_an_interrupt_ends_a_step_that_would_take_for_ever(self):
        with Node(WITHOUT_END) as node:
            caller, answers = self.call_a_step_that_would_take_for_ever(node)
            node.process.send_signal(signal.SIGINT)
            status, output = node.wait()
            caller.join(LIMIT)
        self.assertEqual(status, 0, output)
        self.assertFalse(any(getattr(answer, 'success', False) for answer in answers))

    def test_a_step_of_many_short_ticks_is_told_and_interrupted(self):
        statuses = self.listen('/planar_chain/status', SimStatus)
        diagnostics = self.listen('/diagnostics', DiagnosticArray)
        # Some milliseconds a tick, a minute in all.
        scene = rod(integrator={'method': 'rk4', 'step': 2e-5})
        scene['links']['rod'].update(repeat=100)
        with Node(scene) as node:
            caller, answers = self.call_a_step_that_would_take_for_ever(node, 10000)
            diagnostics.wait_for_count(len(diagnostics.messages) + 2)
            first = statuses.messages[-1]
            later = statuses.wait_for(lambda status: status.tick > first.tick + 5, len(statuses.messages) - 1)
            self.assertEqual((answers, statuses.messages[later].paused), ([], True))
            node.process.send_signal(signal.SIGINT)
            asked = time.monotonic()
            status, output = node.wait()
            self.assertLess(time.monotonic() - asked, 2)
            caller.join(LIMIT)
        self.assertEqual(status, 0, output)
        self.assertFalse(any(getattr(answer, 'success', False) for answer in answers))

    def test_a_reset_gives_up_a_step_that_would_take_for_ever(self):
        with Node(WITHOUT_END) as node:
            caller, answers = self.call_a_step_that_would_take_for_ever(node)
            self.assertTrue(service('reset', Trigger)().success)
            caller.join(LIMIT)
            self.assertEqual([(answer.success, answer.message) for answer in answers],
                             [(False, '~reset aborted the tick')])

    def test_a_tick_without_end_is_told_and_given_up_by_reset(self):
        states = self.listen('/joint_states', JointState)
        statuses = self.listen('/planar_chain/status', SimStatus)
        links = dict(rod()['links'], tip={'mass': 0.1, 'inertia': 0.01, 'com': [0.1, 0.0], 'pin': [0.2, 0.0]})
        with Node(rod(chain=['rod', 'tip'], links=links)):
            force = publisher('/planar_chain/link_force', LinkForce)
            torques = publisher('/planar_chain/joint_torques', Float64MultiArray)
            states.wait_for_count(20)
            # It turns some thousand million times a second then.
            force.publish(link='tip', moment=1e12, duration=0.001)
            stuck = statuses.wait_for(lambda status: status.lag > 0.5)
            statuses.wait_for_count(stuck + 20)
            self.assertEqual(statuses.messages[-1].fault, '')
            torques.publish(data=[1.0, 1.0])
            for answer in (service('set_state', SetState)([0, 0], [0, 0]), service('step', Step)(n=1),
                           service('clear_commands', Trigger)()):
                self.assertFalse(answer.success)
                self.assertIn('~reset aborts it', answer.message)
            stuck = len(states.messages)
            self.assertTrue(service('reset', Trigger)().success)
            states.wait_for_count(stuck + 100)
            # What waited was forgotten.
            self.assertEqual({(state.position, state.effort) for state in states.messages[stuck:]},
                             {((0.0, 0.0), (0.0, 0.0))})

    def test_a_list_that_lies_about_its_length_takes_no_memory(self):
        states = self.listen('/joint_states', JointState)
        with Node(rod()) as node:
            states.wait_for_count(10)
            liar = rospy.Publisher('/planar_chain/joint_torques', LyingTorques, queue_size=1)
            honest = publisher('/planar_chain/joint_torques', Float64MultiArray)
            while liar.get_num_connections() == 0:
                rospy.sleep(0.01)
            liar.publish(LyingTorques())
            answer = service('set_state', LyingSetState)(LyingState())
            self.assertFalse(answer.success)
            self.assertIn('entries in a list, got 4294967295', answer.message)
            honest.publish(data=[0.62])
            states.wait_for(lambda state: state.effort[0] == 0.62)
            self.assertLess(peak_bytes(node.process.pid), 300e6)
            liar.unregister()

    def test_a_subscriber_that_does_not_read_costs_no_one_anything(self):
        scene = dict(rod(), real_time_factor=2.0)
        scene['links']['rod'].update(repeat=100)
        states = self.listen('/joint_states', JointState)
        with Node(scene) as node:
            states.wait_for_count(1)
            deaf = subprocess.Popen(['rostopic', 'echo', '/joint_states'], stdout=subprocess.PIPE)
            try:
                deaf.stdout.readline()
                deaf.send_signal(signal.SIGSTOP)
                # What the kernel keeps for it is full by then, and what the node does.
                states.wait_for_count(3000)
                before = resident_bytes(node.process.pid)
                states.wait_for_count(5000)
                after = resident_bytes(node.process.pid)
            finally:
                deaf.kill()
                deaf.communicate()
        # 2000 messages of 4 KB, were they kept.
        self.assertLess(after - before, 2e6)
        stamps = list(map(nanoseconds, states.messages))
        self.assertEqual({later - sooner for sooner, later in zip(stamps, stamps[1:])}, {5000000})


if __name__ == '__main__':
    rospy.init_node('ros_faults', anonymous=True)
    rostest.rosrun('planar_chain', 'ros_faults', Faults)
