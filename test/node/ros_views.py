#!/usr/bin/python3
"""What acts, as markers: a hanging rod, whose forces, spring, centre of mass and energy are known."""

import math
import os
import pathlib
import sys
import tempfile
import unittest
import unittest.mock
from xml.etree import ElementTree

import PIL.ImageFont
import roslib.packages
import rospy
import rostest
import yaml
from planar_chain.srv import SetState
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from ros_node import Listener, Node, rod, service

PACKAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), '../..')
sys.path.append(os.path.join(PACKAGE, 'src', 'tools'))
import chain  # noqa: E402
import show  # noqa: E402

WEIGHT = 2.0 * 9.81  # N: half a unit, which is the rod's length here, 1 m


def hanging(**joint):
    """It stays where it is, but for its spring; half its weight is carried at its tip."""
    scene = rod(gravity=[0.0, -9.81], loads={'lift': {'link': 'rod', 'force': [0.0, WEIGHT / 2], 'point': [1.0, 0.0]}})
    scene['links']['rod'].update(com=[0.5, 0.0], initial={'angle': -math.pi / 2}, joint=joint)
    return scene


def corners(marker):
    return [(point.x, point.y) for point in marker.points]


FONT = PIL.ImageFont.truetype('/usr/share/fonts/truetype/liberation/LiberationSans-Regular.ttf', 24)  # of rviz, as it draws it
FONT_HEIGHT = 28  # px: rviz makes this as high as the text's size


def width_of(text, marker):
    """The width of a text in rviz, m. A space is as wide as an A."""
    return sum(round(FONT.getlength(letter.replace(' ', 'A'))) for letter in text) / FONT_HEIGHT * marker.scale.z


def box(marker):
    """Left, right, low and high edge of a text in rviz, m."""
    width = width_of(marker.text, marker)
    x, y = marker.pose.position.x, marker.pose.position.y
    return x - width / 2, x + width / 2, y - marker.scale.z / 2, y + marker.scale.z / 2


