#!/usr/bin/python3
"""Time: by the wall, by a /clock of the node's own at any speed, by somebody else's /clock that jumps and stops.
The motion is the same to the bit in all of them; stamps follow the clock, and never are 0."""

import contextlib
import re
import struct
import tempfile
import time
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from planar_chain.msg import JointTorque, LinkStates, SimStatus
from planar_chain.srv import Step
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

from ros_node import LIMIT, Listener, Node, ROD_INERTIA, nanoseconds, publisher, rod, service, spinning

TICK = 5000000  # ns, at 200 Hz
# A tip that rings at 2 kHz: some 200 steps a tick, each chosen anew, which takes about a millisecond. So those who
# listen can keep up where it goes as fast as it can.
SWINGING = rod(chain=['rod', 'tip'], gravity=[0.0, -9.81],
               loads={'shake': {'joint': 'rod_joint', 'torque': 2.0, 'frequency': 3.0, 'start': 0.0321}},
               links=dict(rod()['links'], tip={'mass': 0.1, 'inertia': 0.01, 'com': [0.1, 0.0], 'pin': [0.2, 0.0],
                                               'joint': {'stiffness': 1e6}, 'initial': {'velocity': 1.0}}))


def of_time(ns):
    return rospy.Time(ns // 10 ** 9, ns % 10 ** 9)


# Where the stamp begins, in bytes of a message
STAMPED = {'/joint_states': 4, '/planar_chain/link_states': 4, '/tf': 8}


def stamp_in(message, begin):
    """ns; message: its first bytes, in hexadecimal"""
    seconds, nanoseconds_more = struct.unpack_from('<II', bytes.fromhex(message), begin)
    return seconds * 10 ** 9 + nanoseconds_more


def says_several(diagnostics):
    return '/clock has several publishers' in diagnostics.status[0].message


@contextlib.contextmanager
def sim_time():
    rospy.set_param('/use_sim_time', True)
    try:
        yield
    finally:
        rospy.delete_param('/use_sim_time')


class Conductor:
    """Publishes /clock for a node that follows it."""

    def __init__(self):
        self._out = publisher('/clock', Clock)
        self.now = 0

    def set(self, ns):
        self.now = ns
        self._out.publish(of_time(ns))


class Time(unittest.TestCase):
    def setUp(self):
        self.states = self.listen('/joint_states', JointState)
        self.statuses = self.listen('/planar_chain/status', SimStatus)

    def listen(self, topic, message_type):
        listener = Listener(topic, message_type)
        self.addCleanup(listener.close)
        return listener

    def conductor(self):
        # The node stands before its clock begins, and its first states are heard.
        rospy.wait_for_service('/planar_chain/step', LIMIT)
        self.states.wait_for_publisher()
        return Conductor()

    def stamps(self, first=0):
        return list(map(nanoseconds, self.states.messages[first:]))

    def wait_for_stamp(self, ns, after=0):
        return self.states.wait_for(lambda state: nanoseconds(state) == ns, after)

    def assert_even(self, first, last):
        """These states are a tick apart: none is missing."""
        stamps = self.stamps()[first:last]
        self.assertEqual({later - sooner for sooner, later in zip(stamps, stamps[1:])}, {TICK})

    # ---- The motion ----------------------------------------------------------------------------

    def motion(self, go_on):
        """200 states from a reset on, with a push at a time between two ticks."""
        seen = len(self.states.messages)
        torque = publisher('/planar_chain/joint_torque', JointTorque)
        step = service('step', Step)
        self.assertTrue(service('pause', Trigger)().success)
        self.assertTrue(service('reset', Trigger)().success)
        first = step(n=1).states[0]
        torque.publish(joint='rod_joint', torque=5.0, duration=0.1357,
                       start=first.header.stamp + rospy.Duration(0, 123456789))
        self.statuses.wait_for(lambda status: status.paused and status.joint_torque_age >= 0,
                               len(self.statuses.messages))
        begun = self.wait_for_stamp(nanoseconds(first), seen)
        self.assertTrue(service('resume', Trigger)().success)
        go_on(begun)
        self.states.wait_for_count(begun + 200)
        states = self.states.messages[begun:begun + 200]
        self.assert_even(begun + 1, begun + 200)
        self.assertGreater(max(state.effort[0] for state in states), 4)
        return [(state.position, state.velocity, state.effort) for state in states]

    def test_the_motion_is_the_same_by_every_clock(self):
        def by_itself(_):
            pass

        with Node(SWINGING):
            by_wall = self.motion(by_itself)
        for factor in (0, 0.7, 20.0):
            with Node(dict(SWINGING, real_time_factor=factor)):
                self.assertEqual(self.motion(by_itself), by_wall, factor)

        with sim_time(), Node(SWINGING):
            conductor = self.conductor()
            conductor.set(10 ** 9)
            self.wait_for_stamp(10 ** 9)

            def conducted(begun):
                # No multiple of the tick; some ticks fall between two, some steps bring several.
                while len(self.states.messages) < begun + 200:
                    count = len(self.states.messages)
                    conductor.set(conductor.now + 13700000)
                    self.states.wait_for_count(count + 1)
            self.assertEqual(self.motion(conducted), by_wall)

    # ---- The wall clock ------------------------------------------------------------------------

    def test_the_wall_clock_that_is_set_is_followed(self):
        diagnostics = self.listen('/diagnostics', DiagnosticArray)
        with tempfile.NamedTemporaryFile() as shift:
            def set_clock(seconds):
                shift.seek(0)
                shift.write(struct.pack('=q', seconds))
                shift.flush()

            def restarts_at(seconds, after):
                """The index of the first state that is stamped with the time that was set."""
                return self.states.wait_for(
                    lambda state: abs(state.header.stamp.to_sec() - time.time() - seconds) < 5, after)

            set_clock(0)
            preload = ('env', 'LD_PRELOAD=libplanar_chain_shifted_clock.so', 'CLOCK_SHIFT=' + shift.name)
            with Node(rod(links=spinning()), prefix=preload) as node:
                self.states.wait_for_count(20)
                set_clock(60)
                forwards = restarts_at(60, 20)
                told = self.statuses.wait_for(lambda status: status.clock_jumps == 1)
                self.assertLess(abs(nanoseconds(self.statuses.messages[told]) * 1e-9 - time.time() - 60), 5)
                self.assertLess(self.statuses.messages[told].lag, 1)
                diagnostics.wait_for(lambda message: 'the wall clock jumped' in message.status[0].message)
                self.states.wait_for_count(forwards + 100)
                set_clock(-3600)
                backwards = restarts_at(-3600, forwards)
                self.statuses.wait_for(lambda status: status.clock_jumps == 2)
                self.states.wait_for_count(backwards + 100)
                # While paused
                self.assertTrue(service('pause', Trigger)().success)
                self.statuses.wait_for(lambda status: status.paused)
                set_clock(-7200)
                self.assertTrue(service('resume', Trigger)().success)
                paused = restarts_at(-7200, backwards)
                self.states.wait_for_count(paused + 100)
            log = node.wait()[1]
        self.assertEqual(len(re.findall(r'the wall clock jumped by \+(59|60)\.', log)), 1, log)
        # Even, but for the jumps; and the simulation continued from its state.
        jumps = [k for k, (sooner, later) in enumerate(zip(self.stamps(), self.stamps()[1:]), 1)
                 if later - sooner != TICK]
        self.assertEqual(jumps, [forwards, backwards, paused])
        for k, state in enumerate(self.states.messages):
            self.assertAlmostEqual(state.position[0] - self.states.messages[0].position[0], k * 0.005, delta=1e-12)

    # ---- A clock of its own --------------------------------------------------------------------

    def check_own_clock(self, factor):
        clocks = self.listen('/clock', Clock)
        fixed = self.listen('/tf_static', TFMessage)
        with Node(dict(rod(links=spinning()), real_time_factor=factor)):
            self.states.wait_for_count(20)
            # Latched, with the first of all stamps: time 0 has none.
            fixed.wait_for_count(1)
            self.assertEqual(nanoseconds(fixed.messages[0].transforms[0]), TICK)
            self.assertTrue(service('pause', Trigger)().success)
            last = service('step', Step)(n=2).states[-1]
            self.wait_for_stamp(nanoseconds(last))
            # The clock lives on, and stands.
            clocks.wait_for(lambda clock: clock.clock == last.header.stamp)
            clocks.wait_for_count(len(clocks.messages) + 5)
            self.assertEqual(clocks.messages[-1].clock, last.header.stamp)
            still = self.statuses.wait_for(lambda status: status.header.stamp == last.header.stamp)
            self.assertTrue(self.statuses.messages[still].paused)
        told = [clock.clock.to_nsec() for clock in clocks.messages]
        self.assertEqual(told, sorted(told))
        self.assertGreater(told[0], 0)
        self.assertEqual({stamp % TICK for stamp in self.stamps()}, {0})
        # Stamps are the time that was simulated, and no state is ahead of the clock.
        for state in self.states.messages:
            self.assertAlmostEqual(state.position[0], nanoseconds(state) * 1e-9, delta=1e-9)
        heard = [stamp for stamp in self.stamps() if stamp > told[0]]
        self.assertGreater(len(heard), 1)
        self.assertLessEqual(set(heard[-3:]), set(told))

    def test_its_own_clock_at_half_speed(self):
        self.check_own_clock(0.5)

    def test_its_own_clock_as_fast_as_it_goes(self):
        self.check_own_clock(0)
        self.assertEqual(self.statuses.messages[-1].lag, 0)

    def test_speed_is_what_was_asked_for(self):
        for factor in (0.5, 8.0):
            first = len(self.statuses.messages)
            with Node(dict(rod(), real_time_factor=factor)):
                late = self.statuses.wait_for(lambda status: status.sim_time > 2 * factor, first)
            self.assertAlmostEqual(self.statuses.messages[late].real_time_factor / factor, 1, delta=0.2)

    def test_its_own_clock_is_published_before_the_messages_of_a_tick(self):
        heard = [self.listen('/clock', Clock), self.listen('/tf', TFMessage),
                 self.listen('/planar_chain/link_states', LinkStates), self.states]
        for factor in (1.0, 0):
            with tempfile.NamedTemporaryFile() as lines:
                preload = ('env', 'LD_PRELOAD=libplanar_chain_published.so', 'PUBLISHED=' + lines.name)
                with Node(dict(rod(), real_time_factor=factor), prefix=preload):
                    # All are connected, the clock first.
                    for listener in heard:
                        listener.wait_for_count(len(listener.messages) + 50)
                told, seen = None, set()
                for topic, start in (line.decode().split() for line in lines):
                    if topic == '/clock':
                        told = stamp_in(start, 0)
                    elif told is not None and topic in STAMPED:
                        self.assertEqual(stamp_in(start, STAMPED[topic]), told, topic)
                        seen.add(topic)
                self.assertEqual(seen, set(STAMPED))

    def test_two_owners_are_told(self):
        diagnostics = self.listen('/diagnostics', DiagnosticArray)
        with sim_time(), Node(dict(rod(), real_time_factor=1.0)):
            alone = diagnostics.wait_for(lambda message: not says_several(message))
            rival = rospy.Publisher('/clock', Clock, queue_size=1)
            told = diagnostics.wait_for(says_several, alone)
            self.assertEqual(diagnostics.messages[told].status[0].level, DiagnosticStatus.WARN)
            rival.unregister()
            diagnostics.wait_for(lambda message: not says_several(message), told)

    # ---- Somebody else's clock -----------------------------------------------------------------

    def test_a_clock_that_has_not_begun_is_waited_for(self):
        with sim_time(), Node(rod(links=spinning())) as node:
            # It says what it waits for, by wall time.
            self.statuses.wait_for_count(50)
            for status in self.statuses.messages:
                self.assertEqual(status.standstill, '/clock has not begun')
                self.assertLess(abs(nanoseconds(status) * 1e-9 - time.time()), LIMIT)
            conductor = self.conductor()
            conductor.set(0)
            refused = service('step', Step)(n=1)
            self.assertFalse(refused.success)
            self.assertEqual(refused.message, '/clock has not begun')
            self.assertEqual(self.states.messages, [])
            conductor.set(3 * 10 ** 9 + 1)
            self.states.wait_for_count(1)
            self.statuses.wait_for(lambda status: nanoseconds(status) == 3 * 10 ** 9 + 1)
            # Back to 0, as a simulator that is reset while it is paused
            begun = len(self.statuses.messages)
            conductor.set(0)
            self.statuses.wait_for(lambda status: status.standstill == '/clock has not begun', begun)
            conductor.set(4 * 10 ** 9)
            self.wait_for_stamp(4 * 10 ** 9)
        self.assertEqual(self.stamps()[0], 3 * 10 ** 9 + 1)
        self.assertEqual(self.states.messages[0].position[0], 0.0)
        self.assertEqual(node.wait()[1].count('no time has come on /clock'), 1)

    def test_a_clock_that_jumps(self):
        with sim_time(), Node(rod(links=spinning())):
            conductor = self.conductor()
            conductor.set(10 * 10 ** 9)
            self.wait_for_stamp(10 * 10 ** 9)
            # By less than it has patience for: made up for.
            conductor.set(10 * 10 ** 9 + 100 * TICK + 7)
            self.wait_for_stamp(10 * 10 ** 9 + 100 * TICK)
            self.assertEqual(self.stamps(), [10 * 10 ** 9 + k * TICK for k in range(101)])
            # By more: given up, stamped anew.
            conductor.set(50 * 10 ** 9 + 3)
            self.wait_for_stamp(50 * 10 ** 9 + 3)
            conductor.set(50 * 10 ** 9 + 3 + TICK)
            self.wait_for_stamp(50 * 10 ** 9 + 3 + TICK)
            # Back, as a bag that begins again.
            conductor.set(2 * 10 ** 9)
            self.wait_for_stamp(2 * 10 ** 9)
            conductor.set(2 * 10 ** 9 + 2 * TICK - 1)
            self.wait_for_stamp(2 * 10 ** 9 + TICK)
            conductor.set(2 * 10 ** 9 + 2 * TICK)
            self.wait_for_stamp(2 * 10 ** 9 + 2 * TICK)
        self.assertEqual(self.stamps(101), [50 * 10 ** 9 + 3, 50 * 10 ** 9 + 3 + TICK,
                                            2 * 10 ** 9, 2 * 10 ** 9 + TICK, 2 * 10 ** 9 + 2 * TICK])
        # The simulation went on from its state, a tick a message.
        for k, state in enumerate(self.states.messages):
            self.assertAlmostEqual(state.position[0], k * 0.005, delta=1e-12)

    def test_no_measurement_is_lost_where_a_clock_jumps_to_its_beginning(self):
        measured = self.listen('/planar_chain/arm', JointState)
        with sim_time(), Node(rod(links=spinning(), sensors={'arm': {'joints': 'all', 'rate': 2000.0}})):
            conductor = self.conductor()
            for ns in 10 ** 10, 10 ** 6:
                conductor.set(ns)
                self.wait_for_stamp(ns)
            measured.wait_for_count(11)
        # On the new clock, nine would have been before its beginning: they have the time of the old one.
        self.assertEqual([nanoseconds(one) for one in measured.messages], [10 ** 10 + k * 500000 for k in range(9)] + [500000, 10 ** 6])
        for k, one in enumerate(measured.messages):
            self.assertAlmostEqual(one.position[0], k * 0.0005, delta=1e-12)

    def test_a_clock_near_the_end_of_time_is_no_end_of_the_node(self):
        with sim_time(), Node(rod(links=spinning())):
            conductor = self.conductor()
            for ns in (2 ** 32 - 1) * 10 ** 9, 2 ** 32 * 10 ** 9 - 1:
                conductor.set(ns)
                self.statuses.wait_for(lambda status: status.standstill == '/clock is within a day of 2^32 s, where the stamps of ROS end')
                time.sleep(1.5)  # diagnostics are sent each second
                self.assertTrue(service('step', Step)(n=1).success)
            self.assertTrue(service('resume', Trigger)().success)
            conductor.set(10 ** 9)
            self.wait_for_stamp(10 ** 9)

    def test_a_clock_that_stops(self):
        with sim_time(), Node(rod(links=spinning())):
            conductor = self.conductor()
            conductor.set(10 ** 9)
            self.wait_for_stamp(10 ** 9)
            conductor.set(10 ** 9 + TICK)
            self.wait_for_stamp(10 ** 9 + TICK)
            still = self.statuses.wait_for(lambda status: status.standstill and nanoseconds(status) == 10 ** 9 + TICK)
            self.assertEqual(self.statuses.messages[still].standstill, '/clock stands still')
            conductor.set(conductor.now)
            self.statuses.wait_for_count(still + 10)
            self.assertEqual(len(self.states.messages), 2)
            conductor.set(10 ** 9 + 2 * TICK)
            self.wait_for_stamp(10 ** 9 + 2 * TICK)
            self.statuses.wait_for(lambda status: not status.standstill, still + 10)

    # ---- Commands at a time --------------------------------------------------------------------

    def test_a_command_acts_from_its_start_on_to_the_bit(self):
        with Node(rod()):
            torque = publisher('/planar_chain/joint_torque', JointTorque)
            self.assertTrue(service('pause', Trigger)().success)
            step = service('step', Step)
            now = step(n=1).states[0].header.stamp

            # Two sources: a push of 37.3 ms that begins between two ticks, and one of which 4 ms are left.
            before = len(self.statuses.messages)
            torque.publish(joint='rod_joint', torque=1.0, duration=0.0373, start=now + rospy.Duration(0, 11100000))
            torque.publish(joint='rod_joint', torque=-2.0, duration=0.01, start=now - rospy.Duration(0, 6000000))
            # Over; too far ahead; and something else to say that all were heard.
            torque.publish(joint='rod_joint', torque=5.0, duration=0.01, start=now - rospy.Duration(0, 10000000))
            torque.publish(joint='rod_joint', torque=5.0, duration=0.01, start=now + rospy.Duration(90000))
            torque.publish(joint='rod_joint', torque=5.0, duration=0.01, start=rospy.Time(4294967295, 0))
            heard = self.statuses.wait_for(lambda status: status.rejected_commands == 3, before)
            self.assertIn('joint_torque/start: expected 0 for now, or the node\'s time, at most a day ahead',
                          self.statuses.messages[heard].last_rejection)
            speeds = [0.0] + [state.velocity[0] * ROD_INERTIA for state in step(n=20).states]
        # After k ticks: what both pushes have given by then.
        for k, speed in enumerate(speeds):
            t = k * 0.005
            expected = min(max(t - 0.0111, 0), 0.0373) - 2 * min(t, 0.004)
            self.assertAlmostEqual(speed, expected, delta=1e-12)


if __name__ == '__main__':
    rospy.init_node('ros_time', anonymous=True)
    rostest.rosrun('planar_chain', 'ros_time', Time)
