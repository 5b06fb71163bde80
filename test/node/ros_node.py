"""The node under test and what it says: shared by the ros_*.py tests.

Nothing here sleeps: tests wait for messages, with a limit that only a failure reaches.
"""

import os
import signal
import subprocess
import tempfile
import threading
import time
import unittest

import roslib.packages
import rosparam
import rospy
from planar_chain.msg import SimStatus
from sensor_msgs.msg import JointState

LIMIT = 40.0  # s of wall time that an event may take, on a machine with much else to do


def node_program():
    return roslib.packages.find_node('planar_chain', 'planar_chain_node')[0]


def upload(scene, name):
    """Replaces the private parameters of the node `name` by the scene, a dict."""
    if rospy.has_param(name):
        rospy.delete_param(name)
    rosparam.upload_params(name, scene)


class Node:
    """A node on a scene of its own, while the with statement lasts; prefix: of the command that runs it; program:
    another than that of the package; arguments: of the program."""

    def __init__(self, scene, namespace='', prefix=(), program=None, arguments=()):
        self.name = namespace + '/planar_chain'
        self._namespace = namespace
        self._command = [*prefix, program or node_program(), *arguments]
        self._scene = scene

    def __enter__(self):
        upload(self._scene, self.name)
        self._log = tempfile.TemporaryFile(mode='w+', encoding='utf-8')
        self.process = subprocess.Popen(
            self._command, env=dict(os.environ, ROS_NAMESPACE=self._namespace or '/'),
            stdout=self._log, stderr=subprocess.STDOUT)
        return self

    def __exit__(self, *_):
        self.process.send_signal(signal.SIGINT)
        self.process.wait(LIMIT)
        while PUBLISHERS:
            PUBLISHERS.pop().unregister()

    def wait(self):
        """Waits for the end of the program; returns its exit status and all it wrote."""
        status = self.process.wait(LIMIT)
        self._log.seek(0)
        return status, self._log.read()


class Listener:
    """Keeps every message of a topic, in the order of arrival."""

    def __init__(self, topic, message_type):
        self.messages = []
        self._arrival = threading.Condition()
        self._topic = topic
        self._subscriber = rospy.Subscriber(topic, message_type, self._take)

    def _take(self, message):
        with self._arrival:
            self.messages.append(message)
            self._arrival.notify_all()

    def wait_for(self, holds, after=0):
        """The index of the first message from `after` on of which `holds` is true."""
        seen = after

        def found():
            nonlocal seen
            while seen < len(self.messages):
                if holds(self.messages[seen]):
                    return True
                seen += 1
            return False

        with self._arrival:
            if not self._arrival.wait_for(found, LIMIT):
                raise AssertionError('%s: waited in vain after %d messages; the last:\n%s' % (
                    self._topic, len(self.messages), self.messages[-1] if self.messages else 'none'))
        return seen

    def wait_for_count(self, count):
        with self._arrival:
            if not self._arrival.wait_for(lambda: len(self.messages) >= count, LIMIT):
                raise AssertionError('%s: %d messages of %d came' % (
                    self._topic, len(self.messages), count))

    def wait_for_publisher(self):
        began = time.monotonic()
        while self._subscriber.get_num_connections() == 0:
            if time.monotonic() - began > LIMIT:
                raise AssertionError('nobody publishes ' + self._topic)
            time.sleep(0.01)

    def close(self):
        self._subscriber.unregister()


class Watching(unittest.TestCase):
    """A test that hears joint_states and status from its start to its end."""

    def setUp(self):
        self.states = Listener('/joint_states', JointState)
        self.statuses = Listener('/planar_chain/status', SimStatus)

    def tearDown(self):
        self.states.close()
        self.statuses.close()


class Running:
    """A program such as rostopic pub or rosbag record, ended as by Ctrl-C."""

    def __init__(self, *command):
        self._command = command

    def __enter__(self):
        self.process = subprocess.Popen(self._command, stdout=subprocess.DEVNULL)
        return self

    def __exit__(self, *_):
        self.process.send_signal(signal.SIGINT)
        self.process.wait(LIMIT)


class Arrivals(rospy.SubscribeListener):
    """Notices a subscriber of one's own topic."""

    def __init__(self):
        super().__init__()
        self.first = threading.Event()

    def peer_subscribe(self, topic_name, topic_publish, peer_publish):
        self.first.set()


PUBLISHERS = []  # for the node that runs


def publisher(topic, message_type, queue=1000):
    """A publisher that the node has connected to, as long as the node runs. queue: for messages that wait to be sent;
    None: publish() sends."""
    arrivals = Arrivals()
    out = rospy.Publisher(topic, message_type, arrivals, queue_size=queue, tcp_nodelay=True)
    PUBLISHERS.append(out)
    if not arrivals.first.wait(LIMIT):
        raise AssertionError('nobody takes ' + topic)
    return out


def service(name, service_type):
    """A connection to a service of the node in the root namespace, kept open."""
    name = '/planar_chain/' + name
    rospy.wait_for_service(name, LIMIT)
    return rospy.ServiceProxy(name, service_type, persistent=True)


def nanoseconds(message):
    return message.header.stamp.to_nsec()


def rod(**more):
    """One link without gravity: q̈ = τ/J with J = I + m r² = 0.3 + 2·0.4² = 0.62 kg m²."""
    return dict({
        'chain': ['rod'],
        'gravity': [0.0, 0.0],
        'links': {'rod': {'mass': 2.0, 'inertia': 0.3, 'com': [0.4, 0.0], 'pin': [1.0, 0.0]}},
        'publish': {'rate': 200.0, 'status_rate': 20.0},
    }, **more)


def spinning():
    """The links of rod(), at 1 rad/s."""
    links = rod()['links']
    links['rod']['initial'] = {'velocity': 1.0}
    return links


ROD_INERTIA = 0.62
