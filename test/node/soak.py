#!/usr/bin/python3
"""A node for a long time at 1000 Hz, under random commands from four sources and every service.

    soak.py SECONDS [--node PROGRAM] [--sanitized]

What must hold all the time: each message is stamped a whole number of ticks, one after the one before (/tf ten),
through pauses, steps and resets; every number is finite; sim time keeps up with the wall; the energy balance closes;
memory is flat; nothing is refused, warned of or failed; the node ends with status 0. Ends with status 1 as soon as
something does not. Starts a master of its own.

--sanitized: of a program under the sanitizers, which may be too slow: what it is behind must be told, and nothing be
lost. Its memory is shown, but is the sanitizers' too; leaks are theirs to find, at the end.
"""

import argparse
import math
import os
import random
import statistics
import struct
import sys
import threading
import time

import rospy
from geometry_msgs.msg import Point, Vector3
from planar_chain.msg import JointTorque, LinkForce, LinkStates, SimStatus
from planar_chain.srv import Equations, Linearize, SetState, Step
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

from bag_load import cpu_seconds, faults_in
from ros_faults import numbers, resident_bytes
from ros_node import Listener, Node, publisher, service

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), '../support'))
from own_master import Master  # noqa: E402

RATE, TF_RATE = 1000, 100
LINKS = ['first', 'second', 'third', 'fourth']
TOLERANCE = 1e-8
JOINT = {'stiffness': 4.0, 'damping': 0.2, 'lower': -2.5, 'upper': 2.5, 'stop_stiffness': 500.0, 'stop_damping': 1.0}
SCENE = {
    'chain': LINKS,
    'links': {name: {'mass': 0.5, 'inertia': 0.01, 'com': [0.15, 0.01], 'pin': [0.3, 0.0], 'joint': dict(JOINT)}
              for name in LINKS},
    'loads': {'shake': {'joint': 'first_joint', 'torque': 1.0, 'frequency': 0.7}},
    'integrator': {'tolerance': TOLERANCE},
    'publish': {'rate': RATE, 'tf_rate': TF_RATE, 'status_rate': 10},
    'real_time_factor': 1,
}
PATIENCE = 1.0  # s that a node may be behind before it gives time up
MOST_GROWTH = 1e6  # bytes; in an hour a third of a byte a tick


