#!/usr/bin/python3
"""Drags the tip of a scene's chain with the mouse, in rviz on a display of its own (Xvfb), and sees joint_states follow:
rviz_drag.py [--scene NAME] [--to X Y] [--picture OUT.png] [--seconds S]. By hand; in a sourced shell,
with xdotool, xvfb and imagemagick installed. The chain is at rest before. Without --to nothing is dragged: only the picture."""

import argparse
import json
import math
import os
import subprocess
import sys
import time

import rospy
import yaml
from planar_chain.msg import LinkStates, SimStatus
from std_srvs.srv import Trigger
from visualization_msgs.msg import InteractiveMarkerFeedback

from ros_node import Listener, service

SIZE = (1280, 800)
VIEW = (364, 62, 900, 709)  # px: left, top, width, height of rviz's view in that
LOADED = 12                 # s that rviz takes, drawn by the processor
SPEED = 30                  # px a step of the mouse
POINTER = ((0, 0), (0, 17), (4, 13), (7, 19), (10, 18), (7, 12), (12, 12))  # its outline, px: no picture of the display has it


class Screen:
    """A display, and rviz's view of the plane of motion on it."""

    def __init__(self, centre, half):
        reader, writer = os.pipe()
        self._server = subprocess.Popen(['Xvfb', '-displayfd', str(writer), '-screen', '0', '%dx%dx24' % SIZE],
                                        pass_fds=[writer], stderr=subprocess.DEVNULL)
        os.environ['DISPLAY'] = ':' + os.read(reader, 16).decode().strip()
        os.environ['LIBGL_ALWAYS_SOFTWARE'] = '1'
        self._centre, self._scale = centre, VIEW[3] / 2 / half

    def pixel(self, x, y):
        left, top, width, height = VIEW
        return (round(left + width / 2 + self._scale * (x - self._centre[0])),
                round(top + height / 2 - self._scale * (y - self._centre[1])))

    @staticmethod
    def mouse(*command):
        subprocess.run(['xdotool', *map(str, command)], check=True)

    def press(self, point):
        self.mouse('mousemove', *self.pixel(*point))
        time.sleep(0.5)
        self.mouse('mousedown', 1)
        time.sleep(0.3)

    def drag(self, begin, end):
        (x0, y0), (x1, y1) = self.pixel(*begin), self.pixel(*end)
        steps = max(1, round(math.hypot(x1 - x0, y1 - y0) / SPEED))
        for k in range(1, steps + 1):
            self.mouse('mousemove', x0 + (x1 - x0) * k // steps, y0 + (y1 - y0) * k // steps)
            time.sleep(0.05)

    @staticmethod
    def shoot(path):
        left, top, width, height = VIEW
        where = subprocess.run(['xdotool', 'getmouselocation'], stdout=subprocess.PIPE, universal_newlines=True, check=True).stdout
        x, y = (int(part.split(':')[1]) for part in where.split()[:2])
        pointer = 'polygon ' + ' '.join('%d,%d' % (x + dx, y + dy) for dx, dy in POINTER)
        subprocess.run(['import', '-window', 'root', path], check=True)
        subprocess.run(['convert', path, '-fill', 'white', '-stroke', 'black', '-draw', pointer, '-crop',
                        '%dx%d+%d+%d' % (width, height, left, top), '+repage', '-colors', '64', path], check=True)

    def close(self):
        self._server.terminate()
        self._server.wait()


def tip_of(states, links):
    """The outer pin of the last link, m."""
    pose = states.pose[-1]
    dx, dy = (pin - com for pin, com in zip(links[-1]['pin'], links[-1]['com']))
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    return pose.x + c * dx - s * dy, pose.y + s * dx + c * dy


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--scene', default='triple')
    parser.add_argument('--to', type=float, nargs=2, help='m, where the tip is dragged')
    parser.add_argument('--seconds', type=float, default=3, help='before anything is done')
    parser.add_argument('--picture')
    arguments = parser.parse_args()
    root = os.path.join(os.path.dirname(os.path.abspath(__file__)), '../..')
    sys.path.append(os.path.join(root, 'src', 'tools'))
    import show
    scene = os.path.join(root, 'config', 'scenes', arguments.scene + '.yaml')
    chain = subprocess.run(['rosrun', 'planar_chain', 'equations', scene, '--chain'], stdout=subprocess.PIPE, check=True)
    chain = json.loads(chain.stdout)
    links = chain['links']
    with open(scene, encoding='utf-8') as file:
        centre, half = show.view(chain, yaml.safe_load(file))

    screen = Screen(centre, half)
    launch = subprocess.Popen(['roslaunch', 'planar_chain', 'sim.launch', 'scene:=' + arguments.scene, 'rviz:=true'])
    try:
        rospy.init_node('rviz_drag', anonymous=True)
        states = Listener('/planar_chain/link_states', LinkStates)
        feedback = Listener('/pull/feedback', InteractiveMarkerFeedback)
        statuses = Listener('/planar_chain/status', SimStatus)
        feedback.wait_for_publisher()
        time.sleep(LOADED + arguments.seconds)
        if arguments.to:
            service('settle', Trigger)()
            service('pause', Trigger)()  # or the mouse would come too late
            time.sleep(0.5)
            begin = tip_of(states.messages[-1], links)
            screen.press(begin)
            service('resume', Trigger)()
            screen.drag(begin, arguments.to)
            time.sleep(2)
        if arguments.picture:
            screen.shoot(arguments.picture)
        if arguments.to:
            end = tip_of(states.messages[-1], links)
            print('tip from (%.3f, %.3f) m to (%.3f, %.3f) m, mouse at (%.3f, %.3f) m, %d messages from rviz' % (
                *begin, *end, *arguments.to, len(feedback.messages)))
            screen.mouse('mouseup', 1)
            time.sleep(1)
            age = statuses.messages[-1].link_force_age
            print('let go: the last force is %.2f s old' % age)
            followed = math.dist(end, arguments.to) < 0.3 * math.dist(begin, arguments.to)
            return 0 if followed and age > 0.5 else 1
        return 0
    finally:
        launch.send_signal(subprocess.signal.SIGINT)
        launch.wait()
        screen.close()


if __name__ == '__main__':
    sys.exit(main())
