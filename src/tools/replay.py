"""What `show` needs of a recording: its scenes, a master, and rosbag play."""

import os
import signal
import socket
import subprocess
import tempfile
import time
from xml.etree import ElementTree

import rosgraph
from unread import opened

PATIENCE = 30  # s that roscore may take to start


def scenes_of(path):
    """({node: text of its scene or None}, topics) of a bag. Raises NoBag."""
    with opened(path, NoBag) as (bag, messages_of):
        topics = set(bag.get_type_and_topic_info().topics)
        nodes = {topic.rsplit('/', 1)[0] for topic in topics if topic.endswith(('/scene', '/link_states', '/status'))}
        scenes = dict.fromkeys(sorted(nodes))
        for node in scenes:
            scenes[node] = next((message.data for message in messages_of(node + '/scene', 'std_msgs/String') if message.data), None)
    return scenes, topics


def ground_of(urdf):
    """The URDF without what moves: rviz draws a long chain as a line, in few frames."""
    robot = ElementTree.fromstring(urdf)
    moving = {joint.find('child').get('link') for joint in robot.findall('joint') if joint.get('type') != 'fixed'}
    for joint in robot.findall('joint'):
        if joint.get('type') != 'fixed':
            robot.remove(joint)
    for link in robot.findall('link'):
        if link.get('name') in moving:
            robot.remove(link)
    return ElementTree.tostring(robot, encoding='unicode')


def urdf_of(simulate, scene, node, is_long):
    """The robot_description that the node would write. scene: text. Raises ValueError with the reason if it is refused."""
    with tempfile.TemporaryDirectory() as folder:
        file, urdf = os.path.join(folder, 'scene.yaml'), os.path.join(folder, 'robot.urdf')
        with open(file, 'w', encoding='utf-8') as out:
            out.write(scene)
        run = subprocess.run([simulate, file, '--duration', '1e-9', '--write-urdf', urdf, '--node', node],
                             stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, universal_newlines=True, check=False)
        if run.returncode != 0:
            raise ValueError(run.stderr.strip().replace(file + ': ', '').replace(file + ':', 'line '))
        with open(urdf, encoding='utf-8') as text:
            return ground_of(text.read()) if is_long else text.read()


class NoBag(Exception):
    """Why a bag cannot be read."""


class Master:
    """A roscore of the recording's own, so that a running simulation does not mix with it."""

    def __enter__(self):
        port = 11311
        if rosgraph.is_master_online():
            with socket.socket() as free:
                free.bind(('', 0))
                port = free.getsockname()[1]
            print('show: the recording has a roscore of its own: export ROS_MASTER_URI=http://localhost:%d' % port)
        os.environ['ROS_MASTER_URI'] = 'http://localhost:%d' % port
        self._process = subprocess.Popen(['roscore', '-p', str(port)], stdout=subprocess.DEVNULL, start_new_session=True)
        end = time.monotonic() + PATIENCE
        try:
            while not rosgraph.is_master_online():
                if time.monotonic() > end or self._process.poll() is not None:
                    raise OSError('roscore does not start')
                time.sleep(0.1)
        except BaseException:
            self.__exit__()
            raise
        return rosgraph.Master('/show')

    def __exit__(self, *_):
        self._process.send_signal(signal.SIGINT)
        self._process.wait()


class Play:
    """rosbag play, which starts once rviz listens. Raises NoBag if it fails, such as on a damaged bag."""

    def __init__(self, master, bag, topics, options):
        self._master, self._bag = master, bag
        self._command = ['rosbag', 'play', *([] if '/clock' in topics else ['--clock']), '--quiet', *options, bag]
        self._process = None
        self._ended = False

    def maybe_start(self):
        if self._process is None:
            subscribers = dict(self._master.getSystemState()[1])
            if any('rviz' in name for name in subscribers.get('/tf', ())):
                self._process = subprocess.Popen(self._command)
        elif not self._ended and self._process.poll() is not None:
            self._ended = True
            if self._process.returncode != 0:
                raise NoBag('%s: expected a bag that rosbag play can play, got its exit status %d' % (self._bag, self._process.returncode))
            print('show: the recording has ended; Ctrl-C ends rviz. With --loop it begins again', flush=True)

    def end(self):
        if self._process and self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)
            self._process.wait()
