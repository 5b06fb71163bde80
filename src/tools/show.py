#!/usr/bin/python3
"""Starts rviz, with the view and the grid fitted to the length of the chain.

    show CONFIG [rviz's options]            on a running scene; the parameter ~simulation names its node
    show NAMESPACE … [rviz's options]       on the running scenes of these namespaces, together
    show BAG [SCENE] [options of rosbag play]   plays a recording; SCENE is needed if the bag lacks it
"""

from program import put, run  # isort: skip

import copy
import hashlib
import itertools
import math
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

import camera  # noqa: E402
import rosgraph  # noqa: E402
import rospy  # noqa: E402
import yaml  # noqa: E402
from chain import EQUATIONS, NoChain, read_chain  # noqa: E402
from files import SHIPPED, scene_file, tree_of  # noqa: E402
from replay import Master, NoBag, Play, scenes_of, urdf_of  # noqa: E402
from unread import ENDINGS  # noqa: E402

WRITTEN = '# Written by show (%s). What you save or change is kept.\n'
BEFORE = '# Written by show, again at each start. Save in rviz keeps your own.'  # of earlier versions
FREE = 1.25    # from the first pin to the rim of the view, in units of the reach
FAR = 10       # lengths of the chain; a rail's limit farther away is not drawn
SIDE = 2       # lengths of the chain: length of a rail to a side without a limit
INSIDE = 0.25  # likewise, of a rail on a link that turns
ASPECT = 1.27  # of the view in the window of config/planar_chain.rviz
LONG = 16      # links; a longer chain that falls from rest stays in the lower half of its reach
TEXT = 0.05    # height of a text, in units of half the height of the view
TEXT_TOPIC = '/show/energy_%d'  # of each of several chains
CELLS = 3.75   # least number of grid cells in half the height of the view
DEFAULT = 2.0  # m: the reach where the scene is refused


def length(links):
    """The length of the chain with its prismatic joints at 0, m."""
    return sum(max(math.hypot(*link['com']), math.hypot(*link['pin'])) for link in links) or 1.0


def reach(chain):
    """The largest distance of a point of the chain from the first pin, m. Rails on links count."""
    size, outer = length(chain['links']), list(zip(chain['links'], chain['q']))[leading(chain):]
    return size + sum(max(map(abs, rail(link['joint'], q, size, INSIDE))) for link, q in outer if 'type' in link['joint'])


def range_of(law):
    """The least and largest value of a motion in time; a spline's by its points."""
    if 'values' in law:
        return min(law['values']), max(law['values'])
    return law['offset'] - abs(law['amplitude']), law['offset'] + abs(law['amplitude'])


def leading(chain):
    """The number of prismatic joints before the first link that turns."""
    return next((i for i, link in enumerate(chain['links']) if 'type' not in link['joint']), len(chain['links']))


def is_free(chain):
    """True if nothing holds the first pin of a link that turns: two prismatic links without mass."""
    return leading(chain) == 2 and not any(link['mass'] for link in chain['links'][:2])


def rail(joint, q, size, free=SIDE):
    """The part of a rail that is drawn, m along its axis. free: lengths of the chain, of a side without a limit."""
    low, high = range_of(joint['drive']) if 'drive' in joint else (q, q)
    lower, upper = (-math.inf if joint.get('lower') is None else joint['lower'], math.inf if joint.get('upper') is None else joint['upper'])
    return (min(lower, low) if low - lower <= FAR * size else low - free * size,
            max(upper, high) if upper - high <= FAR * size else high + free * size)


def root(chain, size):
    """Where the inner pin of the first link that turns can be, m: least and largest x, least and largest y."""
    base = chain.get('base', {})
    ranges = [range_of(base[key]) if base else (0, 0) for key in ('x', 'y')]
    turns = bool(base) and any(range_of(base['angle']))
    for link, q in zip([] if is_free(chain) else chain['links'][:leading(chain)], chain['q']):
        ends = rail(link['joint'], q, size)
        most = max(map(abs, ends))
        steps = [(-most, most) if turns else sorted(end * part for end in ends) for part in link['joint']['axis']]
        ranges = [(low + less, high + more) for (low, high), (less, more) in zip(ranges, steps)]
    return ranges