class Views(unittest.TestCase):
    def see(self, scene, *names, which=0):
        """A message of each view, the first if not said."""
        topics = {name: Listener('/planar_chain/view/' + name, MarkerArray) for name in names}
        with Node(scene):
            for listener in topics.values():
                listener.wait_for_count(max(3, which + 1))
        for listener in topics.values():
            listener.close()
        return [topics[name].messages[which] for name in names]

    @staticmethod
    def energies(array):
        return {label: float(number) for number, _, label in (marker.text.split() for marker in array.markers)}

    def only(self, array, frame):
        """The one marker, in this frame and moving with it."""
        self.assertEqual([(marker.header.frame_id, marker.frame_locked, marker.action, marker.type)
                          for marker in array.markers], [(frame, True, Marker.ADD, Marker.TRIANGLE_LIST)])
        marker = array.markers[0]
        self.assertGreater(marker.header.stamp.to_sec(), 1)
        self.assertEqual(len(marker.points), len(marker.colors))
        return marker

    def assert_arrow(self, marker, tail, head):
        """Two bands of two triangles: the shaft, and a head that ends in a point."""
        points = corners(marker)
        self.assertEqual(len(points), 12)
        for k in (0, 1):
            self.assertAlmostEqual((points[0][k] + points[5][k]) / 2, tail[k], delta=1e-9)
            self.assertAlmostEqual(points[7][k], head[k], delta=1e-9)
            self.assertAlmostEqual(points[8][k], head[k], delta=1e-9)

    def test_forces_centre_and_energy_of_a_hanging_rod(self):
        loads, pins, centres, energy = self.see(hanging(), 'loads', 'pin_forces', 'centres', 'energy')
        # Up is −x for the rod; half its weight is a quarter of a metre.
        self.assert_arrow(self.only(loads, 'rod'), (1.0, 0.0), (0.75, 0.0))
        self.assert_arrow(self.only(pins, 'rod'), (0.0, 0.0), (-0.25, 0.0))
        sign = corners(self.only(centres, 'rod'))
        self.assertAlmostEqual(min(x for x, _ in sign) + max(x for x, _ in sign), 1.0, delta=1e-2)
        self.assertIn((0.5, 0.0), sign)
        lines = self.energies(energy)
        self.assertEqual(lines['potential'], -9.81)
        # Rounding errors read 0.
        self.assertEqual((lines['kinetic'], lines['balance']), (0, 0))

    def test_the_text_shows_the_time_and_stands_beside_the_reach(self):
        energy, = self.see(rod(publish={'rate': 200.0, 'tf_rate': 50.0}, real_time_factor=1), 'energy', which=40)
        self.assertEqual(energy.markers[0].text, '%.2f s time' % energy.markers[0].header.stamp.to_sec())
        boxes = list(map(box, energy.markers))
        for left, right, low, high in boxes:
            self.assertTrue(-show.ASPECT * show.FREE < left < right and -show.FREE < low < high)
            self.assertGreater(math.hypot(min(0, right), min(0, high)), 1.0)  # the reach

    def test_numbers_end_and_labels_begin_below_each_other(self):
        """Each line is one text: in a view that is turned, two would part. rviz centres a text on its place, and its font has letters of
        different widths."""
        texts = Listener('/planar_chain/view/energy', MarkerArray)
        scene = hanging(damping=0.1)
        scene['links']['rod']['initial']['velocity'] = 3.0
        with Node(scene):
            texts.wait_for_count(60)
        texts.close()
        self.assertGreater(len({marker.text for array in texts.messages for marker in array.markers}), 60)
        size = texts.messages[0].markers[0].scale.z
        labels = [box(marker)[1] - width_of(marker.text.split()[2], marker) for array in texts.messages for marker in array.markers]
        self.assertLess(max(labels) - min(labels), 0.05 * size)
        self.assertEqual({len(array.markers) for array in texts.messages}, {6})

    def test_the_text_is_in_the_view_of_every_scene(self):
        chain.EQUATIONS = roslib.packages.find_node('planar_chain', 'equations')[0]
        scenes = {}
        for name in ('bridge', 'crane', 'digger', 'falling_chain', 'finger', 'gantry', 'jump_rope', 'rope', 'shaken', 'slider_crank', 'telescope', 'thrown'):
            with open(os.path.join(PACKAGE, 'config', 'scenes', name + '.yaml'), encoding='utf-8') as file:
                scenes[name] = yaml.safe_load(file)
        scenes['tiny'] = rod()
        scenes['tiny']['links']['rod'].update(inertia='1e-9', com=[5e-4, 0], pin=[1e-3, 0])
        for name, scene in scenes.items():
            energy, = self.see(scene, 'energy')
            (x, y), half = show.view_of_scene(scene)
            self.assertEqual({marker.header.frame_id for marker in energy.markers},
                             {show.frame_of('/planar_chain', scene) or 'base_link'}, name)
            boxes = list(map(box, energy.markers))
            for (left, right, low, high), marker in zip(boxes, energy.markers):
                self.assertAlmostEqual(marker.scale.z, 0.055 * half, delta=1e-9 * half, msg=name)
                self.assertTrue(-show.ASPECT * half < left - x < right - x < 0 and -half < low - y < high - y < half, name)

    def test_arrows_end_in_the_view(self):
        # A rod that turns at 20 rad/s pulls its pin with 16 weights; a force pulls a stretched tip outwards.
        scene = hanging()
        scene['links']['rod']['initial']['velocity'] = 20.0
        scene['loads'] = {'out': {'link': 'rod', 'force': [0.0, -20 * WEIGHT], 'point': [1.0, 0.0]}}
        loads, pins = self.see(scene, 'loads', 'pin_forces')
        for array in (loads, pins):
            head = corners(self.only(array, 'rod'))[7]
            self.assertGreater(math.hypot(*head), 1.1)
            self.assertLess(math.hypot(*head), show.FREE)

    def test_the_centre_is_that_of_mass_and_what_motors_give_is_supplied(self):
        scene = rod(chain=['rod', 'feather'], loads={'motor': {'joint': 'rod_joint', 'torque': 5.0, 'stop': 0.1}})
        scene['links']['feather'] = {'mass': 0.02, 'inertia': 0.001, 'com': [10.0, 0.0], 'pin': [10.0, 0.0],
                                     'joint': {'damping': 1e-3}}
        centres, energy = self.see(scene, 'centres', 'energy', which=19)
        corner, = [corners(marker)[0] for marker in centres.markers if marker.header.frame_id == 'base_link']
        self.assertAlmostEqual(math.hypot(*corner), (2 * 0.4 + 0.02 * 11) / 2.02, delta=0.02)
        lines = self.energies(energy)
        supplied, dissipated, kinetic = (lines[name] for name in ('supplied', 'dissipated', 'kinetic'))
        self.assertGreater(supplied, kinetic)
        self.assertAlmostEqual(supplied - dissipated, kinetic, delta=0.01 * kinetic)

    def test_a_force_in_a_prismatic_joint_is_a_straight_arrow(self):
        # The rail is 2 m long to both sides, so half the view is 1.6 m + 1.25 m. The arrow of the weight is a quarter of that, the arrow of
        # a quarter of the weight half of that. It begins at the carriage's end, three widths of 0.09 · 0.5 m from its middle.
        weight = 3.0 * 9.81
        scene = rod(chain=['cart', 'rod'], gravity=[0.0, -9.81], loads={'push': {'joint': 'cart_joint', 'torque': -weight / 4}})
        scene['links']['cart'] = {'mass': 1.0, 'pin': [0.0, 0.0], 'joint': {'type': 'prismatic', 'axis': [3.0, 4.0]}}
        loads, = self.see(scene, 'loads')
        self.assert_arrow(self.only(loads, 'cart'), *[(-0.6 * x, -0.8 * x) for x in (0.135, 0.135 + 2.85 / 8)])
        # A drive that holds the cart against its load along the rail.
        scene['loads'] = {}
        scene['links']['cart']['joint'].update(axis=[0.0, 1.0], drive={'offset': 0.2})
        scene['links']['rod']['initial'] = {'angle': -math.pi / 2}
        drives, = self.see(scene, 'drives')
        self.assert_arrow(self.only(drives, 'cart'), (0.0, 0.135), (0.0, 0.135 + 3.25 / 4))

    def test_a_prismatic_joint_within_the_chain_is_drawn_along_its_axis(self):
        weight = 3.0 * 9.81
        scene = rod(chain=['rod', 'tube'], gravity=[0.0, -9.81], loads={'push': {'joint': 'tube_joint', 'torque': 2 * weight}})
        scene['links']['tube'] = {
            'mass': 1.0, 'pin': [0.5, 0.0], 'initial': {'position': 0.2},
            'joint': {'type': 'prismatic', 'axis': [3.0, 4.0], 'lower': -0.5, 'upper': 0.5, 'stiffness': 50.0, 'friction': 900.0}}
        loads, limits, springs, friction = self.see(scene, 'loads', 'limits', 'springs', 'friction')
        bar = 0.09 * 0.5  # of the tube's length
        self.assert_arrow(self.only(loads, 'tube'), *[(0.6 * x, 0.8 * x) for x in (bar, bar + 1.25 * 2 / 4)])
        marks = corners(self.only(limits, 'rod'))
        for band, limit in ((marks[:6], -0.5), (marks[6:], 0.5)):
            for k, expected in ((0, 1 + 0.6 * limit), (1, 0.8 * limit)):
                self.assertAlmostEqual(sum(corner[k] for corner in band) / 6, expected, delta=1e-9)
        coil = corners(self.only(springs, 'rod'))
        for (a, b), at in (((coil[0], coil[5]), -0.5), ((coil[-5], coil[-4]), 0.2)):
            for k, expected in ((0, 1 + 0.6 * at), (1, 0.8 * at)):
                self.assertAlmostEqual((a[k] + b[k]) / 2, expected, delta=1e-9)
        # A pad on both sides of the block; friction holds it.
        pads = self.only(friction, 'tube')
        along = [0.6 * x + 0.8 * y for x, y in corners(pads)]
        across = [0.6 * y - 0.8 * x for x, y in corners(pads)]
        for ends, expected in ((along, bar), (across, 1.65 * bar)):
            self.assertAlmostEqual(min(ends), -expected, delta=1e-9)
            self.assertAlmostEqual(max(ends), expected, delta=1e-9)
        self.assertGreater(pads.colors[0].g, pads.colors[0].r)

    def test_a_chain_without_a_link_that_turns_is_drawn(self):
        scene = rod(chain=['cart'], gravity=[0.0, -9.81])
        scene['links'] = {'cart': {'mass': 2.0, 'joint': {'type': 'prismatic', 'axis': [1.0, 0.0]}}}
        pins, = self.see(scene, 'pin_forces')
        self.assert_arrow(self.only(pins, 'cart'), (0.0, 0.0), (0.0, 0.5))
        chain.EQUATIONS = roslib.packages.find_node('planar_chain', 'equations')[0]
        self.assertEqual(show.view_of_scene(scene), ((0, 0), (2 + show.FREE) / show.ASPECT))

    def test_limits_are_drawn_where_they_are(self):
        scene = rod(chain=['cart', 'rod', 'tool'])
        scene['links']['cart'] = {'mass': 1.0, 'pin': [0.0, 0.0], 'joint': {'type': 'prismatic', 'axis': [1.0, 0.0], 'lower': -0.5, 'upper': 2.0}}
        scene['links']['rod']['joint'] = {'upper': 1.0}
        scene['links']['tool'] = dict(scene['links']['rod'], pin=[0.0, 1.0], com=[0.0, 0.5], joint={'lower': -0.25, 'upper': 0.5})
        limits, = self.see(scene, 'limits')
        base, cart, rod_ = (corners(marker) for marker in sorted(limits.markers, key=lambda marker: marker.header.frame_id))
        self.assertEqual([marker.header.frame_id for marker in limits.markers], ['base_link', 'cart', 'rod'])
        middle = [sum(x for x, _ in band) / 6 for band in (base[:6], base[6:])]
        for got, expected in zip(middle, (-0.5, 2.0)):
            self.assertAlmostEqual(got, expected, delta=1e-9)
        # A tick at a limit points as the link does there; a sector lies between two.
        def angle_of(band, x):
            return math.atan2(band[1][1] + band[2][1], band[1][0] + band[2][0] - 2 * x)
        self.assertEqual(len(cart), 6)
        self.assertAlmostEqual(angle_of(cart, 0), 1.0, delta=1e-9)
        directions = [math.atan2(y, x - 1) for x, y in rod_[12:] if (x, y) != (1, 0)]
        for got, expected in zip((angle_of(rod_[:6], 1), min(directions), angle_of(rod_[6:12], 1), max(directions)),
                                 (-0.25, -0.25, 0.5, 0.5)):
            self.assertAlmostEqual(got, math.pi / 2 + expected, delta=1e-9)

    def test_a_bar_has_its_length_in_words(self):
        chain.EQUATIONS = roslib.packages.find_node('planar_chain', 'equations')[0]
        small = rod()
        small['links']['rod'].update(inertia=1e-6, com=[0.02, 0.0], pin=[0.04, 0.0])
        for scene, words, length in ((rod(), '0.2 m', 0.2), (small, '10 mm', 0.01)):
            bar, text = self.see(scene, 'scale')[0].markers
            self.assertEqual((text.type, text.text), (Marker.TEXT_VIEW_FACING, words))
            left, right = (sum(edge(corner[0] for corner in corners(bar)[start:start + 6]) for edge in (min, max)) / 2
                           for start in (6, 12))
            self.assertAlmostEqual(right - left, length, delta=1e-9)
            (x, y), half = show.view_of_scene(scene)
            self.assertEqual(show.cell(half / show.CELLS), length)
            self.assertTrue(all(abs(corner[0] - x) < show.ASPECT * half and abs(corner[1] - y) < half for corner in corners(bar)))

    def test_the_ends_of_a_rail_are_in_the_view(self):
        chain.EQUATIONS = roslib.packages.find_node('planar_chain', 'equations')[0]
        for name, expected in (('cart_pole', (-1.5, 1.5)), ('gantry', (-1.0, 12.0)), ('slider_crank', (-0.8, 0.8))):
            with open(os.path.join(PACKAGE, 'config', 'scenes', name + '.yaml'), encoding='utf-8') as file:
                scene = yaml.safe_load(file)
            self.see(scene, 'energy')
            boxes = [visual for visual in ElementTree.fromstring(rospy.get_param('/robot_description')).findall(
                "link[@name='base_link']/visual") if visual.find('origin').get('rpy') == '0 0 0']
            rail = max(boxes, key=lambda visual: float(visual.find('geometry/box').get('size').split()[0]))
            (at, _, _), (length, width, _) = (map(float, text.split()) for text in (
                rail.find('origin').get('xyz'), rail.find('geometry/box').get('size')))
            over = 6 * width  # the carriage's length
            for end, limit in zip((at - length / 2 + over, at + length / 2 - over), expected):
                self.assertAlmostEqual(end, limit, delta=1e-9, msg=name)
            (x, _), half = show.view_of_scene(scene)
            self.assertLess(abs(at - x) + length / 2, show.ASPECT * half, name)

    def test_a_trail_begins_anew_where_the_state_is_set(self):
        scene = rod(gravity=[0.0, -9.81])
        scene['links']['rod']['initial'] = {'angle': 0.5, 'velocity': 1.0}
        trail = Listener('/planar_chain/view/trail', MarkerArray)
        with Node(scene):
            calls = (('settle', Trigger, {}), ('set_state', SetState, {'q': [2.0], 'qd': [0.0]}), ('reset', Trigger, {}))
            for name, kind, arguments in calls:
                trail.wait_for_count(len(trail.messages) + 12)
                service(name, kind)(**arguments)
            trail.wait_for_count(len(trail.messages) + 12)
            # Nobody watches for a while.
            trail.close()
            states = Listener('/joint_states', JointState)
            states.wait_for_count(60)
            states.close()
            later = Listener('/planar_chain/view/trail', MarkerArray)
            later.wait_for_count(12)
        later.close()
        lines = [corners(array.markers[0]) for listener in (trail, later) for array in listener.messages if array.markers]
        self.assertGreater(max(map(len, lines)), 5)
        # At 7 m/s, which its energy allows, it moves 0.14 m in 20 ms.
        self.assertLess(max(math.dist(*ends) for line in lines for ends in zip(line, line[1:])), 0.2)

    def test_a_spring_reddens_with_its_load_and_the_trail_begins_at_the_tip(self):
        slack, = self.see(hanging(stiffness=10.0, rest_angle=-math.pi / 2), 'springs')
        tense, trail = self.see(hanging(stiffness=10.0, rest_angle=0.0), 'springs', 'trail')
        slack, tense = (self.only(spring, 'rod').colors[0] for spring in (slack, tense))
        self.assertLess(slack.r, slack.b)
        self.assertGreater(tense.r, 3 * tense.b)
        # A trail of one point is not drawn. The first message deletes an older one.
        self.assertEqual([marker.action for marker in trail.markers], [])
        # Its newest part moves with the link, so that it ends at the tip even if rviz draws it late.
        moving = hanging()
        moving['links']['rod']['initial']['velocity'] = 3.0
        trail, = self.see(moving, 'trail', which=20)
        whole, end = trail.markers
        self.assertEqual((whole.header.frame_id, end.header.frame_id, len(end.points)), ('base_link', 'rod', 4))
        x, y = corners(end)[0]
        self.assertAlmostEqual(math.hypot(x - 1, y), 0, delta=1e-12)
        distances = [math.dist(*ends) for ends in zip(corners(end), corners(end)[1:])]
        for length, ends in zip(distances, zip(corners(whole)[::-1], corners(whole)[-2::-1])):
            self.assertAlmostEqual(length, math.dist(*ends), delta=1e-9)

    def test_rviz_looks_from_as_far_as_the_chain_is_long(self):
        with open(os.path.join(PACKAGE, 'config', 'planar_chain.rviz'), encoding='utf-8') as file:
            config = yaml.safe_load(file)
        chain.EQUATIONS = roslib.packages.find_node('planar_chain', 'equations')[0]
        scene = rod()
        scene['links']['rod'].update(repeat=100, com=['1e-2', 0.0], pin=[0.03, 0.04])
        centre, half = show.view_of_scene(scene)
        self.assertEqual(centre, (0, 0))  # without gravity
        self.assertAlmostEqual(half, show.FREE * 5, delta=1e-12)
        # From rest under gravity it stays in the lower half, below its highest point at first.
        scene['gravity'] = [0.0, -9.81]
        scene['links']['rod']['pin'] = [0.05, 0.0]
        (_, centre), half = show.view_of_scene(scene)
        self.assertLess(half, 0.8 * show.FREE * 5)
        self.assertLess(centre - half, -show.FREE * 5)
        self.assertGreater(centre + half, 0.3 * 5)
        for refused in ({}, {'chain': []}):
            self.assertEqual(show.view_of_scene(refused), ((0, 0), show.FREE * show.DEFAULT))
        # A chain between two pins stays within half its length of their middle.
        with open(os.path.join(PACKAGE, 'config', 'scenes', 'four_bar.yaml'), encoding='utf-8') as file:
            four_bar = show.view_of_scene(yaml.safe_load(file))
        for centre, half in (four_bar, show.together([four_bar, four_bar])):
            for got, expected in zip((*centre, half), (0.6, 0, show.FREE * 1.05)):
                self.assertAlmostEqual(got, expected, delta=1e-12)
        self.assertEqual([show.cell(size) for size in (0.7, 1.7, 45.0)], [0.5, 1, 20])
        show.fit(config, (2.0, -3.0), 6.25)
        manager = config['Visualization Manager']
        view = manager['Views']['Current']
        self.assertAlmostEqual(view['Distance'] * math.tan(view['Field of View'] / 2), 1.25 * 5, delta=1e-9)
        self.assertEqual(view['Focal Point'], {'X': 2, 'Y': 0, 'Z': -3})
        self.assertEqual(manager['Displays'][0]['Cell Size'], 1)
        shown = {display.get('Marker Topic') for display in manager['Displays']}
        self.assertLessEqual({'planar_chain/view/' + name for name in (
            'chain', 'loads', 'pin_forces', 'springs', 'friction', 'drives', 'trail', 'centres', 'limits', 'scale', 'energy')}, shown)

    def test_what_a_user_saves_of_rviz_is_kept(self):
        with tempfile.TemporaryDirectory() as home, unittest.mock.patch.dict(os.environ, HOME=home):
            path = pathlib.Path(show.kept('one', {'of': 1}))
            self.assertEqual(yaml.safe_load(path.read_text()), {'of': 1})
            os.utime(path, (1, 1))
            self.assertEqual((show.kept('one', {'of': 1}), path.stat().st_mtime), (str(path), 1))  # it is not written again
            show.kept('one', {'of': 2})  # the chain has become longer
            self.assertEqual(yaml.safe_load(path.read_text()), {'of': 2})
            for own in (path.read_text() + 'more: 3\n', 'of: saved by rviz\n', '\u00fc: 1\n'):
                path.write_text(own, encoding='latin-1')
                show.kept('one', {'of': 4})
                self.assertEqual(path.read_text(encoding='latin-1'), own)

    def test_a_long_chain_is_one_line_with_few_frames(self):
        scene = rod(gravity=[0.0, -9.81])
        scene['links']['rod'].update(repeat=10000, mass=1e-3, com=[0.0, '-1e-2'], pin=[0.0, '-1e-2'], inertia=0.0,
                                     joint={'damping': 1e-3})
        scene['publish'] = {'rate': 10.0, 'tf_rate': 10.0}
        scene['integrator'] = {'method': 'rodas5p', 'tolerance': 0.1}
        frames, states = Listener('/tf', TFMessage), Listener('/joint_states', JointState)
        array, pins = self.see(scene, 'chain', 'pin_forces')
        robot = rospy.get_param('/robot_description')
        frames.close()
        states.close()
        self.assertEqual({len(message.transforms) for message in frames.messages}, {50})
        self.assertEqual(frames.messages[0].transforms[-1].child_frame_id, 'rod_10000')
        self.assertEqual(len(states.messages[0].name), 10000)
        self.assertIn('<link name="base_link">', robot)
        self.assertNotIn('rod_', robot)
        line, = array.markers
        self.assertEqual((line.type, line.header.frame_id), (Marker.LINE_STRIP, 'base_link'))
        self.assertEqual(len(line.points), len(line.colors))
        self.assertLess(len(line.points), 5000)
        self.assertEqual(corners(line)[0], (0, 0))
        self.assertAlmostEqual(sum(map(math.dist, corners(line), corners(line)[1:])), 100, delta=0.1)
        self.assertGreater(line.scale.x, 0.015 * 100)
        # Links without a frame have their arrows in the base frame.
        self.assertTrue({marker.header.frame_id for marker in pins.markers} & {'base_link'})

    def test_drives_brakes_and_a_base_that_moves(self):
        # A driven joint holds the rod level; the base turns by a right angle, and friction holds what hangs on the rod.
        links = {'rod': dict(rod()['links']['rod'], joint={'drive': {'offset': -math.pi / 2}}),
                 'tool': dict(rod()['links']['rod'], joint={'friction': 9.0}, initial={'angle': -math.pi / 2})}
        base = {'x': {'offset': 3.0}, 'angle': {'offset': math.pi / 2}}
        scene = rod(chain=['rod', 'tool'], links=links, gravity=[0.0, -9.81], base=base)
        frames = Listener('/tf', TFMessage)
        (drives, sticks), robot = self.see(scene, 'drives', 'friction'), rospy.get_param('/robot_description')
        frames.close()
        # 2 · 9.81 N · (0.4 m + 1 m), in units of four times 9.81 N at half the reach of 2 m: the square root of that.
        arrow = self.only(drives, 'rod')
        tip = corners(arrow)[-2]
        sweep = 5 * math.sqrt(1.4 / 2)
        self.assertAlmostEqual(math.atan2(tip[1], tip[0]), sweep / 2, delta=1e-9)
        self.assertGreater(arrow.colors[0].b, arrow.colors[0].g)
        stuck = self.only(sticks, 'tool').colors[0]
        # Without enough friction it slides.
        links['tool']['joint']['friction'] = 0.5
        links['tool']['initial']['angle'] = -2.0
        slides, = self.see(scene, 'friction', which=5)
        slips = self.only(slides, 'tool').colors[0]
        self.assertGreater(stuck.g, stuck.r)
        self.assertGreater(slips.r, slips.g)
        # The ground is drawn where the base is.
        first, second = frames.messages[0].transforms[:2]
        self.assertEqual([first.header.frame_id, first.child_frame_id, second.header.frame_id, second.child_frame_id],
                         ['base_link', 'ground_pin', 'ground_pin', 'rod'])
        self.assertEqual((first.transform.translation.x, second.transform.translation.x), (3.0, 0.0))
        self.assertAlmostEqual(first.transform.rotation.z, math.sin(math.pi / 4), delta=1e-12)
        self.assertIn('<link name="base_link">\n</link>', robot)
        self.assertIn('<parent link="ground_pin"/><child link="rod"/>', robot)

    def test_a_robot_is_drawn_as_its_urdf_draws_it(self):
        body = ("<inertial><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial>"
                "<visual><origin xyz='0 0 -0.5' rpy='0 0 0.3'/><geometry><mesh filename='package://a/b.stl'/></geometry>"
                "<material name='ground'/></visual>")
        robot = ("<robot name='r'><material name='ground'><color rgba='1 0 0 1'/></material><link name='table'/>"
                 "<link name='arm'>%s</link><link name='hand'>%s</link>"
                 "<joint name='a' type='continuous'><parent link='table'/><child link='arm'/><axis xyz='0 1 0'/></joint>"
                 "<joint name='b' type='continuous'><parent link='arm'/><child link='hand'/><origin xyz='0 0.2 -1'/>"
                 "<axis xyz='0 1 0'/></joint></robot>") % (body, body)
        self.see({'robot_description': robot}, 'energy')
        root = ElementTree.fromstring(rospy.get_param('/robot_description'))
        self.assertEqual([material.get('name') for material in root.findall('material')], ['ground'])
        self.assertEqual([link.get('name') for link in root.findall('link') if link.find('visual') is not None],
                         ['arm', 'hand'])
        for link, depth in (('arm', 0.0), ('hand', 0.2)):
            visual = root.find("link[@name='%s']/visual" % link)
            self.assertEqual(visual.find('geometry/mesh').get('filename'), 'package://a/b.stl')
            self.assertEqual(visual.find('material').get('name'), 'ground')
            place = [float(number) for number in visual.find('origin').get('xyz').split()]
            for one, other in zip(place, (0.0, -0.5, depth)):
                self.assertAlmostEqual(one, other, delta=1e-12)
            # Its z is up in the plane, its x is turned by 0.3 about that.
            roll, pitch, yaw = map(float, visual.find('origin').get('rpy').split())
            z = (math.cos(yaw) * math.sin(pitch) * math.cos(roll) + math.sin(yaw) * math.sin(roll),
                 math.sin(yaw) * math.sin(pitch) * math.cos(roll) - math.cos(yaw) * math.sin(roll),
                 math.cos(pitch) * math.cos(roll))
            for one, other in zip(z, (0, 1, 0)):
                self.assertAlmostEqual(one, other, delta=1e-12)
            self.assertAlmostEqual(-math.sin(pitch), math.sin(0.3), delta=1e-12)

    def test_what_is_not_there_is_not_drawn(self):
        scene = hanging()
        del scene['loads']
        loads, springs = self.see(scene, 'loads', 'springs')
        self.assertEqual((loads.markers, springs.markers), ([], []))


if __name__ == '__main__':
    rospy.init_node('ros_views', anonymous=True)
    rostest.rosrun('planar_chain', 'ros_views', Views)
