#!/usr/bin/python3
"""What a node did under commands from several sources, recorded by the real rosbag, simulate does again: every
state that was recorded, to the last bit."""

import math
import os
import random
import subprocess
import sys
import time
import xmlrpc.client

import roslib.packages
import rosbag
import rospy
import rostest
import yaml
from geometry_msgs.msg import Point, Pose2D, Twist, Vector3
from planar_chain.msg import CommandTaken, JointTorque, LinkForce, SimStatus
from planar_chain.srv import SetState, Step
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint, MultiDOFJointTrajectory

from ros_commands import publisher
from ros_machines import base_point, base_trajectory
from ros_node import LIMIT, Listener, Node, Running, nanoseconds

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), '../support'))
from in_folder import InFolder  # noqa: E402

TOPICS = ['/joint_states', '/planar_chain/status', '/planar_chain/scene', '/planar_chain/commands_taken', '/planar_chain/joint_torques',
          '/planar_chain/encoders', '/planar_chain/imu']
RATE = 200.0
LINK = {'mass': 1.0, 'inertia': 0.1, 'com': [0.5, 0.0], 'pin': [1.0, 0.0], 'joint': {'damping': 0.05}}
SCENE = {
    'chain': ['first', 'second', 'third'],
    'links': {name: dict(LINK) for name in ('first', 'second', 'third')},
    'loads': {'shake': {'joint': 'second_joint', 'torque': 1.0, 'frequency': 0.7}},
    'sensors': {'encoders': {'joints': 'all', 'resolution': 0.001, 'noise': 0.002, 'delay': 0.0125, 'rate': 100.0},
                'imu': {'link': 'third', 'gyro_noise': 0.01, 'gyro_bias_walk': 0.1, 'accelerometer_noise': 0.1, 'rate': 400.0}},
    'seed': 7,
    'command_timeout': 0.3,
    'publish': {'rate': RATE, 'status_rate': 20.0},
}


def wait_until_recorded(topics):
    """Until the node has a connection to rosbag for each."""
    code, _, uri = rospy.get_master().lookupNode('/planar_chain')
    assert code == 1
    node = xmlrpc.client.ServerProxy(uri)
    waited = time.monotonic()
    while True:
        recorded = {link[4] for link in node.getBusInfo(rospy.get_name())[2] if link[1].startswith('/record')}
        if set(topics) <= recorded:
            return
        if time.monotonic() - waited > LIMIT:
            raise AssertionError('rosbag records %s only' % recorded)
        rospy.rostime.wallsleep(0.05)


def values_of(message):
    if message._type == 'sensor_msgs/JointState':
        return message.position
    fields = (message.angular_velocity, message.linear_acceleration)
    return tuple(getattr(field, axis) for field in fields for axis in 'xyz')


def measurements_in(path):
    """{(topic, 400ths of a second since the start): values}"""
    with rosbag.Bag(path) as bag:
        start = min(status.tick_stamp.to_nsec() * 1e-9 - status.tick / RATE
                    for _, status, _ in bag.read_messages('/planar_chain/status') if status.tick_stamp)
        return {(topic, round((nanoseconds(message) * 1e-9 - start) * 400)): values_of(message)
                for topic, message, _ in bag.read_messages(['/planar_chain/encoders', '/planar_chain/imu'])}


def states_in(path):
    """{tick: (q, qd, effort)}, of a run that never paused, or by a clock that stood still in pauses"""
    with rosbag.Bag(path) as bag:
        start = min(status.tick_stamp.to_nsec() * 1e-9 - status.tick / RATE
                    for _, status, _ in bag.read_messages('/planar_chain/status') if status.tick_stamp)
        return {round((nanoseconds(message) * 1e-9 - start) * RATE): (message.position, message.velocity, message.effort)
                for _, message, _ in bag.read_messages('/joint_states')}


