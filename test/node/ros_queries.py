#!/usr/bin/python3
"""~equations and ~linearize: the same numbers as the tool `equations` prints, A as finite differences of what
~equations tells, with commands in force; and what is refused."""

import json
import math
import os
import subprocess
import tempfile
import unittest

import numpy
import roslib.packages
import rospy
import rostest
import yaml
from geometry_msgs.msg import Point, Vector3
from planar_chain.msg import LinkForce, Matrix, SimStatus
from planar_chain.srv import Equations, Linearize
from sensor_msgs.msg import JointState

from ros_node import LIMIT, Listener, Node, rod

KEYS = ('q', 'qd', 'S', 'T', 'V_pd', 'W_pd', 'A_1', 'A_2', 'A_3', 'f_ext', 'f', 'M', 'qdd')
Q, QD = [0.4, -0.7, 1.1], [0.3, -2.0, 0.9]

# Everything that acts, and nothing that depends on time: the tool's time is 0, the node's goes on. At Q the second
# joint is in its stop.
SCENE = {
    'chain': ['a', 'b', 'c'],
    'gravity': [0.7, -9.5],
    'links': {
        'a': {'mass': 1.5, 'inertia': 0.2, 'com': [0.5, 0.1], 'pin': [1.0, -0.1],
              'joint': {'stiffness': 4.0, 'rest_angle': 0.3, 'damping': 0.4}},
        'b': {'mass': 0.7, 'inertia': 0.04, 'com': [0.3, -0.1], 'pin': [0.8, 0.2],
              'joint': {'lower': -0.6, 'stop_stiffness': 50.0, 'stop_damping': 0.1}},
        'c': {'mass': 0.4, 'inertia': 0.01, 'com': [0.2, 0.0], 'pin': [0.4, 0.0],
              'initial': {'angle': 0.5, 'velocity': 1.0}},
    },
    'loads': {'wind': {'link': 'b', 'force': [1.0, 2.0], 'point': [0.6, 0.3], 'moment': 0.2},
              'motor': {'joint': 'c_joint', 'torque': 0.8}},
    'publish': {'rate': 200.0, 'status_rate': 20.0},
}


def plain(value):
    """Lists of numbers, matrices as lists of rows, as the tool prints them."""
    if isinstance(value, Matrix):
        assert len(value.data) == value.rows * value.columns
        return [list(value.data[i * value.columns:(i + 1) * value.columns]) for i in range(value.rows)]
    return [plain(entry) if isinstance(entry, Matrix) else entry for entry in value]


def tool(scene, *arguments):
    program = roslib.packages.find_node('planar_chain', 'equations')[0]
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, 'scene.yaml')
        with open(path, 'w', encoding='utf-8') as file:
            yaml.safe_dump(scene, file)
        return json.loads(subprocess.check_output([program, path, '--json', *arguments]))


def service(name, kind):
    rospy.wait_for_service('/planar_chain/' + name, LIMIT)
    query = rospy.ServiceProxy('/planar_chain/' + name, kind)
    return lambda q, qd: query(q=q, qd=qd)


