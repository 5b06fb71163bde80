#!/usr/bin/python3
"""A script plays the vehicle that carries a chain: ~step with the pose and the twist of the base."""

import math

import rospy
import rostest
from geometry_msgs.msg import Pose2D, Twist, Vector3, WrenchStamped
from planar_chain.msg import LinkStates
from planar_chain.srv import Step
from std_srvs.srv import Trigger

from ros_machines import cubic, link, machine
from ros_node import Listener, Node, Watching, rod, service

X, ANGLE = (0.1, 1.0), (0.3, 0.7)  # amplitude, m, rad; frequency, Hz
HEIGHT = 0.2                       # m


def from_rest(law, t):
    """amplitude (1 - cos 2 pi f t), and its rate"""
    amplitude, pulsation = law[0], 2 * math.pi * law[1]
    return amplitude * (1 - math.cos(pulsation * t)), amplitude * pulsation * math.sin(pulsation * t)


def in_scene(law):
    return {'amplitude': law[0], 'frequency': law[1], 'phase': -math.pi / 2, 'offset': law[0]}


def motion(x, y, angle):
    """The pose and the twist of a request. Each argument is a value and a rate."""
    pose, rates = zip(x, y, angle)
    return {'base_pose': [Pose2D(*pose)], 'base_twist': [Twist(Vector3(*rates[:2], 0), Vector3(0, 0, rates[2]))]}


def vehicle_at(t):
    return motion(from_rest(X, t), (HEIGHT, 0), from_rest(ANGLE, t))


def chain(base):
    return machine({'a': link({'damping': 0.5}), 'b': link()}, gravity=[0.0, -9.81], base=base)


