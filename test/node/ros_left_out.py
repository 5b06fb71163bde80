#!/usr/bin/python3
"""Topics without subscribers are not computed, by callgrind; late subscribers get everything; and the log says what runs."""

import os
import sys
import tempfile
import unittest

import rospy
import rostest
from planar_chain.msg import LinkStates, SimStatus
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from ros_node import Listener, Node, nanoseconds, rod

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), '../support'))
import callgrind  # noqa: E402

# topic: (its type, what makes it)
MESSAGES = {
    '/joint_states': (JointState, 'planar_chain::Messages::jointStates('),
    '/tf': (TFMessage, 'planar_chain::Messages::transforms('),
    '/planar_chain/link_states': (LinkStates, 'planar_chain::Messages::linkStates('),
    '/planar_chain/status': (SimStatus, 'planar_chain::describe('),
}
VIEWS = {
    '/planar_chain/view/loads': (MarkerArray, 'planar_chain::Views::drawLoads('),
    '/planar_chain/view/pin_forces': (MarkerArray, 'planar_chain::Views::drawPinForces('),
    '/planar_chain/view/springs': (MarkerArray, 'planar_chain::Views::drawSprings('),
    '/planar_chain/view/friction': (MarkerArray, 'planar_chain::Views::drawFriction('),
    '/planar_chain/view/drives': (MarkerArray, 'planar_chain::Views::drawDrives('),
    '/planar_chain/view/trail': (MarkerArray, 'planar_chain::Views::drawTrail('),
    '/planar_chain/view/centres': (MarkerArray, 'planar_chain::Views::drawCentres('),
    '/planar_chain/view/limits': (MarkerArray, 'planar_chain::Views::drawLimits('),
    '/planar_chain/view/scale': (MarkerArray, 'planar_chain::ScaleBar::message('),
    '/planar_chain/view/energy': (MarkerArray, 'planar_chain::EnergyText::write('),
}
ALL = {**MESSAGES, **VIEWS}


def made(*topics):
    """The topics whose messages are made in the ticks of a node while somebody listens to these."""
    listeners = [Listener(topic, ALL[topic][0]) for topic in topics]
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, 'out')
        with Node(rod(), prefix=callgrind.prefix('planar_chain::Node::run(*', out)):
            for listener in listeners:
                listener.wait_for_count(2)
        functions = {function for function, _ in callgrind.read(out).where}
    for listener in listeners:
        listener.close()
    return {topic for topic, (_, maker) in ALL.items()
            if any(function.startswith(maker) for function in functions)}


def said(scene):
    """What a node on this scene writes to its log."""
    statuses = Listener('/planar_chain/status', SimStatus)
    with Node(scene) as node:
        statuses.wait_for_count(1)
    statuses.close()
    return node.wait()[1]


class LeftOut(unittest.TestCase):
    def check(self, *topics):
        self.assertEqual(made(*topics), set(topics))

    def test_joint_states_and_tf_alone(self):
        self.check('/joint_states', '/tf')

    def test_link_states_and_status_alone(self):
        self.check('/planar_chain/link_states', '/planar_chain/status')

    def test_some_views_alone(self):
        self.check('/planar_chain/view/pin_forces', '/planar_chain/view/trail', '/planar_chain/view/energy', '/planar_chain/view/scale')

    def test_the_other_views_alone(self):
        self.check('/planar_chain/view/loads', '/planar_chain/view/springs', '/planar_chain/view/centres',
                   '/planar_chain/view/friction', '/planar_chain/view/drives', '/planar_chain/view/limits')

    def test_who_listens_later_gets_whole_messages(self):
        states = Listener('/joint_states', JointState)
        with Node(rod()):
            states.wait_for_count(200)
            late = {topic: Listener(topic, message_type) for topic, (message_type, _) in MESSAGES.items()}
            for listener in late.values():
                listener.wait_for_count(1)
        state, transforms, links, status = (late[topic].messages[0] for topic in MESSAGES)
        for listener in (states, *late.values()):
            listener.close()

        self.assertEqual((state.name, len(state.position), len(state.velocity), len(state.effort)),
                         (['rod_joint'], 1, 1, 1))
        turn = transforms.transforms[0].transform.rotation
        self.assertAlmostEqual(turn.z ** 2 + turn.w ** 2, 1, delta=1e-12)
        self.assertEqual((links.name, len(links.pose), len(links.pin_force)), (['rod'], 1, 1))
        for message in (state, transforms.transforms[0], links, status):
            self.assertGreater(nanoseconds(message), nanoseconds(states.messages[0]) + 0.9e9)
        # Measured since the start, not since somebody listens: the first sample of all is 0.
        self.assertGreater(status.real_time_factor, 0)
        self.assertGreater(status.sim_time, 0.9)
        self.assertNotEqual(status.method, '')

    def test_a_fault_that_nobody_hears_is_said_once(self):
        log = Listener('/rosout', Log)
        with Node(rod(loads={'blast': {'joint': 'rod_joint', 'torque': 1e200, 'start': 0.3}})) as node:
            log.wait_for(lambda line: line.level == Log.ERROR)
            statuses = Listener('/planar_chain/status', SimStatus)
            statuses.wait_for_count(5)
        for listener in (log, statuses):
            listener.close()
        self.assertIn('the last good state is kept', statuses.messages[0].fault)
        self.assertEqual(node.wait()[1].count('the last good state is kept'), 1)

    def test_the_log_says_what_runs_and_what_is_left_out(self):
        bare = said(rod(publish={'tf': False, 'link_states': False}))
        self.assertIn('1 link (link by link, written out for 1) by auto, tolerance 1e-08; '
                      'runs: energy guard, commands that hold until replaced; '
                      'not in this scene, at no cost: gravity, springs, dampers, loads, joint limits', bare)
        self.assertIn('publishes on demand: joint_states at 200 Hz, status at 10 Hz, views at 50 Hz; '
                      'disabled: link_states, tf', bare)

        joint = {'stiffness': 1.0, 'damping': 0.1, 'upper': 1.0, 'stop_stiffness': 100.0}
        full = rod(gravity=[0.0, -9.81], command_timeout=0.5,
                   loads={'turn': {'joint': 'rod_joint', 'torque': 1.0}})
        full['links']['rod']['joint'] = joint
        log = said(full)
        self.assertIn('runs: gravity, 1 spring, 1 damper, 1 load, 1 joint limit, energy guard, '
                      'commands that lapse after 0.5 s', log)
        self.assertNotIn('at no cost', log)
        self.assertIn('publishes on demand: joint_states and link_states at 200 Hz, '
                      'tf at 50 Hz below base_link, status at 20 Hz, views at 50 Hz', log)
        self.assertNotIn('disabled', log)


if __name__ == '__main__':
    rospy.init_node('ros_left_out', anonymous=True)
    rostest.rosrun('planar_chain', 'ros_left_out', LeftOut)
