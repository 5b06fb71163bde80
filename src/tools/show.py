#!/usr/bin/python3
"""show CONFIG [rviz's options]: starts rviz on a running scene, with the view and the grid fitted to the length of the
chain. The parameter ~simulation names the node (default planar_chain)."""

import itertools
import math
import signal
import subprocess
import sys
import tempfile

signal.signal(signal.SIGINT, signal.SIG_DFL)  # the launch may end during the imports
import rospy  # noqa: E402
import yaml  # noqa: E402
from chain import NoChain, read_chain  # noqa: E402

FREE = 1.25    # half the height of the view, in units of the reach
ASPECT = 1.27  # of the view in the window of config/planar_chain.rviz
LONG = 16      # links; a longer chain that falls from rest stays in the lower half of its reach
CELLS = 3      # least number of grid cells in the reach
DEFAULT = 2.0  # m: the reach where the scene is refused


def reach(links):
    """The largest distance of a point of the chain from the ground pin, m."""
    return sum(max(math.hypot(*link['com']), math.hypot(*link['pin'])) for link in links) or DEFAULT


def farthest(base):
    """The largest distance of the base from its origin, m, in x and y apart."""
    laws = [base[key] for key in ('x', 'y') if key in base]
    return math.hypot(*(max(map(abs, law['values'])) if 'values' in law else abs(law['amplitude']) + abs(law['offset'])
                        for law in laws))


def highest(chain):
    """The largest initial height of a pin above the ground pin, m."""
    angles = itertools.accumulate(chain['q'])
    rises = (math.sin(angle) * link['pin'][0] + math.cos(angle) * link['pin'][1]
             for angle, link in zip(angles, chain['links']))
    return max(0.0, *itertools.accumulate(rises))


def view(chain, loads):
    """The reach, the height of the view's centre above the ground pin, half the height of the view, m."""
    size = reach(chain['links']) + farthest(chain.get('base', {}))
    falls = not loads and not any(chain['qd']) and chain['gravity'][0] == 0 > chain['gravity'][1]
    if len(chain['links']) <= LONG or not falls:
        return size, 0, FREE * size
    top, bottom = highest(chain) + (FREE - 1) * size, -FREE * size
    return size, (top + bottom) / 2, max((top - bottom) / 2, FREE * size / ASPECT)


def view_of(node):
    """The view of the scene in a node's parameters. The node reports what is wrong with a scene."""
    try:
        scene = rospy.get_param(node)
        return view(read_chain('/dev/stdin', yaml.safe_dump(scene)), scene.get('loads'))
    except (KeyError, NoChain, OSError, yaml.YAMLError):
        return DEFAULT, 0, FREE * DEFAULT


def frame_of(node):
    """The frame that the view follows: where a chain that nothing holds has its first pin, without its turns. Else None."""
    try:
        scene = rospy.get_param(node)
        slides = [link for link in read_chain('/dev/stdin', yaml.safe_dump(scene))['links'][:2] if 'type' in link['joint']]
    except (KeyError, NoChain, OSError, yaml.YAMLError):
        return None
    if len(slides) < 2 or any(link['mass'] for link in slides):
        return None
    return scene.get('publish', {}).get('frame_prefix', node[1:node.rfind('/') + 1]) + slides[1]['name']


def cell(size):
    """The largest of 1, 2 or 5 times a power of ten that is at most this."""
    power = 10 ** math.floor(math.log10(size))
    return max(digit * power for digit in (1, 2, 5) if digit * power <= size)


def fit(config, size, centre, half, frame=None):
    manager = config['Visualization Manager']
    for view in (manager['Views']['Current'], *(manager['Views'].get('Saved') or ())):
        view['Distance'] = half / math.tan(view['Field of View'] / 2)
        view['Focal Point']['Z'] = centre
        if frame:
            view['Target Frame'] = frame
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
    node = rospy.resolve_name(node)
    fit(config, *view_of(node), frame_of(node))
    with tempfile.NamedTemporaryFile('w', suffix='.rviz', encoding='utf-8') as file:
        yaml.safe_dump(config, file)
        file.flush()
        names = [argument for argument in sys.argv[1:] if argument not in arguments]
        rviz = subprocess.Popen(['rviz', '-d', file.name, *arguments[1:], *names])
        while True:
            try:
                return rviz.wait()
            except KeyboardInterrupt:
                pass  # rviz has been interrupted too


if __name__ == '__main__':
    sys.exit(main())
