#!/usr/bin/python3
"""The node of a machine: rest, the wrench on the base, effort limits, driven joints."""

import math

import rospy
import rostest
from geometry_msgs.msg import Quaternion, Transform, Twist, Vector3, WrenchStamped
from planar_chain.msg import JointTorque, LinkStates
from planar_chain.srv import SetState, Step
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import Trigger
from trajectory_msgs.msg import (JointTrajectory, JointTrajectoryPoint, MultiDOFJointTrajectory,
                                 MultiDOFJointTrajectoryPoint)

from ros_node import Listener, Node, ROD_INERTIA, Watching, nanoseconds, publisher, rod, service

LINK = {'mass': 2.0, 'inertia': 0.3, 'com': [0.4, 0.0], 'pin': [1.0, 0.0]}


def link(joint=(), **more):
    return dict(LINK, joint=dict(joint), **more)


def machine(links, **more):
    return rod(**dict({'chain': sorted(links), 'links': links}, **more))


def point(time, positions, velocities=(), accelerations=()):
    return JointTrajectoryPoint(positions, velocities, accelerations, [], rospy.Duration.from_sec(time))


def trajectory(joints, *points, **header):
    message = JointTrajectory(joint_names=joints, points=list(points))
    message.header.stamp = header.get('stamp', rospy.Time())
    return message


def base_point(time, x, y, angle, twist=None):
    place = Transform(Vector3(x, y, 0), Quaternion(0, 0, math.sin(angle / 2), math.cos(angle / 2)))
    return MultiDOFJointTrajectoryPoint([place], [twist] if twist else [], [], rospy.Duration.from_sec(time))


def base_trajectory(*points, names=('base',)):
    return MultiDOFJointTrajectory(joint_names=list(names), points=list(points))


def cubic(u, x0, v0, x1, v1):
    """Hermite's, over 1 s."""
    return ((2 * u ** 3 - 3 * u ** 2 + 1) * x0 + (u ** 3 - 2 * u ** 2 + u) * v0 +
            (3 * u ** 2 - 2 * u ** 3) * x1 + (u ** 3 - u ** 2) * v1)


def quintic(u, x0, v0, a0, x1, v1, a1):
    return ((1 - 10 * u ** 3 + 15 * u ** 4 - 6 * u ** 5) * x0 + (u - 6 * u ** 3 + 8 * u ** 4 - 3 * u ** 5) * v0 +
            (u ** 2 - 3 * u ** 3 + 3 * u ** 4 - u ** 5) / 2 * a0 + (10 * u ** 3 - 15 * u ** 4 + 6 * u ** 5) * x1 +
            (7 * u ** 4 - 4 * u ** 3 - 3 * u ** 5) * v1 + (u ** 3 - 2 * u ** 4 + u ** 5) / 2 * a1)