class Stream:
    """The stamps of a topic as they come; every so many messages the numbers are looked at, too."""

    def __init__(self, topic, message_type, rate, stamp_at, every):
        self.topic, self.rate, self.count = topic, rate, 0
        self._type, self._stamp_at, self._every = message_type, stamp_at, every
        self._stamps, self._faults, self._last = [], [], None
        self._subscriber = rospy.Subscriber(topic, rospy.AnyMsg, self._take)

    def _take(self, message):
        buffer = message._buff  # pylint: disable=protected-access
        seconds, nanoseconds = struct.unpack_from('<II', buffer, self._stamp_at)
        self._stamps.append(seconds * 10 ** 9 + nanoseconds)
        self.count += 1
        if self.count % self._every == 0:
            whole = self._type()
            whole.deserialize(buffer)
            if not all(map(math.isfinite, numbers(whole))):
                self._faults.append('%s: not finite:\n%s' % (self.topic, whole))

    def faults(self):
        """The faults since the last call."""
        stamps, self._stamps = self._stamps, []
        faults, self._faults = self._faults, []
        uneven = [stamp for stamp in stamps if stamp % (10 ** 9 // RATE)]
        if uneven:
            faults.append('%s: stamped %d ns, between two ticks' % (self.topic, uneven[0]))
        if stamps:
            faults += faults_in([self._last or stamps[0] - 10 ** 9 // self.rate] + stamps, self.rate, self.topic)
            self._last = stamps[-1]
        return faults

    def close(self):
        self._subscriber.unregister()


class Balance:
    """The energy balance. Its error is at most a thousandth of the tolerance a second, relative to the energy. Steps end
    with every tick, so they are shorter than the tolerance asks for."""

    def __init__(self):
        self.worst = 0.0  # in those
        self._began = self._dissipated = self._scale = 0.0

    def take(self, status):
        if status.dissipated < self._dissipated:  # a new state, from which the balance begins anew
            self._began, self._scale = status.sim_time, 0.0
        self._dissipated = status.dissipated
        self._scale = max(self._scale, status.kinetic + abs(status.potential) + abs(status.work_supplied) + status.dissipated)
        allowed = 1e-3 * TOLERANCE * (1 + status.sim_time - self._began) * (1 + self._scale)
        self.worst = max(self.worst, abs(status.energy_balance) / allowed)


class User(threading.Thread):
    """Sends some forty commands a second, and asks for something every second or so."""

    def __init__(self, newest_stamp):
        super().__init__()
        self.commands = self.calls = 0
        self.standing = self.stepped = 0.0  # s
        self.faults = []
        self._newest_stamp = newest_stamp
        self._chance = random.Random(1)
        self._end = threading.Event()
        self._torques = publisher('/planar_chain/joint_torques', Float64MultiArray)
        self._torque = publisher('/planar_chain/joint_torque', JointTorque)
        self._force = publisher('/planar_chain/link_force', LinkForce)
        self._next_call = 0.0

    def run(self):
        while not self._end.wait(self._chance.uniform(0, 0.05)):
            self._chance.choice([self._hold, self._twist, self._push])()
            self.commands += 1
            if time.monotonic() > self._next_call:
                self._next_call = time.monotonic() + self._chance.uniform(0, 2)
                try:
                    self._call()
                except Exception as failure:  # pylint: disable=broad-except
                    self.faults.append('%s: %s' % (type(failure).__name__, failure))
                    return

    def end(self):
        self._end.set()
        self.join()

    def _hold(self):
        self._torques.publish(data=[self._chance.uniform(-1, 1) for _ in LINKS])

    def _window(self):
        """A duration and a start: held or not, at once or later."""
        later = self._newest_stamp() + rospy.Duration(self._chance.uniform(1, 2))
        return {'duration': self._chance.choice([0, 0.0373, self._chance.uniform(0.001, 0.3)]),
                'start': self._chance.choice([rospy.Time(), later])}

    def _twist(self):
        self._torque.publish(joint=self._chance.choice(LINKS) + '_joint', torque=self._chance.uniform(-2, 2),
                             **self._window())

    def _push(self):
        self._force.publish(link=self._chance.choice(LINKS), point=Point(self._chance.uniform(0, 0.3), 0, 0),
                            force=Vector3(self._chance.uniform(-5, 5), self._chance.uniform(-5, 5), 0),
                            moment=self._chance.uniform(-0.5, 0.5), **self._window())

    def _ask(self, name, service_type, **request):
        answer = rospy.ServiceProxy('/planar_chain/' + name, service_type)(**request)
        self.calls += 1
        if not answer.success:
            self.faults.append('%s: %s' % (name, answer.message))
        return answer

    def _numbers(self, size):
        return [self._chance.uniform(-size, size) for _ in LINKS]

    def _call(self):
        kind = self._chance.choices(['stand', 'step', 'state', 'clear', 'reset', 'look'], [3, 3, 2, 1, 1, 3])[0]
        began = time.monotonic()
        if kind == 'stand':
            self._ask('pause', Trigger)
            self._end.wait(self._chance.uniform(0, 0.3))
            self._ask('resume', Trigger)
            self.standing += time.monotonic() - began
        elif kind == 'step':
            for torques in ([], self._numbers(1)):
                n = self._chance.randint(1, 50)
                self._ask('step', Step, torques=torques, n=n)
                self.stepped += n / RATE
            self._ask('resume', Trigger)
            self.standing += time.monotonic() - began
        elif kind == 'state':
            self._ask('set_state', SetState, q=self._numbers(1), qd=self._numbers(3))
        elif kind == 'clear':
            self._ask('clear_commands', Trigger)
        elif kind == 'reset':
            self._ask('reset', Trigger)
        else:
            self._ask('linearize', Linearize)
            self._ask('equations', Equations, q=self._numbers(3), qd=self._numbers(5))


class Soak:
    def __init__(self, node, sanitized):
        self._node, self._sanitized = node, sanitized
        self._streams = [Stream('/joint_states', JointState, RATE, 4, 1),
                         Stream('/planar_chain/link_states', LinkStates, RATE, 4, 20),
                         Stream('/tf', TFMessage, TF_RATE, 8, 10)]
        self._statuses = Listener('/planar_chain/status', SimStatus)
        self._balance = Balance()
        self._memory = []
        self._lag = 0.0

    def run(self, seconds):
        """@returns the faults, empty if there are none"""
        self._statuses.wait_for_count(1)
        service('step', Step).close()
        user = User(lambda: self._statuses.messages[-1].header.stamp)
        first, began = self._statuses.messages[-1].sim_time, time.monotonic()
        computed = cpu_seconds(self._node.process.pid)
        user.start()
        faults = []
        while not faults and time.monotonic() < began + seconds:
            rospy.rostime.wallsleep(min(5.0, seconds / 20))
            faults = self._look() + user.faults
        user.end()
        wall = time.monotonic() - began
        share = (cpu_seconds(self._node.process.pid) - computed) / wall
        status = self._statuses.messages[-1]
        for stream in self._streams:
            stream.close()
        kept = (status.sim_time - first) / (wall - user.standing + user.stepped)
        faults += user.faults + self._growth()
        if not self._sanitized and abs(kept - 1) > 0.002 + 1 / seconds:
            faults.append('sim time went %.5f times as fast as wall time' % kept)
        print('%.0f s: %d commands, %d calls; messages on %s; sim time per wall time %.5f, at most %.3f s behind; '
              '%.1f %% of a processor; %d rescues; energy balance at worst %.2g of what is allowed' % (
                  wall, user.commands, user.calls,
                  ', '.join('%s %d' % (stream.topic, stream.count) for stream in self._streams),
                  kept, self._lag, 100 * share, status.rescues, self._balance.worst))
        return faults

    def _look(self):
        faults = [fault for stream in self._streams for fault in stream.faults()]
        if self._node.process.poll() is not None:
            faults.append('the node has ended')
            return faults
        self._memory.append(resident_bytes(self._node.process.pid))
        statuses, self._statuses.messages[:-1] = list(self._statuses.messages), []
        for status in statuses:
            self._balance.take(status)
            self._lag = max(self._lag, status.lag)
            if status.fault or status.rejected_commands:
                faults.append('fault: %s; refused: %s' % (status.fault, status.last_rejection))
            if not all(map(math.isfinite, numbers(status))):
                faults.append('status: not finite:\n%s' % status)
        if self._balance.worst > 1:
            faults.append('the energy balance is %.3g times as far off as is allowed' % self._balance.worst)
        if self._lag > PATIENCE and not self._sanitized:
            faults.append('%.3f s behind' % self._lag)
        return faults

    def _growth(self):
        """The growth of memory after a first quarter, in which everything is used for the first time."""
        size = max(1, len(self._memory) // 8)
        eighths = [statistics.median(self._memory[i:i + size]) for i in range(0, len(self._memory), size)][:8]
        print('memory, MB: ' + ', '.join('%.2f' % (bytes_then / 1e6) for bytes_then in eighths))
        before, after = eighths[len(eighths) // 4], eighths[-1]
        has_grown = after - before > MOST_GROWTH and not self._sanitized
        return ['memory has grown by %.0f bytes' % (after - before)] if has_grown else []


def warnings_in(log, sanitized):
    told = [line for line in log.splitlines() if 'WARN' in line or 'ERROR' in line or 'FATAL' in line]
    return [line for line in told if not (sanitized and 'simulation time cannot keep up' in line)]


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument('seconds', type=float)
    arguments.add_argument('--node', metavar='PROGRAM')
    arguments.add_argument('--sanitized', action='store_true')
    given = arguments.parse_args()
    # What the sanitizer holds back of freed memory: by default a quarter of a GB, which would take long to fill.
    os.environ.setdefault('ASAN_OPTIONS', 'quarantine_size_mb=16')
    with Master():
        rospy.init_node('soak')
        with Node(SCENE, program=given.node) as node:
            faults = Soak(node, given.sanitized).run(given.seconds)
        status, log = node.wait()
    faults += warnings_in(log, given.sanitized)
    if status != 0:
        faults.append('the node ended with status %d:\n%s' % (status, log[-5000:]))
    for fault in faults[:20]:
        print(fault)
    sys.exit(1 if faults else 0)


if __name__ == '__main__':
    main()
