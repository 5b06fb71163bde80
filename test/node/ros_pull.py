#!/usr/bin/python3
"""The node `pull`: what rviz tells of a drag becomes a critically damped spring to the mouse, which ends with the
mouse button, with rviz's silence, and with the node. In lockstep: a tick is made when the force for it is there."""

import math
import os
import signal
import subprocess
import threading
import unittest

import roslib.packages
import rospy
import rostest
from planar_chain.msg import CommandTaken, LinkStates
from planar_chain.srv import Step
from sensor_msgs.msg import JointState
from visualization_msgs.msg import InteractiveMarkerFeedback, InteractiveMarkerInit, InteractiveMarkerUpdate, Marker, MarkerArray

from ros_node import LIMIT, Listener, Node, PUBLISHERS, nanoseconds, publisher, rod, service

RATE = 200.0
PULSATION = 20.0  # rad/s, of pull's spring
OVERLAP = 1e-6    # s that a force outlasts its tick
NEVER = 0.3       # s of wall time in which a force that is not on its way does not come


class Pull:
    """The program under test, while the with statement lasts."""

    def __enter__(self):
        program = roslib.packages.find_node('planar_chain', 'pull')[0]
        self.process = subprocess.Popen([program], env=dict(os.environ, ROS_NAMESPACE='/'))
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
            self.process.wait(LIMIT)


class Rviz:
    """Says of a drag what rviz says: the mouse in the link's frame as it stood at a stamp, again and again."""

    def __init__(self):
        self._out = publisher('/pull/feedback', InteractiveMarkerFeedback)
        PUBLISHERS.remove(self._out)  # of another node
        self._said = None
        self._silent = threading.Event()
        self._thread = threading.Thread(target=self._keep_alive)
        self._thread.start()

    def _keep_alive(self):
        while not self._silent.wait(0.2):
            if self._said:
                self._out.publish(self._said)

    def say(self, event, stamp, moved=(0.0, 0.0), point=(1.0, 0.0), frame='rod'):
        message = InteractiveMarkerFeedback(
            client_id='/rviz', marker_name='rod', control_name='pull', event_type=event, mouse_point_valid=True)
        message.header.frame_id, message.header.stamp = frame, stamp
        message.pose.position.x, message.pose.position.y = moved
        message.pose.orientation.w = 1
        message.mouse_point.x, message.mouse_point.y = point
        self._said = None
        self._out.publish(message)
        if event != InteractiveMarkerFeedback.MOUSE_UP:
            message.event_type = InteractiveMarkerFeedback.KEEP_ALIVE
            self._said = message

    def fall_silent(self):
        self._silent.set()
        self._thread.join()

    def close(self):
        self.fall_silent()
        self._out.unregister()