def highest(chain):
    """The largest initial height of a pin above the first pin of a link that turns, m."""
    angle = height = most = 0.0
    for link, q in list(zip(chain['links'], chain['q']))[leading(chain):]:
        x, y = (pin + q * along for pin, along in zip(link['pin'], link['joint'].get('axis', (0, 0))))
        angle += q * ('axis' not in link['joint'])
        height += math.sin(angle) * x + math.cos(angle) * y
        most = max(most, height)
    return most


def view(chain, scene):
    """The view's centre (x, y) in the base frame and half its height, m: room for the reach around each position that rails and base
    allow. A chain with a pinned tip stays within half its reach of the middle between its pins."""
    size = reach(chain)
    (left, right), (bottom, top) = root(chain, length(chain['links']))
    middle, span = (0, 0), size
    tip = chain.get('tip', {}).get('pin', {})
    if tip and all(law.get('amplitude') == 0 for law in tip.values()) and 'base' not in chain and not leading(chain):
        middle, span = (tip['x']['offset'] / 2, tip['y']['offset'] / 2), size / 2
    falls = not scene.get('loads') and 'tip' not in scene and not any(chain['qd']) and chain['gravity'][0] == 0 > chain['gravity'][1]
    above = highest(chain) + (FREE - 1) * span if len(chain['links']) > LONG and falls else FREE * span
    height, width = top - bottom + above + FREE * span, right - left + 2 * FREE * span
    return ((left + right) / 2 + middle[0], (top + above + bottom - FREE * span) / 2 + middle[1]), max(height, width / ASPECT) / 2


def chain_of(scene):
    """The chain of a scene, a dict, or None. The node reports what is wrong with a scene."""
    try:
        return read_chain('/dev/stdin', yaml.safe_dump(scene))
    except (KeyError, NoChain, OSError, yaml.YAMLError):
        return None


def view_of_scene(scene):
    """The view of a scene in its base frame."""
    chain = chain_of(scene)
    return view(chain, scene) if chain else ((0, 0), FREE * DEFAULT)


def offset_of(scene):
    """The origin of the base frame in the world, m."""
    return tuple(map(float, scene.get('publish', {}).get('offset', (0, 0))))


def view_in_world(scene):
    (x, y), half = view_of_scene(scene)
    return (x + offset_of(scene)[0], y + offset_of(scene)[1]), half


def prefix_of(node, scene):
    """The prefix of the node's frames."""
    return scene.get('publish', {}).get('frame_prefix', node[1:node.rfind('/') + 1])


def frame_of(node, scene):
    """The frame that the view follows: where a chain that nothing holds has its first pin, without its turns. Else None."""
    chain = chain_of(scene)
    return prefix_of(node, scene) + chain['links'][1]['name'] if chain and is_free(chain) else None


def cell(size):
    """The largest of 1, 2 or 5 times a power of ten that is at most this."""
    power = 10 ** math.floor(math.log10(size))
    return max(digit * power for digit in (1, 2, 5) if digit * power <= size)


def fit(config, centre, half, frame=None):
    manager = config['Visualization Manager']
    for view in (manager['Views']['Current'], *(manager['Views'].get('Saved') or ())):
        camera.place(view, centre, half, frame)
    for display in manager['Displays']:
        if display['Class'] == 'rviz/Grid':
            display['Cell Size'] = cell(half / CELLS)
            display['Plane Cell Count'] = 2 * math.ceil((max(map(abs, centre)) + 2 * half) / display['Cell Size'])


def together(views):
    """The view of several chains: (centre, half) of each."""
    corners = [(x + sign * ASPECT * half, y + sign * half) for (x, y), half in views for sign in (-1, 1)]
    (left, right), (bottom, top) = ((min(values), max(values)) for values in zip(*corners))
    return ((left + right) / 2, (top + bottom) / 2), max(top - bottom, (right - left) / ASPECT) / 2


def for_nodes(config, nodes):
    """The displays of these nodes, given by their full names: a group for each, if there are several."""
    manager = config['Visualization Manager']
    shared = [display for display in manager['Displays'] if display['Class'] == 'rviz/Grid']
    groups = []
    for k, node in enumerate(nodes):
        outer = rosgraph.names.namespace(node)
        displays = copy.deepcopy([display for display in manager['Displays'] if display not in shared])
        for display in displays:
            for key in ('Marker Topic', 'Update Topic', 'Robot Description'):
                if key in display:
                    name = display[key]
                    display[key] = (node + name[len('planar_chain'):] if name.startswith('planar_chain/') else outer + name)
            if display['Name'] == 'Energy' and len(nodes) > 1:
                display['Marker Topic'] = TEXT_TOPIC % k
            if display['Name'] == 'Scale' and k > 0:
                display['Enabled'] = display['Value'] = False  # one is enough
        groups.append({'Class': 'rviz/Group', 'Name': node, 'Enabled': True, 'Value': True, 'Displays': displays})
    manager['Displays'] = shared + (groups if len(nodes) > 1 else groups[0]['Displays'])


