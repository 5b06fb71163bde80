#!/usr/bin/python3
"""The scene cart_pole in the node: what a prismatic joint has in every message and service, in m and N."""

import math
import os
import unittest

import numpy
import roslib.packages
import rospy
import rostest
import yaml
from planar_chain.msg import JointTorque
from planar_chain.srv import Equations, Linearize, SetState, Step
from tf2_msgs.msg import TFMessage

from ros_node import LIMIT, Listener, Node, Watching

M, m, c, J, g = 1.0, 0.4, 0.25, 0.0085, 9.81  # cart_pole.yaml


def service(name, kind):
    rospy.wait_for_service('/planar_chain/' + name, LIMIT)
    return rospy.ServiceProxy('/planar_chain/' + name, kind)


def cart_pole(**more):
    path = os.path.join(roslib.packages.get_pkg_dir('planar_chain'), 'config', 'scenes', 'cart_pole.yaml')
    with open(path, encoding='utf-8') as file:
        return dict(yaml.safe_load(file), **more)


class Carts(Watching):
    def test_a_prismatic_joint_is_a_joint_like_any_other(self):
        frames = Listener('/tf', TFMessage)
        with Node(cart_pole()):
            self.states.wait_for_count(3)
            self.assertEqual(self.states.messages[-1].name, ['cart_joint', 'pole_joint'])

            # Linearized at the top: the textbook's A and B of a cart-pole.
            linear = service('linearize', Linearize)(q=[0, math.pi / 2], qd=[0, 0])
            a = numpy.array(linear.A.data).reshape(4, 4)
            b = numpy.array(linear.B.data).reshape(4, 2)
            total, inertia = M + m, J + m * c * c
            d = total * inertia - (m * c) ** 2
            numpy.testing.assert_allclose(a[2:, :2], [[0, (m * c) ** 2 * g / d], [0, total * m * c * g / d]], atol=1e-12)
            numpy.testing.assert_allclose(b[2:, 0], [inertia / d, m * c / d], rtol=1e-12)
            equations = service('equations', Equations)([0, math.pi / 2], [0, 0])
            numpy.testing.assert_allclose(equations.M.data, [total, -m * c, -m * c, inertia], rtol=1e-12)

            # Set; the cart's frame is on its axis.
            self.assertTrue(service('set_state', SetState)([0.3, -math.pi / 2], [0, 0]).success)
            at = frames.wait_for(lambda message: any(
                each.child_frame_id == 'cart' and abs(each.transform.translation.x - 0.3) < 0.01
                for each in message.transforms))
            cart, pole = frames.messages[at].transforms[:2]
            self.assertEqual((cart.transform.translation.y, cart.transform.rotation.z), (0, 0))
            self.assertEqual((pole.header.frame_id, pole.transform.translation.y), ('cart', 0.1))

            # In lockstep from there, the cart is pushed by 1.4 N.
            answer = service('step', Step)(torques=[total, 0], n=1)
            self.assertTrue(answer.success, answer.message)
            state = answer.states[0]
            self.assertEqual(state.effort[0], total)
            numpy.testing.assert_allclose(state.velocity[0] / 0.005, inertia * total / d, rtol=1e-3)
        frames.close()

    def test_a_command_pushes_until_the_end_of_the_rail(self):
        out = rospy.Publisher('/planar_chain/joint_torque', JointTorque, queue_size=1, latch=True)
        with Node(cart_pole()):
            out.publish(joint='cart_joint', torque=100)  # N: cut off at effort_limit
            at = self.states.wait_for(lambda state: state.effort[0] == 20)
            self.states.wait_for(lambda state: state.position[0] > 1.5 and state.effort[0] < 0, at)
            self.statuses.wait_for(lambda status: status.joints_cut_off == ['cart_joint'])
        out.unregister()


if __name__ == '__main__':
    rospy.init_node('ros_carts', anonymous=True)
    rostest.rosrun('planar_chain', 'ros_carts', Carts)
