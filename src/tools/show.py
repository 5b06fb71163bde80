#!/usr/bin/python3
"""rviz on a running scene, from as far as its chain is long: show CONFIG [rviz's options]. The scene is that of the
parameter ~simulation, the name of a node (default planar_chain)."""

import math
import signal
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

signal.signal(signal.SIGINT, signal.SIG_DFL)  # a launch that ends at once interrupts the imports
import rospy  # noqa: E402
import yaml  # noqa: E402

FREE = 1.25   # half the height of the view, in reaches of the chain
CELLS = 3     # of the grid, at least, in a reach
DEFAULT = 2.0  # m: the reach of a scene that is none


def reach(scene):
    """No point of the chain comes farther from the ground pin, m."""
    return sum(int(link.get('repeat', 1)) * max(math.hypot(*map(float, link[to])) for to in ('com', 'pin'))
               for link in scene['links'].values()) or DEFAULT


def reach_of_robot(urdf):
    """The same of a URDF: from joint to joint, and to the farthest centre of mass."""
    def length(origin):
        return 0 if origin is None else math.hypot(*map(float, origin.get('xyz', '0 0 0').split()))

    robot = xml.etree.ElementTree.fromstring(urdf)
    joints = robot.findall('joint')
    moving = {joint.find('child').get('link') for joint in joints}
    between = [joint for joint in joints if joint.find('parent').get('link') in moving]
    centres = (length(link.find('inertial/origin')) for link in robot.findall('link'))
    return sum(length(joint.find('origin')) for joint in between) + max(centres) or DEFAULT


def reach_of(node):
    """The same of the scene in a node's parameters. What is wrong with it, the node itself says."""
    try:
        scene = rospy.get_param(node)
        return reach_of_robot(scene['robot_description']) if 'robot_description' in scene else reach(scene)
    except (AttributeError, KeyError, TypeError, ValueError, SyntaxError):
        return DEFAULT


def cell(size):
    """1, 2 or 5 times a power of ten, at most this."""
    power = 10 ** math.floor(math.log10(size))
    return max(digit * power for digit in (1, 2, 5) if digit * power <= size)


def fit(config, size):
    manager = config['Visualization Manager']
    for view in (manager['Views']['Current'], *(manager['Views'].get('Saved') or ())):
        view['Distance'] = FREE * size / math.tan(view['Field of View'] / 2)
    for display in manager['Displays']:
        if display['Class'] == 'rviz/Grid':
            display['Cell Size'] = cell(size / CELLS)
            display['Plane Cell Count'] = 2 * math.ceil(2.5 * size / display['Cell Size'])


def main():
    signal.signal(signal.SIGINT, signal.default_int_handler)
    arguments = rospy.myargv()[1:]
    if not arguments:
        sys.exit(__doc__)
    with open(arguments[0], encoding='utf-8') as file:
        config = yaml.safe_load(file)
    node = rospy.get_param(rospy.resolve_name('~simulation'), 'planar_chain')
    fit(config, reach_of(rospy.resolve_name(node)))
    with tempfile.NamedTemporaryFile('w', suffix='.rviz', encoding='utf-8') as file:
        yaml.safe_dump(config, file)
        file.flush()
        names = [argument for argument in sys.argv[1:] if argument not in arguments]
        rviz = subprocess.Popen(['rviz', '-d', file.name, *arguments[1:], *names])
        while True:
            try:
                return rviz.wait()
            except KeyboardInterrupt:
                pass  # rviz has been interrupted, too, and ends


if __name__ == '__main__':
    sys.exit(main())