class Machines(Watching):
    def next_status(self, holds=lambda status: True):
        return self.statuses.messages[self.statuses.wait_for(holds, len(self.statuses.messages) + 1)]

    def ask(self, name, success=True):
        answer = service(name, Trigger)()
        self.assertEqual(answer.success, success, answer.message)
        return answer.message

    # ---- Rest ------------------------------------------------------------------------------------

    def test_settle_puts_the_chain_at_rest_and_shows_it_once(self):
        with Node(rod(gravity=[0.0, -9.81])):
            self.states.wait_for_count(20)
            self.ask('pause')
            still = self.next_status(lambda status: status.paused)
            self.next_status()  # and what is under way has come
            seen = len(self.states.messages)
            self.assertIn('equilibrium', self.ask('settle'))
            self.states.wait_for_count(seen + 1)
            settled = self.states.messages[seen]
            self.assertAlmostEqual(settled.position[0], -math.pi / 2, delta=1e-12)
            self.assertEqual(settled.velocity, (0.0,))
            after = self.next_status(lambda status: status.tick == still.tick + 1)
            self.assertEqual(after.scene_time, still.scene_time)
            self.next_status()
            self.assertEqual(len(self.states.messages), seen + 1)
            # It stays there. Before it has been shown, a step shows it as the tick before.
            self.ask('settle')
            step = service('step', Step)
            for state in step(n=100).states:
                self.assertAlmostEqual(state.position[0], -math.pi / 2, delta=1e-12)
            self.ask('resume')
            self.states.wait_for_count(len(self.states.messages) + 20)
        stamps = list(map(nanoseconds, self.states.messages))
        self.assertTrue(all(later > sooner for sooner, later in zip(stamps, stamps[1:])))

    def test_settle_where_there_is_no_rest_changes_nothing(self):
        with Node(rod(loads={'motor': {'joint': 'rod_joint', 'torque': 1.0}})):
            self.states.wait_for_count(20)
            self.ask('pause')
            step = service('step', Step)
            before = step(n=1).states[0]
            self.assertGreater(len(self.ask('settle', success=False)), 20)
            after = step(n=1).states[0]
            self.assertAlmostEqual(after.velocity[0] - before.velocity[0], 0.005 / ROD_INERTIA, delta=1e-12)
            self.assertGreater(after.position[0], before.position[0])

    # ---- The base ----------------------------------------------------------------------------------

    def test_the_wrench_is_what_the_chain_does_to_the_base(self):
        scene = machine({'a': link({'rotor_inertia': 0.5}), 'b': link()}, gravity=[0.0, -9.81],
                        base={'x': {'amplitude': 0.1, 'frequency': 2.0}})
        with Node(scene):
            self.ask('pause')
            wrenches = Listener('/planar_chain/base_wrench', WrenchStamped)
            links = Listener('/planar_chain/link_states', LinkStates)
            self.addCleanup(wrenches.close)
            self.addCleanup(links.close)
            wrenches.wait_for_publisher()
            links.wait_for_publisher()
            self.ask('resume')
            wrenches.wait_for_count(100)
            links.wait_for(lambda message: nanoseconds(message) >= nanoseconds(wrenches.messages[99]))
            self.states.wait_for(lambda message: nanoseconds(message) >= nanoseconds(wrenches.messages[99]))
        efforts = {nanoseconds(state): state.effort for state in self.states.messages}
        motions = {nanoseconds(message): message for message in links.messages}
        for message in wrenches.messages[10:100]:
            self.assertEqual(message.header.frame_id, 'base_link')
            wrench, motion = message.wrench, motions[nanoseconds(message)]
            # Newton: what the base does to the chain moves the chain's mass against gravity.
            for mine, part, weight in ((wrench.force.x, 'x', 0.0), (wrench.force.y, 'y', 4 * 9.81)):
                push = sum(2.0 * getattr(entry.linear, part) for entry in motion.acceleration) + weight
                self.assertAlmostEqual(mine, -push, delta=1e-9)
            turned = 0.5 * motion.acceleration[0].angular.z
            self.assertAlmostEqual(wrench.torque.z, turned - efforts[nanoseconds(message)][0], delta=1e-9)
            self.assertEqual((wrench.force.z, wrench.torque.x, wrench.torque.y), (0, 0, 0))

    def test_the_tip_is_held_by_what_the_pin_does_not_carry(self):
        scene = machine({name: link() for name in 'abc'}, gravity=[0.0, -9.81], tip={'pin': [1.5, 0.3]})
        wrenches, links = (Listener('/planar_chain/' + name, kind)
                           for name, kind in (('tip_wrench', WrenchStamped), ('link_states', LinkStates)))
        self.addCleanup(wrenches.close)
        self.addCleanup(links.close)
        with Node(scene):
            self.ask('pause')
            wrenches.wait_for_publisher()
            links.wait_for_publisher()
            answer = service('step', Step)(n=40)
            stamps = [nanoseconds(state) for state in answer.states]
            wrenches.wait_for(lambda message: nanoseconds(message) == stamps[-1])
            links.wait_for(lambda message: nanoseconds(message) == stamps[-1])
        motions = {nanoseconds(message): message for message in links.messages}
        found = {nanoseconds(message): message for message in wrenches.messages}
        self.assertEqual([(nanoseconds(wrench), wrench.wrench) for wrench in answer.tip_wrenches],
                         [(stamp, found[stamp].wrench) for stamp in stamps])
        self.assertEqual(answer.base_wrenches, [])
        for stamp in stamps:
            force, motion = found[stamp].wrench.force, motions[stamp]
            # Newton: both ends move the chain's mass against gravity.
            for mine, part, weight in ((force.x, 'x', 0.0), (force.y, 'y', 6 * 9.81)):
                both = sum(2.0 * getattr(entry.linear, part) for entry in motion.acceleration) + weight
                self.assertAlmostEqual(mine + getattr(motion.pin_force[0], part), both, delta=1e-9)

    # ---- Torques -----------------------------------------------------------------------------------

    def test_torques_beyond_the_limit_are_cut_off_counted_and_named(self):
        scene = machine({'a': link({'effort_limit': 0.5}), 'b': link({'effort_limit': 3.0, 'name': 'elbow'})})
        with Node(scene):
            torques = publisher('/planar_chain/joint_torques', Float64MultiArray)
            torques.publish(data=[0.5, 2.0])
            self.states.wait_for(lambda state: state.effort == (0.5, 2.0))
            status = self.next_status()
            self.assertEqual((status.torques_cut_off, status.joints_cut_off), (0, []))
            torques.publish(data=[0.4, -7.0])
            self.states.wait_for(lambda state: state.effort == (0.4, -3.0))
            status = self.next_status()
            self.assertEqual((status.torques_cut_off, status.joints_cut_off), (1, ['elbow']))
            publisher('/planar_chain/joint_torque', JointTorque).publish(joint='a_joint', torque=0.2, duration=0.1)
            status = self.next_status(lambda status: status.torques_cut_off == 2)
            self.assertEqual(status.joints_cut_off, ['a_joint', 'elbow'])
            torques.publish(data=[0.4, 7.0])  # from one side to the other
            self.states.wait_for(lambda state: state.effort == (0.4, 3.0))
            self.next_status(lambda status: status.torques_cut_off == 3)
            self.ask('reset')
            status = self.next_status()
            self.assertEqual((status.torques_cut_off, status.joints_cut_off), (0, []))

    def test_rates_beyond_the_limit_are_counted_and_named(self):
        scene = machine({'a': link({'velocity_limit': 9.0}), 'b': link({'velocity_limit': 1.0, 'name': 'elbow'})})
        with Node(scene):
            self.ask('pause')
            self.ask('reset')
            set_state, step = service('set_state', SetState), service('step', Step)
            for rate in (0.9, 1.1, 1.2, 0.0, -1.1):
                set_state([0.0, 0.0], [0.0, rate])
                step(n=1)
            status = self.next_status()
            self.assertEqual((status.velocities_exceeded, status.joints_too_fast), (2, ['elbow']))
            self.ask('reset')
            status = self.next_status()
            self.assertEqual((status.velocities_exceeded, status.joints_too_fast), (0, []))

    def test_a_torque_in_a_driven_joint_is_refused(self):
        with Node(machine({'a': link(), 'b': link({'drive': {'amplitude': 0.2, 'frequency': 1.0}})})):
            torques = publisher('/planar_chain/joint_torques', Float64MultiArray)
            torques.publish(data=[0.3, 1.5])
            status = self.next_status(lambda status: status.rejected_commands == 1)
            self.assertIn('joint_torques/data[1]: expected 0 N m in a driven joint, got 1.5', status.last_rejection)
            publisher('/planar_chain/joint_torque', JointTorque).publish(joint='b_joint', torque=1.0)
            status = self.next_status(lambda status: status.rejected_commands == 2)
            self.assertIn('joint_torque/joint: expected a joint that is not driven, got "b_joint"',
                          status.last_rejection)
            self.assertEqual({state.effort[0] for state in self.states.messages}, {0.0})
            torques.publish(data=[0.3, 0.0])
            self.states.wait_for(lambda state: state.effort[0] == 0.3)

    # ---- Trajectories ------------------------------------------------------------------------------

    def paused(self):
        """Pauses a node at its initial state. Returns a publisher of trajectories, and step(n), which gives the
        states."""
        self.ask('pause')
        self.ask('reset')
        step = service('step', Step)
        out = publisher('/planar_chain/joint_trajectory', JointTrajectory)
        return out, lambda n: step(n=n).states

    def send(self, out, message):
        out.publish(message)
        status = self.next_status(lambda status: status.joint_trajectory_age == 0 or status.rejected_commands > 0)
        self.assertEqual(status.rejected_commands, 0, status.last_rejection)

    def assert_follows(self, states, joint, law):
        for k, state in enumerate(states, 1):
            self.assertAlmostEqual(state.position[joint], law(k * 0.005), delta=1e-9)

    def arm(self):
        """A swinging shoulder, a free elbow, a hand that is held."""
        return machine({'a': link({'drive': {'amplitude': 0.2, 'frequency': 0.5}}), 'b': link(),
                        'c': link({'drive': {'times': [0.0, 1.0], 'values': [0.5, 0.5]}})}, gravity=[0.0, -9.81])

    def test_points_with_rates_are_met_by_cubics_and_quintics(self):
        with Node(self.arm()):
            out, step = self.paused()
            begin = step(60)[-1]
            time = self.next_status(lambda status: status.tick_stamp == begin.header.stamp).scene_time
            swing = -0.2 * math.pi ** 2 * math.sin(math.pi * time)  # the shoulder's acceleration
            (x, v), (y, w) = [(begin.position[i], begin.velocity[i]) for i in (0, 2)]
            self.send(out, trajectory(['c_joint', 'a_joint'],
                                      point(1.0, [1.0, -0.3], [0.4, 0.2], [-0.5, 0.7]),
                                      point(2.0, [0.6, 0.1], [0.0, 0.0])))
            first, second, after = step(200), step(200), step(20)
            self.assert_follows(first, 0, lambda u: quintic(u, x, v, swing, -0.3, 0.2, 0.7))
            self.assert_follows(first, 2, lambda u: quintic(u, y, w, 0.0, 1.0, 0.4, -0.5))
            self.assert_follows(second, 0, lambda u: cubic(u, -0.3, 0.2, 0.1, 0.0))
            self.assert_follows(second, 2, lambda u: cubic(u, 1.0, 0.4, 0.6, 0.0))
            for state in after:
                self.assertEqual((state.position[0], state.velocity[0], state.position[2], state.velocity[2]),
                                 (0.1, 0.0, 0.6, 0.0))
            status = self.next_status(lambda status: status.tick_stamp == after[-1].header.stamp)
            self.assertGreater(abs(status.work_supplied), 1.0)
            self.assertLess(abs(status.energy_balance), 1e-6)
            # A reset leads back to the scene's own laws, and to the first motion.
            self.ask('reset')
            again = step(60)[-1]
            self.assertEqual((again.position, again.velocity), (begin.position, begin.velocity))

    def test_points_without_rates_lie_on_lines_without_jumps(self):
        with Node(self.arm()):
            out, step = self.paused()
            begin = step(60)[-1].position[0]
            self.send(out, trajectory(['a_joint'], point(0.0, [9.0]), point(0.5, [0.4]), point(1.0, [0.0])))
            states = step(220)
            for k in range(4, 100):
                self.assertAlmostEqual(states[k - 1].position[0], begin + (0.4 - begin) * k / 100, delta=1e-12)
            self.assertAlmostEqual(states[99].position[0], 0.4, delta=1e-12)
            for k in range(104, 197):
                self.assertAlmostEqual(states[k - 1].velocity[0], -0.8, delta=1e-12)
            for state in states[199:]:
                self.assertAlmostEqual(state.position[0], 0.0, delta=1e-12)
                self.assertAlmostEqual(state.velocity[0], 0.0, delta=1e-12)
            status = self.next_status(lambda status: status.tick_stamp == states[-1].header.stamp)
            self.assertLess(abs(status.energy_balance), 1e-6)

    def test_a_later_start_lets_the_law_before_go_on(self):
        with Node(self.arm()):
            out, step = self.paused()
            begin = step(60)[-1]
            time = self.next_status(lambda status: status.tick_stamp == begin.header.stamp).scene_time
            start = begin.header.stamp + rospy.Duration(0.25)
            self.send(out, trajectory(['a_joint'], point(1.0, [0.0], [0.0]), stamp=start))
            before, after = step(50), step(200)
            self.assert_follows(before, 0, lambda s: 0.2 * math.sin(math.pi * (time + s)))
            x, v = before[-1].position[0], before[-1].velocity[0]
            self.assert_follows(after, 0, lambda u: cubic(u, x, v, 0.0, 0.0))
            # One that began before: its first point is over.
            start = after[-1].header.stamp - rospy.Duration(1.0)
            self.send(out, trajectory(['a_joint'], point(0.5, [7.0], [0.0]), point(2.0, [0.3], [0.0]), stamp=start))
            self.assert_follows(step(200), 0, lambda u: cubic(u, 0.0, 0.0, 0.3, 0.0))

    def test_a_wrong_trajectory_changes_nothing_and_says_all_that_is_wrong(self):
        nan = float('nan')
        good = point(1.0, [0.1], [0.0])
        wrong = [
            (trajectory(['a_joint']), ['points: expected at least one point, got nothing']),
            (trajectory([], point(1.0, [])), ['joint_names: expected at least one driven joint']),
            (trajectory(['elbow'], good), ['joint_names[0]: expected a driven joint of the chain (a_joint, c_joint), got "elbow"']),
            (trajectory(['b_joint'], good), ['joint_names[0]: expected a driven joint of the chain (a_joint, c_joint), got "b_joint"']),
            (trajectory(['a_joint', 'a_joint'], point(1.0, [0, 0])), ['joint_names[1]: expected each joint once']),
            (trajectory(['a_joint'], good, good), ['points[1]/time_from_start: expected a time after the point before']),
            (trajectory(['a_joint'], point(-1.0, [0.0])), ['points[0]/time_from_start: expected a time >= 0 s, got -1']),
            (trajectory(['a_joint'], point(0.0, [0.0])), ['points: expected a point later than now']),
            (trajectory(['a_joint'], point(1.0, [0.1, 0.2], [], [1.0, 2.0])),
             ['points[0]/positions: expected 1 positions', 'points[0]/accelerations: expected 1 accelerations']),
            (trajectory(['a_joint', 'c_joint'], point(1.0, [nan, 0.0], [0.0]), point(1.0, [0, 0], [0, 1])),
             ['points[0]/positions[0]: expected a finite number, rad, got nan', 'points[0]/velocities: expected 2',
              'points[1]/time_from_start', 'points[1]/velocities: expected 0 in the last point']),
            (trajectory(['a_joint'], point(1e-9, [5.5])), ['points: expected values up to 1e9 rad, rates up to 1e15 rad/s']),
            (trajectory(['a_joint'], good, stamp=rospy.Time(4e9)), ['header/stamp: expected 0 for now']),
        ]
        with Node(self.arm()):
            out, step = self.paused()
            begin = step(60)[-1]
            time = self.next_status(lambda status: status.tick_stamp == begin.header.stamp).scene_time
            for count, (message, faults) in enumerate(wrong, 1):
                out.publish(message)
                status = self.next_status(lambda status: status.rejected_commands >= count)
                for fault in faults:
                    self.assertIn('joint_trajectory/' + fault, status.last_rejection)
            self.assertEqual(status.joint_trajectory_age, -1)
            states = step(50)
            self.assert_follows(states, 0, lambda s: 0.2 * math.sin(math.pi * (time + s)))
            self.assertEqual({state.position[2] for state in states}, {0.5})

    def test_the_base_follows_a_trajectory(self):
        links = Listener('/planar_chain/link_states', LinkStates)
        self.addCleanup(links.close)
        base = {'x': {'amplitude': 0.1, 'frequency': 0.5}, 'angle': {'times': [0.0, 1.0], 'values': [-0.2, -0.2]}}
        with Node(rod(base=base, gravity=[0.0, -9.81])):
            _, step = self.paused()
            out = publisher('/planar_chain/base_trajectory', MultiDOFJointTrajectory)
            links.wait_for_publisher()
            begin = step(60)[-1]
            rest = Twist(Vector3(0, 0, 0), Vector3(0, 0, 0))
            out.publish(base_trajectory(base_point(1.0, 0.4, -0.3, 2.5, Twist(Vector3(0.2, 0, 0), Vector3(0, 0, 0.5))),
                                        base_point(2.0, 0.0, 0.0, -3.0, rest)))
            status = self.next_status(lambda status: status.base_trajectory_age == 0 or status.rejected_commands > 0)
            self.assertEqual(status.rejected_commands, 0, status.last_rejection)
            time = status.scene_time
            x, v = 0.1 * math.sin(math.pi * time), 0.1 * math.pi * math.cos(math.pi * time)
            # In two parts: the node keeps 400 messages for a slow subscriber.
            states = step(205)
            first = links.wait_for(lambda message: message.header.stamp == states[0].header.stamp)
            links.wait_for_count(first + 205)
            states += step(205)
            links.wait_for_count(first + 410)
            for k, (state, motion) in enumerate(zip(states, links.messages[first:]), 1):
                u = k * 0.005
                # 2.5 rad and on to -3 rad + a turn
                expected = (cubic(u, x, v, 0.4, 0.2), cubic(u, 0, 0, -0.3, 0), cubic(u, -0.2, 0, 2.5, 0.5)) if u <= 1 else (
                    cubic(u - 1, 0.4, 0.2, 0, 0), cubic(u - 1, -0.3, 0, 0, 0), cubic(u - 1, 2.5, 0.5, 2 * math.pi - 3, 0))
                if u > 2:
                    expected = (0, 0, 2 * math.pi - 3)
                pose = motion.pose[0]
                found = (pose.x - 0.4 * math.cos(pose.theta), pose.y - 0.4 * math.sin(pose.theta),
                         pose.theta - state.position[0])
                for one, other in zip(found, expected):
                    self.assertAlmostEqual(one, other, delta=1e-9)
            status = self.next_status(lambda status: status.tick_stamp == states[-1].header.stamp)
            self.assertGreater(abs(status.work_supplied), 0.1)
            self.assertLess(abs(status.energy_balance), 1e-6)
            self.ask('reset')
            self.assertEqual(step(60)[-1].position, begin.position)

            tilted, high = base_point(1.0, 0, 0, 0), base_point(1.0, 0, 0, 0)
            tilted.transforms[0].rotation.x = 0.5
            high.transforms[0].translation.z = 1.0
            for count, (message, fault) in enumerate((
                    (base_trajectory(names=('world',)), 'joint_names: expected one name, base, got "world"'),
                    (base_trajectory(), 'points: expected at least one point'),
                    (base_trajectory(tilted), 'points[0]/transforms[0]/rotation: expected a unit quaternion about z'),
                    (base_trajectory(high), 'points[0]/transforms[0]/translation/z: expected 0'),
                    (base_trajectory(base_point(1e-9, 5.5, 0, 0)), 'points: expected values up to 1e9 m, rates up to 1e15'),
                    (base_trajectory(MultiDOFJointTrajectoryPoint(time_from_start=rospy.Duration(1))),
                     'points[0]/transforms: expected one, of the base, got 0')), 1):
                out.publish(message)
                status = self.next_status(lambda status: status.rejected_commands >= count)
                self.assertIn('base_trajectory/' + fault, status.last_rejection)
        with Node(rod()):
            publisher('/planar_chain/base_trajectory', MultiDOFJointTrajectory).publish(base_trajectory())
            status = self.next_status(lambda status: status.rejected_commands == 1)
            self.assertIn('a scene whose base moves', status.last_rejection)


if __name__ == '__main__':
    rospy.init_node('ros_machines', anonymous=True)
    rostest.rosrun('planar_chain', 'ros_machines', Machines)
