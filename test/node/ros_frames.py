#!/usr/bin/python3
"""Frames: robot_description, /tf, joint_states and link_states tell of the same chain, and two chains in two
namespaces (frames.test launches them as left and right) keep out of each other's way."""

import math
import subprocess
import unittest
import xml.etree.ElementTree as ElementTree

import numpy
import rospy
import rostest
from planar_chain.msg import LinkStates, SimStatus
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage

from ros_node import Listener, Node, nanoseconds

L_SHAPED = {
    'chain': ['upper', 'lower'],
    'gravity': [0.0, 0.0],
    'links': {
        'upper': {'mass': 1.0, 'inertia': 0.1, 'com': [0.5, 0.2], 'pin': [0.8, 0.3],
                  'joint': {'name': 'shoulder', 'damping': 0.25}, 'initial': {'angle': math.pi / 2}},
        'lower': {'mass': 2.0, 'inertia': 0.0, 'com': [0.3, 0.0], 'pin': [0.6, 0.0],
                  'initial': {'angle': -math.pi / 2}},
    },
}


def turned(quaternion, translation):
    """A pose as a 4×4 matrix."""
    x, y, z, w = quaternion.x, quaternion.y, quaternion.z, quaternion.w
    return numpy.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), translation.x],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), translation.y],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), translation.z],
        [0, 0, 0, 1]])


def about_z(angle, origin):
    c, s = math.cos(angle), math.sin(angle)
    pose = numpy.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    pose[:3, 3] = origin
    return pose


def about_x(rpy):
    roll, pitch, yaw = map(float, rpy.split())
    assert pitch == 0 and yaw == 0
    c, s = math.cos(roll), math.sin(roll)
    return numpy.array([[1, 0, 0, 0], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1]])


def tree_of(transforms):
    """(parent, pose in the parent) by frame."""
    return {one.child_frame_id: (one.header.frame_id,
                                 turned(one.transform.rotation, one.transform.translation))
            for one in transforms}


def pose_in(root, frame, tree):
    pose = numpy.eye(4)
    while frame != root:
        frame, step = tree[frame]
        pose = step @ pose
    return pose


def urdf_tree(urdf, joints):
    """The tree of frames from robot_description and the joints' angles."""
    tree = {}
    for joint in ElementTree.fromstring(urdf).findall('joint'):
        origin = numpy.array(joint.find('origin').get('xyz').split(), float)
        if joint.get('type') == 'fixed':
            pose = about_x(joint.find('origin').get('rpy'))
            pose[:3, 3] = origin
            tree[joint.find('child').get('link')] = (joint.find('parent').get('link'), pose)
            continue
        assert joint.find('origin').get('rpy') == '0 0 0'
        axis = numpy.array(joint.find('axis').get('xyz').split(), float)
        q = joints[joint.get('name')]
        if joint.get('type') == 'prismatic':
            pose = about_z(0, origin + q * axis)
        else:
            assert joint.get('type') == 'continuous' and axis.tolist() == [0, 0, 1]
            pose = about_z(q, origin)
        tree[joint.find('child').get('link')] = (joint.find('parent').get('link'), pose)
    return tree