class Queries(unittest.TestCase):
    def answer(self, query, *state):
        response = query(*state)
        self.assertTrue(response.success, response.message)
        self.assertEqual(response.message, '')
        return response

    def test_a_given_state_gives_the_numbers_of_the_tool(self):
        arguments = ['--linearize'] + ['--%s=%s' % (key, ','.join(map(repr, numbers)))
                                       for key, numbers in (('q', Q), ('qd', QD))]
        printed = tool(SCENE, *arguments)
        with Node(SCENE):
            equations = self.answer(service('equations', Equations), Q, QD)
            linear = self.answer(service('linearize', Linearize), Q, QD)
        for key in KEYS:
            self.assertEqual(plain(getattr(equations, key)), printed[key], key)
        self.assertEqual(plain(linear.A), printed['A'])
        self.assertEqual(plain(linear.B), printed['B'])

    def test_no_state_is_the_present_one(self):
        states = Listener('/joint_states', JointState)
        with Node(SCENE):
            equations, linearize = service('equations', Equations), service('linearize', Linearize)
            states.wait_for_count(5)
            present = self.answer(equations, [], [])
            at = states.wait_for(lambda state: state.position == present.q)
            self.assertEqual(states.messages[at].velocity, present.qd)
            again = self.answer(equations, present.q, present.qd)
            near = self.answer(linearize, [], [])
        states.close()
        self.assertEqual(present, again)
        self.assertEqual((near.A.rows, near.A.columns, near.B.rows, near.B.columns), (6, 6, 6, 3))

    def test_the_linear_model_is_the_derivative_of_the_equations_and_commands_are_in_both(self):
        push = LinkForce(link='c', point=Point(0.4, 0.1, 0), force=Vector3(3, -5, 0), moment=0.6)
        with Node(SCENE):
            equations, linearize = service('equations', Equations), service('linearize', Linearize)
            without = self.answer(equations, Q, QD)
            out = rospy.Publisher('/planar_chain/link_force', LinkForce, queue_size=1, latch=True)
            out.publish(push)
            statuses = Listener('/planar_chain/status', SimStatus)
            statuses.wait_for(lambda status: status.link_force_age >= 0)
            statuses.close()

            def qdd(change):
                state = numpy.array(Q + QD) + change
                return numpy.array(self.answer(equations, state[:3], state[3:]).qdd)

            at = self.answer(equations, Q, QD)
            near = self.answer(linearize, Q, QD)
            h = 1e-4  # the differences of second order are off by h² f'''/6, some 1e-8 of the whole
            differences = numpy.array([(qdd(step) - qdd(-step)) / (2 * h) for step in h * numpy.eye(6)]).T
            out.unregister()

        # The push in f_ext, moved to the centre of mass.
        theta = sum(Q)
        arm = numpy.array([[math.cos(theta), -math.sin(theta)], [math.sin(theta), math.cos(theta)]]) @ [0.2, 0.1]
        moment = push.moment + arm[0] * push.force.y - arm[1] * push.force.x
        moved = numpy.array(plain(at.V_pd))[:, 4:] @ [push.force.x, push.force.y] + moment
        numpy.testing.assert_allclose(numpy.subtract(at.f_ext, without.f_ext), moved, rtol=1e-12)

        A, B, M = (numpy.array(plain(matrix)) for matrix in (near.A, near.B, at.M))
        numpy.testing.assert_array_equal(A[:3], numpy.eye(3, 6, 3))
        numpy.testing.assert_allclose(A[3:], differences, atol=1e-6 * numpy.abs(A).max())
        numpy.testing.assert_array_equal(B[:3], numpy.zeros((3, 3)))
        numpy.testing.assert_allclose(B[3:] @ M, numpy.eye(3), atol=1e-12)

    def refused(self, query, state, *faults):
        response = query(*state)
        self.assertFalse(response.success)
        self.assertEqual(response.message, '; '.join(faults))
        for key in response.__slots__:
            value = getattr(response, key)
            if isinstance(value, Matrix):
                self.assertEqual(value, Matrix())
            elif key not in ('success', 'message'):
                self.assertEqual(len(value), 0, key)

    def test_wrong_states_are_refused_with_every_fault(self):
        nan, inf = float('nan'), float('inf')
        statuses = Listener('/planar_chain/status', SimStatus)
        with Node(SCENE):
            for name, kind in (('equations', Equations), ('linearize', Linearize)):
                query = service(name, kind)
                many = ': expected 3 %s, one per joint in chain order, got %d'
                self.refused(query, ([1], []), 'q' + many % ('angles', 1), 'qd' + many % ('rates', 0))
                self.refused(query, ([], QD), 'q' + many % ('angles', 0))
                self.refused(query, ([0] * 100000, QD), 'q' + many % ('angles', 100000))
                self.refused(query, ([0, nan, -inf], [inf, 0, 0]),
                             'q[1]: expected a finite number, rad, got nan',
                             'q[2]: expected a finite number, rad, got -inf',
                             'qd[0]: expected a finite number, rad/s, got inf')
                self.refused(query, ([0, 0, 1e17], QD), 'q: expected numbers up to 5.659390201622752e+16 rad in the joint c_joint, got 1e+17')
                self.refused(query, (Q, [1e200, 0, 0]),
                             'state: expected finite equations of motion, got numbers too large')
                self.answer(query, Q, QD)
            statuses.wait_for(lambda status: status.sim_time > 0.1 and not status.fault, len(statuses.messages))
        statuses.close()

    def test_chains_too_long_for_dense_matrices_are_refused(self):
        scene = rod()
        scene['links']['rod'].update(repeat=201)
        with Node(scene):
            for name, kind in (('equations', Equations), ('linearize', Linearize)):
                self.refused(service(name, kind), ([], []),
                             'chain: expected at most 200 links (the matrices are dense), got 201')


if __name__ == '__main__':
    rospy.init_node('ros_queries', anonymous=True)
    rostest.rosrun('planar_chain', 'ros_queries', Queries)