class Vehicle(Watching):
    def paused(self):
        """The service ~step of a node that is paused at its initial state."""
        for name in ('pause', 'reset'):
            self.assertTrue(service(name, Trigger)().success)
        step = service('step', Step)

        def checked(n, **more):
            answer = step(n=n, **more)
            self.assertTrue(answer.success, answer.message)
            return answer
        return checked

    def test_a_vehicle_carries_the_chain_as_a_base_in_the_scene_does(self):
        with Node(chain({'x': in_scene(X), 'y': {'offset': HEIGHT}, 'angle': in_scene(ANGLE)})):
            expected = self.paused()(200)
        wrenches = Listener('/planar_chain/base_wrench', WrenchStamped)
        self.addCleanup(wrenches.close)
        with Node(chain({'y': {'offset': HEIGHT}})):
            wrenches.wait_for_publisher()
            step = self.paused()
            first = step(10)
            service('reset', Trigger)()
            off, answers = {}, []
            for ticks in (1, 2, 4):
                service('reset', Trigger)()
                answers = [step(ticks, **vehicle_at(k * 0.005)) for k in range(ticks, 201, ticks)]
                states = [state for answer in answers for state in answer.states]
                off[ticks] = max(abs(one - other) for a, b in zip(states, expected.states)
                                 for one, other in zip(a.position, b.position))
                if ticks > 1:
                    continue
                # The cubic's acceleration differs from the law's by h² law'''' / 12 at its ends.
                for answer, wrench in zip(answers, expected.base_wrenches):
                    for one, other in ((answer.base_wrenches[0].wrench.force, wrench.wrench.force),
                                       (answer.base_wrenches[0].wrench.torque, wrench.wrench.torque)):
                        for part in 'xyz':
                            self.assertAlmostEqual(getattr(one, part), getattr(other, part), delta=0.01)
            # Hermite's cubics are of fourth order.
            self.assertLess(off[1], 1e-8)
            self.assertGreater(off[4] / off[2], 10)
            # The wrench of the answer is the one that was published.
            sent = {message.header.stamp: message.wrench for message in wrenches.messages}
            last = answers[-1].base_wrenches
            self.assertEqual(len(last), 4)
            wrenches.wait_for(lambda message: message.header.stamp == last[-1].header.stamp)
            sent = {message.header.stamp: message.wrench for message in wrenches.messages}
            for answer in answers:
                for state, message in zip(answer.states, answer.base_wrenches):
                    self.assertEqual(state.header.stamp, message.header.stamp)
                    self.assertEqual(sent[message.header.stamp], message.wrench)
            status = self.statuses.messages[self.statuses.wait_for(
                lambda status: status.tick_stamp == last[-1].header.stamp)]
            self.assertGreater(abs(status.work_supplied), 0.1)
            self.assertLess(abs(status.energy_balance), 1e-6)
            # A reset leads back to the base of the scene.
            service('reset', Trigger)()
            again = step(10)
            self.assertEqual([state.position for state in again.states], [state.position for state in first.states])

    def test_a_call_is_one_cubic_and_then_the_base_moves_on(self):
        links = Listener('/planar_chain/link_states', LinkStates)
        self.addCleanup(links.close)
        with Node(rod(base={'x': {'amplitude': 0.1, 'frequency': 0.5}}, gravity=[0.0, -9.81])):
            links.wait_for_publisher()
            step = self.paused()
            step(60)
            x, v = 0.1 * math.sin(0.3 * math.pi), 0.1 * math.pi * math.cos(0.3 * math.pi)
            # The vehicle turns by 4 rad, and gives its angle within one turn.
            states = step(200, **motion((0.4, 0.2), (-0.3, 0.0), (4 - 2 * math.pi, 5.0))).states + step(100).states
            begin = links.wait_for(lambda message: message.header.stamp == states[0].header.stamp)
            links.wait_for_count(begin + 300)
            for k, (state, moving) in enumerate(zip(states, links.messages[begin:]), 1):
                u = k * 0.005
                place = (cubic(u, x, v, 0.4, 0.2), cubic(u, 0, 0, -0.3, 0), cubic(u, 0, 0, 4, 5)) if u <= 1 else (
                    0.4 + 0.2 * (u - 1), -0.3, 4 + 5 * (u - 1))
                pose = moving.pose[0]
                found = (pose.x - 0.4 * math.cos(pose.theta), pose.y - 0.4 * math.sin(pose.theta),
                         pose.theta - state.position[0])
                for one, other in zip(found, place):
                    self.assertAlmostEqual(one, other, delta=1e-9)
            status = self.statuses.messages[self.statuses.wait_for(
                lambda status: status.tick_stamp == states[-1].header.stamp)]
            self.assertAlmostEqual(status.base_trajectory_age, 1.5, delta=1e-9)
            self.assertLess(abs(status.energy_balance), 1e-6)

    def test_a_wrong_pose_changes_nothing(self):
        still = (0.0, 0.0)
        nan, high = motion((math.nan, 0), still, still), motion(still, still, still)
        high['base_twist'][0].linear.z = 1.0
        wrong = [
            (dict(base_pose=[Pose2D()]), 'base_pose: expected one pose and one twist, or neither, got 1 and 0'),
            (dict(base_twist=[Twist()] * 2), 'base_pose: expected one pose and one twist, or neither, got 0 and 2'),
            (nan, 'base_pose[0]: expected a finite number'),
            (high, 'base_twist[0]: expected 0'),
            (motion((1e308, 0), still, still), 'base_pose: expected values up to 1e9 m or rad'),
            (motion(still, still, (1e300, 0)), 'base_pose: expected values up to 1e9 m or rad'),
            (motion((0.0, 1e14), still, still), 'base_pose: expected values up to 1e9 m or rad'),  # 4e16 m/s²
            (dict(motion((1, 0), still, still), torques=[1.0, 2.0]), 'torques: expected 1 torques'),
        ]
        with Node(rod(base={'x': {'offset': 0.0}})):
            self.paused()
            step = service('step', Step)
            self.assertTrue(service('resume', Trigger)().success)
            for request, fault in wrong:
                answer = step(n=1, **request)
                self.assertFalse(answer.success)
                self.assertIn(fault, answer.message)
            status = self.statuses.messages[self.statuses.wait_for(lambda status: True, len(self.statuses.messages) + 1)]
            self.assertFalse(status.paused)
            self.assertEqual(status.base_trajectory_age, -1)
        with Node(rod()):
            self.paused()
            answer = service('step', Step)(n=1, **motion((1, 0), still, still))
            self.assertIn('base_pose: expected a scene whose base moves (the key `base`)', answer.message)
            self.assertEqual(service('step', Step)(n=1).base_wrenches, [])


if __name__ == '__main__':
    rospy.init_node('ros_vehicle', anonymous=True)
    rostest.rosrun('planar_chain', 'ros_vehicle', Vehicle)