def relay_texts(nodes, scenes, centre, half):
    """Publishes the energies of several chains as texts one above the other, each with its node's name."""
    from visualization_msgs.msg import MarkerArray
    size = TEXT * half / max(1, len(nodes) - 1)

    def relay(k, node):
        out = rospy.Publisher(TEXT_TOPIC % k, MarkerArray, queue_size=2)
        dx, dy = offset_of(scenes[k])
        frame = prefix_of(node, scenes[k]) + scenes[k].get('publish', {}).get('base_frame', 'base_link')

        def take(array):
            positions = [marker.pose.position for marker in array.markers]
            left, lowest = min(position.x for position in positions), min(position.y for position in positions)
            name = copy.deepcopy(array.markers[0])
            name.id, name.text = len(positions), node
            for marker, position in zip(array.markers, positions):
                position.x = centre[0] - dx - ASPECT * half + 5 * size + (position.x - left) * size / marker.scale.z
                position.y = centre[1] - dy - half + (1 + 8 * k + (position.y - lowest) / marker.scale.z) * size
            name.pose.position.x = max(position.x for position in positions) / 2 + min(position.x for position in positions) / 2
            name.pose.position.y = max(position.y for position in positions) + 1.1 * size
            array.markers.append(name)
            for marker in array.markers:
                marker.scale.z, marker.header.frame_id = size, frame
            out.publish(array)

        rospy.Subscriber(node + '/view/energy', MarkerArray, take, queue_size=2)

    for k, node in enumerate(nodes):
        relay(k, node)


def kept(name, config):
    """The file that rviz opens and saves to. rviz shows its name in the window's title. What a user has saved or changed there is
    kept. Else it is written if there is none, or one for another view."""
    def signed(text):
        return WRITTEN % hashlib.sha256(text.encode(errors='replace')).hexdigest()[:16] + text

    path = pathlib.Path.home() / '.rviz' / 'planar_chain' / (name + '.rviz')
    text = signed(yaml.safe_dump(config))
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        there = path.read_text(encoding='utf-8', errors='replace') if path.exists() else ''
        first, _, rest = there.partition('\n')
        if there == text or there and first != BEFORE and there != signed(rest):
            return str(path)
        path.write_text(text, encoding='utf-8')
    except OSError:
        path = pathlib.Path(tempfile.mkdtemp()) / path.name
        path.write_text(text, encoding='utf-8')
    return str(path)


def refuse(reason):
    print(reason, file=sys.stderr)
    sys.exit(2)


def require_master():
    try:
        rospy.has_param('/')
    except OSError:
        refuse('show: no roscore runs; start a scene first, or give a recording')


def require_display():
    if not any(os.environ.get(name) for name in ('DISPLAY', 'WAYLAND_DISPLAY', 'QT_QPA_PLATFORM')):
        sys.exit('show: rviz needs a display, and DISPLAY is not set. Without one, plot draws a bag')


def rviz(name, config, arguments, meanwhile=lambda: None):
    """Runs rviz until it ends. meanwhile is called every tenth of a second."""
    require_display()
    process = subprocess.Popen(['rviz', '-d', kept(name, config), *arguments])
    try:
        while True:
            try:
                while process.poll() is None:
                    meanwhile()
                    time.sleep(0.1)
                return process.returncode
            except KeyboardInterrupt:
                process.send_signal(signal.SIGINT)  # a terminal interrupts rviz too, `kill -INT` does not
    finally:
        if process.poll() is None:
            process.terminate()
            process.wait()


def load(path):
    return yaml.safe_load(pathlib.Path(path).read_text(encoding='utf-8'))


def private(name, default):
    """A private parameter. Its name is known from the command line alone: this program is no node."""
    own = next((argument[len('__name:='):] for argument in sys.argv if argument.startswith('__name:=')), 'show')
    return rospy.get_param(rosgraph.names.ns_join(rosgraph.names.get_ros_namespace(), own + '/' + name), default)