class Frames(unittest.TestCase):
    def listen(self, topic, message_type):
        listener = Listener(topic, message_type)
        self.addCleanup(listener.close)
        return listener

    def transforms_of(self, prefix):
        """The last transforms of a chain, its states of the same stamp, and the static ones."""
        states = self.listen('/%sjoint_states' % prefix, JointState)
        links = self.listen('/%splanar_chain/link_states' % prefix, LinkStates)
        moving = self.listen('/tf', TFMessage)
        still = self.listen('/tf_static', TFMessage)
        base = prefix + 'base_link'
        states.wait_for_count(20)
        links.wait_for_count(20)
        begun = max(nanoseconds(states.messages[19]), nanoseconds(links.messages[19]))
        at = moving.messages[moving.wait_for(
            lambda message: message.transforms[0].header.frame_id == base
            and nanoseconds(message.transforms[0]) >= begun)]

        def of_same_stamp(message):
            return message.header.stamp == at.transforms[0].header.stamp
        state = states.messages[states.wait_for(of_same_stamp)]
        link = links.messages[links.wait_for(of_same_stamp)]
        fixed = still.messages[still.wait_for(
            lambda message: message.transforms[0].child_frame_id == base)]
        return list(fixed.transforms) + list(at.transforms), state, link

    def assert_poses_equal(self, a, b):
        numpy.testing.assert_allclose(a, b, rtol=0, atol=1e-12)

    def test_frames_stand_where_geometry_puts_them(self):
        with Node(L_SHAPED, '/alone'):
            transforms, _, _ = self.transforms_of('alone/')
        tree = tree_of(transforms)
        # The plane of motion stands upright: x to the right, y of the base up along z of the world.
        upper = pose_in('world', 'alone/upper', tree)
        lower = pose_in('world', 'alone/lower', tree)
        self.assert_poses_equal(upper[:3, 3], [0, 0, 0])
        self.assert_poses_equal(upper[:3, 0], [0, 0, 1])
        self.assert_poses_equal(lower[:3, 3], [-0.3, 0, 0.8])
        self.assert_poses_equal(lower[:3, 0], [1, 0, 0])
        self.assert_poses_equal(lower[:3, 2], [0, -1, 0])

    def test_an_offset_moves_the_base_in_the_world_alone(self):
        with Node(dict(L_SHAPED, publish={'offset': [2.0, -1.5]}), '/alone'):
            transforms, _, links = self.transforms_of('alone/')
            urdf = rospy.get_param('/alone/robot_description')
        tree = tree_of(transforms)
        self.assert_poses_equal(pose_in('world', 'alone/lower', tree)[:3, 3], [1.7, 0, -0.7])
        self.assert_poses_equal((pose_in('alone/base_link', 'alone/upper', tree) @ [0.5, 0.2, 0, 1])[:2], [links.pose[0].x, links.pose[0].y])
        self.assertEqual(ElementTree.fromstring(urdf).find("joint[@type='fixed']/origin").get('xyz'), '2 0 -1.5')

    def test_frames_of_every_second_link_lie_where_its_links_lie(self):
        scene = dict(L_SHAPED, publish={'frame_every': 2}, gravity=[0.0, -9.81])
        scene['links'] = dict(scene['links'], lower=dict(scene['links']['lower'], repeat=4))
        with Node(scene, '/alone'):
            transforms, state, links = self.transforms_of('alone/')
        self.assertEqual(len(state.name), 5)
        tree = tree_of(transforms)
        self.assertEqual(set(tree), {'alone/base_link', 'alone/upper', 'alone/lower_2', 'alone/lower_4', 'alone/tip'})
        for frame, com in (('upper', [0.5, 0.2]), ('lower_2', [0.3, 0.0]), ('lower_4', [0.3, 0.0])):
            pose = links.pose[links.name.index(frame)]
            in_base = pose_in('alone/base_link', 'alone/' + frame, tree)
            self.assert_poses_equal((in_base @ [*com, 0, 1])[:2], [pose.x, pose.y])
            self.assert_poses_equal(in_base[:2, 0], [math.cos(pose.theta), math.sin(pose.theta)])

    def test_urdf_says_what_the_scene_says(self):
        with Node(L_SHAPED, '/alone') as node:
            self.listen(node.name + '/status', SimStatus).wait_for_count(1)
            urdf = rospy.get_param('/alone/robot_description')
        checked = subprocess.run(['check_urdf', '/dev/stdin'], input=urdf, text=True,
                                 stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        self.assertEqual(checked.returncode, 0, checked.stdout)
        self.assertIn('root Link: world has 1 child(ren)', checked.stdout)

        robot = ElementTree.fromstring(urdf)
        upper = robot.find("link[@name='alone/upper']/inertial")
        self.assertEqual(upper.find('origin').get('xyz'), '0.5 0.2 0')
        self.assertEqual(upper.find('mass').get('value'), '1')
        self.assertEqual(upper.find('inertia').get('izz'), '0.1')
        self.assertEqual(robot.find("joint[@name='shoulder']/dynamics").get('damping'), '0.25')
        self.assertEqual(robot.find("joint[@name='lower_joint']/origin").get('xyz'), '0.8 0.3 0')

    def assert_all_tell_the_same(self, prefix):
        """/tf, the URDF moved by joint_states, and link_states. Returns the frames."""
        transforms, state, links = self.transforms_of(prefix)
        by_tf = tree_of(transforms)
        urdf = rospy.get_param('/%srobot_description' % prefix)
        by_urdf = urdf_tree(urdf, dict(zip(state.name, state.position)))
        for name, pose in zip(links.name, links.pose):
            in_base = pose_in(prefix + 'base_link', prefix + name, by_tf)
            self.assert_poses_equal(
                in_base, pose_in(prefix + 'base_link', prefix + name, by_urdf))
            self.assert_poses_equal(
                pose_in('world', prefix + name, by_tf), pose_in('world', prefix + name, by_urdf))
            com = ElementTree.fromstring(urdf).find(
                "link[@name='%s']/inertial/origin" % (prefix + name)).get('xyz').split()
            self.assert_poses_equal((in_base @ [*map(float, com), 1])[:2], [pose.x, pose.y])
            self.assert_poses_equal(in_base[:2, 0], [math.cos(pose.theta), math.sin(pose.theta)])
        frames = {one.child_frame_id for one in transforms}
        self.assertEqual({one.header.frame_id for one in transforms} - frames, {'world'})
        self.assertTrue(all(name.startswith(prefix) for name in frames))
        return frames

    def test_prismatic_joints_within_the_chain(self):
        def sliding(x, y, velocity):
            return {'mass': 1.0, 'inertia': 0.1, 'com': [0.1, 0.2], 'pin': [0.3, -0.1],
                    'joint': {'type': 'prismatic', 'axis': [x, y]}, 'initial': {'position': 0.4, 'velocity': velocity}}
        scene = dict(L_SHAPED, chain=['cart', 'upper', 'tube', 'lower', 'end'])
        scene['links'] = dict(scene['links'], cart=sliding(1.0, 0.5, 0.2), tube=sliding(3.0, -4.0, 0.5), end=sliding(0.0, 1.0, -0.3))
        with Node(scene, '/alone'):
            self.assert_all_tell_the_same('alone/')

    def test_two_chains_in_two_namespaces(self):
        both = {prefix: self.assert_all_tell_the_same(prefix) for prefix in ('left/', 'right/')}
        self.assertFalse(both['left/'] & both['right/'])

        topics = dict(rospy.get_published_topics())
        for name in ('joint_states', 'planar_chain/link_states', 'planar_chain/status'):
            self.assertIn('/left/' + name, topics)
            self.assertIn('/right/' + name, topics)
        self.assertNotIn('/joint_states', topics)

    def test_nobody_warns(self):
        log = self.listen('/rosout_agg', Log)
        self.transforms_of('left/')
        self.assertEqual([line.msg for line in log.messages if line.level >= Log.WARN], [])


if __name__ == '__main__':
    rospy.init_node('ros_frames', anonymous=True)
    rostest.rosrun('planar_chain', 'ros_frames', Frames)