class CommandsReplay(InFolder):
    def record(self, scene, between):
        """A node that is pushed some hundred times; between(i, states): what else is asked of it."""
        states = Listener('/joint_states', JointState)
        statuses = Listener('/planar_chain/status', SimStatus)
        with Node(scene):
            with Running('rosbag', 'record', '-q', '-O', self.path('node.bag'), *TOPICS):
                torques = publisher('/planar_chain/joint_torques', Float64MultiArray)
                torque = publisher('/planar_chain/joint_torque', JointTorque)
                force = publisher('/planar_chain/link_force', LinkForce)
                wait_until_recorded(['/joint_states', '/planar_chain/status', '/planar_chain/commands_taken'])
                chance = random.Random(1)
                states.wait_for_count(1)
                for i in range(30):
                    # Several in one tick, on topics whose order is the node's to say, some of them wrong.
                    for _ in range(chance.randint(1, 4)):
                        torques.publish(data=[chance.uniform(-2, 2) for _ in range(chance.choice([3, 3, 3, 2]))])
                        torque.publish(joint=chance.choice(['first_joint', 'third_joint', 'elbow']),
                                       torque=chance.uniform(-3, 3), duration=chance.choice([0, 0.0373, 0.2]),
                                       start=states.messages[-1].header.stamp + rospy.Duration(chance.choice([0.05, 0.1])))
                        force.publish(link='third', point=Point(chance.uniform(0, 1), 0, 0),
                                      force=Vector3(chance.uniform(-5, 5), 1, 0),
                                      moment=chance.uniform(-1, 1), duration=chance.choice([0, 0.0123]))
                    states.wait_for_count(len(states.messages) + chance.randint(1, 12))
                    between(i, states)
                last = statuses.wait_for(lambda status: status.link_force_age > 0.5)
        self.assertGreater(statuses.messages[last].rejected_commands, 0)
        states.close()
        statuses.close()

    def replay(self, scene):
        with open(self.path('scene.yaml'), 'w') as file:
            yaml.safe_dump(scene, file)
        recorded = states_in(self.path('node.bag'))
        simulate = roslib.packages.find_node('planar_chain', 'simulate')[0]
        said = subprocess.run(
            [simulate, self.path('scene.yaml'), '--commands', self.path('node.bag'), '--bag', self.path('again.bag')],
            check=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True, timeout=LIMIT).stdout
        self.assertNotIn('another scene', said)
        return recorded, states_in(self.path('again.bag')), said

    def check(self, scene, between=lambda i, states: None):
        self.record(scene, between)
        recorded, again, said = self.replay(scene)
        with rosbag.Bag(self.path('node.bag')) as bag:
            count = bag.get_message_count('/planar_chain/commands_taken')
        self.assertGreater(count, 100)
        self.assertIn('commands of /planar_chain: %d taken\n' % count, said)
        self.assertGreater(len(recorded), 200)
        for tick in sorted(set(recorded) - {0}):
            self.assertEqual(again[tick], recorded[tick], 'tick %d' % tick)
        if 'sensors' in scene:
            measured, again = measurements_in(self.path('node.bag')), measurements_in(self.path('again.bag'))
            # Where the replay ends, less the delay: rosbag may have got a later measurement than the last state.
            last = 2 * max(recorded) - math.ceil(400 * scene['sensors']['encoders']['delay'])
            kept = {key: values for key, values in measured.items() if 0 < key[1] <= last}
            self.assertGreater(len(kept), 400)
            self.assertEqual({topic for topic, _ in kept}, {'/planar_chain/encoders', '/planar_chain/imu'})
            self.assertEqual({key: again.get(key) for key in kept}, kept)
        return recorded

    def test_commands_by_the_wall_clock(self):
        self.check(SCENE)

    def test_commands_to_motors(self):
        motor = {'effort_limit': 1.5, 'motor': {'no_load_speed': 6.0, 'time_constant': 0.02}, 'command_delay': 0.0123}
        self.check(dict(SCENE, links={name: dict(LINK, joint=motor) for name in SCENE['links']}))

    def test_trajectories(self):
        links = dict(SCENE['links'], second=dict(LINK, joint={'drive': {'amplitude': 0.3, 'frequency': 0.4}}))
        scene = {key: value for key, value in dict(SCENE, links=links).items() if key != 'loads'}
        chance = random.Random(2)
        out = None

        def between(_, states):
            nonlocal out
            out = out or publisher('/planar_chain/joint_trajectory', JointTrajectory)
            message = JointTrajectory(joint_names=['second_joint'])
            if chance.random() < 0.3:
                message.header.stamp = states.messages[-1].header.stamp + rospy.Duration(chance.uniform(-0.05, 0.2))
            for i in range(chance.randint(1, 3)):
                message.points.append(JointTrajectoryPoint(
                    positions=[chance.uniform(-1, 1)], velocities=[0.0] if chance.random() < 0.5 else [],
                    time_from_start=rospy.Duration(0.1 + 0.0737 * i)))
            out.publish(message)

        self.check(scene, between)

    def test_motions_of_the_base(self):
        chance = random.Random(3)
        out = None

        def between(i, _):
            nonlocal out
            out = out or publisher('/planar_chain/base_trajectory', MultiDOFJointTrajectory)
            x, y, angle = (chance.uniform(-0.5, 0.5) for _ in range(3))
            if i % 3 == 0:
                out.publish(base_trajectory(base_point(0.1, x, y, angle), base_point(0.2737, 0.0, 0.0, 0.0)))
            elif i % 3 == 1:
                step = rospy.ServiceProxy('/planar_chain/step', Step)
                for n in (1, chance.randint(2, 9)):
                    moved = step(n=n, base_pose=[Pose2D(0.01 * x, 0.01 * y, 0.01 * angle)],
                                 base_twist=[Twist(Vector3(x, y, 0), Vector3(0, 0, angle))])
                    self.assertTrue(moved.success, moved.message)
                self.assertTrue(rospy.ServiceProxy('/planar_chain/resume', Trigger)().success)
            elif i == 14:
                self.assertTrue(rospy.ServiceProxy('/planar_chain/reset', Trigger)().success)

        self.check(dict(SCENE, base={'x': {'amplitude': 0.1, 'frequency': 1.0}}, real_time_factor=1.0), between)
        with rosbag.Bag(self.path('node.bag')) as bag:
            taken = [command for _, command, _ in bag.read_messages('/planar_chain/commands_taken')]
        self.assertEqual(sum(bool(command.base_pose) for command in taken), 20)
        self.assertEqual(sum(bool(command.base_trajectory) for command in taken), 10)

    def test_a_tolerance_that_yields(self):
        # 300 links whipped about: at 1e-13 a tick takes far longer than 5 ms, at 1e-2 it does not.
        link = dict(LINK, repeat=300, initial={'angle': 0.02, 'velocity': 0.1})
        scene = {'chain': ['link'], 'links': {'link': link}, 'publish': {'rate': RATE, 'status_rate': 20.0},
                 'integrator': {'tolerance': 1e-13, 'loosest_tolerance': 1e-2}}
        statuses = Listener('/planar_chain/status', SimStatus)
        states = Listener('/joint_states', JointState)
        with Node(scene, arguments=['--wait-for-recorder']):
            with Running('rosbag', 'record', '-q', '-O', self.path('node.bag'), *TOPICS, '/tf', '/planar_chain/link_states'):
                statuses.wait_for(lambda status: status.tolerance > 1e-13)
                states.wait_for_count(len(states.messages) + 200)
        states.close()
        statuses.close()
        with rosbag.Bag(self.path('node.bag')) as bag:
            taken = [command for _, command, _ in bag.read_messages('/planar_chain/commands_taken')]
        self.assertGreater(len(taken), 0)
        self.assertEqual({command.kind for command in taken}, {CommandTaken.TOLERANCE})
        recorded, again, _ = self.replay(scene)
        for tick in sorted(set(recorded) - {0}):
            self.assertEqual(again[tick], recorded[tick], 'tick %d' % tick)

    def test_a_node_waits_for_its_recorder(self):
        statuses = Listener('/planar_chain/status', SimStatus)
        states = Listener('/joint_states', JointState)
        early = rospy.Publisher('/planar_chain/joint_torques', Float64MultiArray, latch=True, queue_size=1)
        early.publish(data=[1.0, 2.0, 3.0])
        with Node(SCENE, arguments=['--wait-for-recorder']) as node:
            statuses.wait_for_count(20)
            self.assertEqual({status.standstill for status in statuses.messages}, {'waiting for the recorder'})
            self.assertEqual(states.messages, [])
            with Running('rosbag', 'record', '-q', '-O', self.path('node.bag'), *TOPICS, '/tf', '/planar_chain/link_states'):
                states.wait_for_count(200)
        early.unregister()
        states.close()
        statuses.close()
        self.assertEqual(node.wait()[0], 0)
        with rosbag.Bag(self.path('node.bag')) as bag:
            taken = [(command.number, command.joint_torques)
                     for _, command, _ in bag.read_messages('/planar_chain/commands_taken')]
        self.assertEqual(taken, [(1, (1.0, 2.0, 3.0))])
        recorded, again, _ = self.replay(SCENE)
        for tick in sorted(set(recorded) - {0}):
            self.assertEqual(again[tick], recorded[tick], 'tick %d' % tick)

    def test_a_recording_in_which_the_scene_changed_is_refused(self):
        states = Listener('/joint_states', JointState)
        with Node(SCENE, arguments=['--wait-for-recorder']):
            with Running('rosbag', 'record', '-q', '-O', self.path('node.bag'), *TOPICS, '/tf', '/planar_chain/link_states'):
                states.wait_for_count(1)
                rospy.set_param('/planar_chain/links/first/mass', 2.0)
                self.assertTrue(rospy.ServiceProxy('/planar_chain/reset', Trigger)().success)
                states.wait_for_count(len(states.messages) + 200)
        states.close()
        with self.assertRaises(subprocess.CalledProcessError) as refused:
            self.replay(SCENE)
        self.assertEqual(refused.exception.returncode, 2)

    def test_steps_new_states_and_resets_by_the_nodes_own_clock(self):
        def call(name, service, **request):
            response = rospy.ServiceProxy('/planar_chain/' + name, service)(**request)
            self.assertTrue(response.success, response.message)

        def between(i, states):
            if i % 7 == 1:
                call('step', Step, torques=[0.5, 0.1 * i, 0.0], n=5)
                call('step', Step, n=3)
                call('resume', Trigger)
            elif i == 5:
                call('set_state', SetState, q=[0.3, -0.2, 0.1], qd=[0.0, 1.0, 0.0])
            elif i == 11:
                call('clear_commands', Trigger)
            elif i == 13:
                call('reset', Trigger)
            elif i == 14:
                call('pause', Trigger)
                call('reset', Trigger)
                call('step', Step, n=2)
                call('resume', Trigger)
            elif i in (16, 20):
                call('settle', Trigger)
            elif i == 18:
                call('pause', Trigger)
                call('settle', Trigger)
                call('resume', Trigger)

        recorded = self.check(dict(SCENE, real_time_factor=1.0), between)
        first = ((0.0,) * 3, (0.0,) * 3)
        self.assertGreaterEqual([state[:2] for state in recorded.values()].count(first), 1)

    def test_states_that_clear_a_fault(self):
        # A parallelogram, which stops where it rests in its change point, straight.
        def at(angle):
            return [angle, -angle, angle - math.pi]

        def link(length, inertia):
            return {'mass': 1.0, 'inertia': inertia, 'com': [length / 2, 0.0], 'pin': [length, 0.0]}

        links = {'a': link(0.5, 0.02), 'b': link(1.0, 0.08), 'c': link(0.5, 0.02)}
        for name, angle in zip('abc', at(-1.2)):
            links[name]['initial'] = {'angle': angle}
        links['c']['mass'] = 2.0  # equal cranks would fall together
        scene = {'chain': ['a', 'b', 'c'], 'links': links, 'tip': {'pin': [1.0, 0.0]}, 'real_time_factor': 1.0,
                 'publish': {'rate': 200.0, 'status_rate': 50.0}}
        failing = {'q': at(0.0), 'qd': [0.0] * 3}
        calls = {name: rospy.ServiceProxy('/planar_chain/' + name, service) for name, service in [
            ('set_state', SetState), ('settle', Trigger), ('clear_commands', Trigger), ('reset', Trigger)]}
        states, statuses = Listener('/joint_states', JointState), Listener('/planar_chain/status', SimStatus)
        with Node(scene, arguments=['--wait-for-recorder']):
            with Running('rosbag', 'record', '-q', '-O', self.path('node.bag'), *TOPICS, '/tf', '/planar_chain/link_states',
                         '/planar_chain/tip_wrench', '/planar_chain/e'):
                states.wait_for_count(20)
                for cures in (['settle'], ['clear_commands', 'settle'], ['clear_commands', 'set_state'], ['reset']):
                    self.assertTrue(calls['set_state'](**failing).success)
                    statuses.wait_for(lambda status: status.fault, len(statuses.messages))
                    for cure in cures:
                        asked = {'q': at(-1.9), 'qd': [0.0] * 3} if cure == 'set_state' else {}
                        self.assertTrue(calls[cure](**asked).success)
                    statuses.wait_for(lambda status: not status.fault, len(statuses.messages))
                    states.wait_for_count(len(states.messages) + 50)
        states.close()
        statuses.close()
        recorded, again, said = self.replay(scene)
        self.assertIn('10 taken', said)
        self.assertNotIn('refused', said)
        for tick in sorted(set(recorded) - {0}):
            self.assertEqual(again[tick], recorded[tick], 'tick %d' % tick)


if __name__ == '__main__':
    rospy.init_node('ros_commands_replay', anonymous=True)
    rostest.rosrun('planar_chain', 'ros_commands_replay', CommandsReplay)