def fit_to(config, node, scene):
    """Fits the view to one scene. It may follow a frame of the chain."""
    frame = frame_of(node, scene)
    fit(config, *(view_of_scene(scene) if frame else view_in_world(scene)), frame)


def show_config(path, options, names):
    node = rospy.resolve_name(private('simulation', 'planar_chain'))
    config = load(path)
    scene = rospy.get_param(node, {})
    fit_to(config, node, scene)
    return rviz(private('title', pathlib.Path(path).stem), config, [*options, *names])


def show_nodes(nodes, options, scenes, title, meanwhile=lambda: None):
    config = load(SHIPPED.resolve().parent / 'planar_chain.rviz')
    for_nodes(config, nodes)
    if len(nodes) == 1:
        fit_to(config, nodes[0], scenes[0])
    else:
        centre, half = together(list(map(view_in_world, scenes)))
        fit(config, centre, half)
        rospy.init_node('show', anonymous=True, disable_signals=True)
        relay_texts(nodes, scenes, centre, half)
    return rviz(title, config, options, meanwhile)


def show_bag(path, options):
    given = options.pop(0) if options and not options[0].startswith('-') else None
    try:
        scenes, topics = scenes_of(path)
    except NoBag as refused:
        refuse('show: %s' % refused)
    try:
        if given is not None:
            with open(scene_file(given), encoding='utf-8') as file:
                scenes = dict.fromkeys(scenes, file.read())
    except (OSError, UnicodeDecodeError) as problem:
        why = 'nothing: ' + problem.strerror if isinstance(problem, OSError) else 'other bytes'
        refuse('show: %s: expected a scene that can be read, got %s' % (given, why))
    if not scenes or '/tf' not in topics:
        refuse('show: %s: expected the topics of a planar_chain node and /tf, got %s' % (path, ', '.join(sorted(topics)) or 'none'))
    without = [node for node, scene in scenes.items() if not scene]
    if without:
        refuse('show: %s has no scene of %s, as recordings of before 0.2.0. Give it: show %s SCENE.yaml'
                 % (path, ', '.join(without), path))
    try:
        urdfs = {node: urdf_of(str(EQUATIONS.parent / 'simulate'), scene, node, node + '/view/chain' in topics)
                 for node, scene in scenes.items()}
        trees = {node: tree_of(scene) for node, scene in scenes.items()}
    except (ValueError, yaml.YAMLError) as refused:
        refuse('show: %s: the scene%s is refused:\n%s' % (path, ' in ' + given if given else '', refused))
    require_display()
    with Master() as master:
        rospy.set_param('/use_sim_time', True)
        for node, urdf in urdfs.items():
            rospy.set_param(rosgraph.names.namespace(node) + 'robot_description', urdf)
        play = Play(master, path, topics, options)
        try:
            return show_nodes(list(scenes), [], list(trees.values()), pathlib.Path(path).stem,
                              play.maybe_start)
        except NoBag as refused:
            refuse('show: %s' % refused)
        finally:
            play.end()


def end(*_):
    """Ends by an exception, so that the programs that were started end too."""
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    sys.exit(128 + signal.SIGTERM)


def main():
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, end)
    arguments = rospy.myargv()[1:]
    if not arguments:
        refuse(__doc__)
    if arguments[0] in ('-h', '--help'):
        put(__doc__ + '\n')
        return 0
    if arguments[0].endswith(ENDINGS):
        return show_bag(arguments[0], arguments[1:])
    names = [argument for argument in sys.argv[1:] if argument not in arguments]  # such as __name:=rviz
    if os.path.isfile(arguments[0]) or '.' in arguments[0]:  # which no name of ROS has
        if not arguments[0].endswith('.rviz') or not os.path.isfile(arguments[0]):
            refuse('show: %s: expected a bag (plot draws a CSV), or a file of rviz, whose name ends in .rviz' % arguments[0])
        require_master()
        return show_config(arguments[0], arguments[1:], names)
    given = list(itertools.takewhile(lambda argument: not argument.startswith('-'), arguments))
    nodes = [('/' + name.strip('/')).rstrip('/') + '/planar_chain' for name in given]
    require_master()
    missing = [node for node in nodes if not rospy.has_param(node)]
    if missing:
        refuse('show: %s: expected a running scene, a file of rviz or a bag, got nothing of this name' % ', '.join(missing))
    return show_nodes(nodes, arguments[len(given):], [rospy.get_param(node) for node in nodes], '_'.join(given))


if __name__ == '__main__':
    sys.exit(run(main, ()))