class Dragged(unittest.TestCase):
    def setUp(self):
        self.states = Listener('/joint_states', JointState)
        self.taken = Listener('/planar_chain/commands_taken', CommandTaken)
        self.pictures = Listener('/pull/force', MarkerArray)
        self.links = Listener('/planar_chain/link_states', LinkStates)
        self.changes = Listener('/pull/update', InteractiveMarkerUpdate)
        listeners = (self.states, self.taken, self.pictures, self.changes, self.links)
        self.addCleanup(lambda: [listener.close() for listener in listeners])

    def start(self, markers=('rod',), **more):
        """A rod at rest along x, its tip held by the mouse; one force for each tick from here on."""
        for running in (Node(rod(publish={'rate': RATE}, **more)), Pull()):
            running.__enter__()
            self.addCleanup(running.__exit__)
            self.running = running
        self.step_service = service('step', Step)
        self.taken.wait_for_publisher()
        self.pictures.wait_for_publisher()
        # roscpp gives a subscriber that comes while a latched message is published the one before, and no other.
        self.changes.wait_for(lambda update: update.seq_num > 0)
        offered = Listener('/pull/update_full', InteractiveMarkerInit)
        self.addCleanup(offered.close)
        offered.wait_for(lambda offer: {marker.name for marker in offer.markers} == set(markers))
        self.rviz = Rviz()
        self.addCleanup(self.rviz.close)
        state = self.step()
        self.rviz.say(InteractiveMarkerFeedback.MOUSE_DOWN, state.header.stamp)
        self.step_until(lambda: self.forces())
        # Until this tick's force is told, so that on a busy machine too each tick has one and waits for it.
        last = self.step()
        self.pictures.wait_for(lambda picture: picture.markers[0].header.stamp == last.header.stamp)
        rospy.sleep(NEVER)

    def step(self):
        return self.step_service(torques=[], n=1).states[-1]

    def step_until(self, holds):
        """Ticks, each with time for a force to come."""
        for _ in range(int(LIMIT / NEVER)):
            state = self.step()
            rospy.sleep(NEVER / 3)
            if holds():
                return state
        raise AssertionError('%d forces came' % len(self.forces()))

    def forces(self):
        return [taken.link_force[0] for taken in list(self.taken.messages) if taken.kind == CommandTaken.LINK_FORCE]

    def drag(self, x, y, first=0):
        """The mouse at x, y of the base, until the rod is drawn there. first: its angle now."""
        state = self.step_with_force()
        self.assertAlmostEqual(state.position[0], first, delta=1e-12)
        self.rviz.say(InteractiveMarkerFeedback.POSE_UPDATE, state.header.stamp, (x - 1, y))
        while self.forces()[-1].force.y == 0:
            self.step_with_force()

    def step_with_force(self):
        """A tick whose force is there already, and the force for the next."""
        told = len(self.forces())
        state = self.step()
        self.taken.wait_for(lambda _: len(self.forces()) > told)
        return state

    def assert_free(self):
        """Nothing acts: the rod turns evenly, after the tick of the last force and the one that it outlasts it into."""
        for _ in range(2):
            self.step()
        speeds = [self.step().velocity[0] for _ in range(10)]
        self.assertGreater(abs(speeds[0]), 0.01)
        for speed in speeds:
            self.assertAlmostEqual(speed, speeds[0], delta=1e-12)

    def is_let_go(self):
        return self.pictures.messages and self.pictures.messages[-1].markers[0].action == Marker.DELETE

    def test_the_link_comes_to_the_mouse_on_a_turned_base(self):
        turned, angle = 3.0, 0.1
        self.start(base={'angle': {'offset': turned}}, links={'rod': {**rod()['links']['rod'], 'initial': {'angle': -turned}}})
        self.drag(math.cos(angle), math.sin(angle), -turned)
        states = [self.step_with_force() for _ in range(100)]
        self.assertAlmostEqual(states[-1].position[0], angle - turned, delta=0.005 * angle)

    def test_a_link_on_a_prismatic_joint_comes_to_the_mouse_on_a_turned_base(self):
        turned, way = 3.0, 0.1
        sliding = {'type': 'prismatic', 'axis': [1.0, 0.0], 'rotor_inertia': 8.0}  # a motor that resists as four rods
        links = {'boom': {**rod()['links']['rod'], 'initial': {'angle': -turned}}, 'rod': {**rod()['links']['rod'], 'joint': sliding}}
        self.start(('boom', 'rod'), chain=['boom', 'rod'], base={'angle': {'offset': turned}}, links=links)
        state = self.step_with_force()
        self.rviz.say(InteractiveMarkerFeedback.POSE_UPDATE, state.header.stamp, (way, 0.0))
        while self.forces()[-1].force.x < 1:
            self.step_with_force()
        states = [self.step_with_force() for _ in range(100)]
        self.assertAlmostEqual(states[-1].position[1], way, delta=0.005 * way)
        self.assertAlmostEqual(states[-1].position[0], -turned, delta=1e-9)

    def test_the_link_comes_to_the_mouse_with_critical_damping(self):
        self.start()
        angle = 0.1
        self.drag(math.cos(angle), math.sin(angle))
        states = [self.step_with_force() for _ in range(100)]
        # The force acts from the last state at rest on; the microsecond of one that came late is rest still.
        moving = self.states.wait_for(lambda state: abs(state.position[0]) > 1e-5)
        begin = nanoseconds(self.states.messages[moving - 1])
        farthest = 0
        for state in states:
            t = (nanoseconds(state) - begin) * 1e-9
            expected = angle * (1 - (1 + PULSATION * t) * math.exp(-PULSATION * t))
            # A force that is held for a tick, 0.1/ω, comes late by half of that.
            self.assertAlmostEqual(state.position[0], expected, delta=0.05 * angle)
            farthest = max(farthest, state.position[0])
        self.assertAlmostEqual(farthest / angle, 1, delta=0.005)
        force = self.forces()[-1]
        self.assertEqual((force.link, force.point.x, force.point.y, force.duration), ('rod', 1, 0, 1 / RATE + OVERLAP))
        # What is told of a tick's end has the force that led there: the rod's angular acceleration is its change of rate.
        alphas = [links.acceleration[0].angular.z for links in self.links.messages]
        self.assertGreater(max(alphas), 0.5 * PULSATION ** 2 * angle)

    def test_a_pause_shows_the_link_and_its_spring(self):
        self.start()
        rospy.sleep(NEVER)  # no tick
        seen = len(self.pictures.messages)
        self.rviz.say(InteractiveMarkerFeedback.POSE_UPDATE, rospy.Time(), (0.2, 0.5))
        farthest = self.pictures.wait_for(
            lambda picture: max((point.y for marker in picture.markers for point in marker.points), default=0) > 0.4, seen)
        points = self.pictures.messages[farthest].markers[0].points
        self.assertLess(min(point.x for point in points), 0)  # the link itself, to beyond its inner pin
        self.rviz.say(InteractiveMarkerFeedback.MOUSE_UP, rospy.Time())
        gone = self.pictures.messages[self.pictures.wait_for(lambda picture: not picture.markers[0].points, farthest)]
        self.assertEqual((gone.markers[0].action, gone.markers[0].header.stamp.to_nsec()), (Marker.DELETE, 0))

    def test_the_force_ends_with_the_mouse_button(self):
        self.start()
        self.drag(0.0, 1.0)
        self.step_with_force()
        self.rviz.say(InteractiveMarkerFeedback.MOUSE_UP, rospy.Time())
        self.rviz.say(InteractiveMarkerFeedback.KEEP_ALIVE, rospy.Time())  # else it is silence that ends it
        self.step_until(self.is_let_go)
        self.assert_free()

    def test_the_force_ends_when_rviz_falls_silent(self):
        self.start()
        self.drag(0.0, 1.0)
        self.step_with_force()
        self.assertFalse(self.is_let_go())
        self.rviz.fall_silent()
        self.step_until(self.is_let_go)
        self.assert_free()

    def test_the_force_ends_with_the_node_that_sends_it(self):
        self.start()
        self.drag(0.0, 1.0)
        self.step_with_force()
        self.running.process.kill()
        self.running.process.wait(LIMIT)
        self.assert_free()

    def test_what_no_rviz_says_is_passed_over(self):
        self.start()
        state = self.step()
        self.rviz.say(InteractiveMarkerFeedback.POSE_UPDATE, state.header.stamp, (float('nan'), 0.0))
        self.step_until(lambda: True)
        self.rviz.say(InteractiveMarkerFeedback.POSE_UPDATE, state.header.stamp, (0.0, 1.0), frame='world')
        self.step_until(lambda: True)
        self.assertEqual({force.force.y for force in self.forces()}, {0.0})


if __name__ == '__main__':
    rospy.init_node('ros_pull', anonymous=True)
    rostest.rosrun('planar_chain', 'ros_pull', Dragged)
