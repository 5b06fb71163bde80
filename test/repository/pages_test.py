#!/usr/bin/python3
"""The pages: links and anchors lead somewhere; scenes, commands and options in them exist; nothing that the node or a
tool has is missing; the tutorial, launch/README.md, does what it says when its steps are done one after the other.

    pages_test.py BIN [unittest options]        BIN: the folder that holds the tools; ROS's environment is needed
"""

import functools
import glob
import importlib.util
import math
import os
import re
import signal
import subprocess
import sys
import time
import unittest
import xml.etree.ElementTree

import rosgraph
import rospy
from sensor_msgs.msg import JointState

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), '../support'))
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), '../node'))
from in_folder import InFolder  # noqa: E402
from own_master import Master  # noqa: E402
from ros_node import LIMIT, Listener, Node, rod, upload  # noqa: E402

BIN = sys.argv.pop(1)
ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.realpath(__file__)), '../..'))
ROOMS = ('', 'config', 'include', 'launch', 'msg', 'src', 'srv', 'test')
PAGES = sorted({page for room in ROOMS
                for page in glob.glob(os.path.join(ROOT, room, '*.md')) +
                (glob.glob(os.path.join(ROOT, room, '**/*.md'), recursive=True) if room else [])})
HAS_PYTHON = importlib.util.find_spec('planar_chain._core') is not None  # built where pybind11 is
TOOLS = ('simulate', 'equations', 'stability', 'report', 'plot') + (('bode', 'fit', 'formulas', 'modes', 'sweep') if HAS_PYTHON else ())
BLOCK = re.compile(r'^```(\w*)\n(.*?)^```$', re.MULTILINE | re.DOTALL)

GOAL = (1.0, -1.6)      # rad, of the tutorial's crane
FIRST_LINE = 'off by -2.5708 and +1.6000 rad'  # of both its controllers
UPRIGHT = (0.0, 1.5708)  # m, rad, of its cart and pole
ARRIVED = 0.001         # rad; by topics, when the machine may be busy
STANDING = 200          # ticks in a row
RECORDED = 500          # states in the recording to fit: some seconds


def text_of(page):
    with open(page, encoding='utf-8') as file:
        return file.read()


def name_of(page):
    return os.path.relpath(page, ROOT)


@functools.lru_cache(maxsize=None)
def anchors_of(page):
    """The anchors that GitHub makes of headings."""
    found = {}
    for heading in re.findall(r'^#+ +(.*)$', BLOCK.sub('', text_of(page)), re.MULTILINE):
        plain = re.sub(r'\[([^]]*)\]\([^)]*\)', r'\1', heading)
        slug = re.sub(r'[^\w\- ]', '', plain.lower()).replace(' ', '-')
        found[slug] = found.get(slug, -1) + 1
    return {slug if k == 0 else '%s-%d' % (slug, k) for slug, last in found.items() for k in range(last + 1)}


def commands_in(text):
    """Each command of the shell blocks on a line of its own, without comments."""
    for language, body in BLOCK.findall(text):
        if language == 'sh':
            for line in body.replace('\\\n', ' ').splitlines():
                command = re.sub(r'(^|\s)#.*', '', line).strip()
                if command:
                    yield command


@functools.lru_cache(maxsize=None)
def help_of(tool):
    return subprocess.run([os.path.join(BIN, tool), '--help'], stdout=subprocess.PIPE, universal_newlines=True,
                          check=True).stdout


def options_of(tool):
    return set(re.findall(r'^ +(?:-h, ?)?(--[a-z][a-z-]*)', help_of(tool), re.MULTILINE))


def names_of(node):
    """Topics and services that the master knows it for."""
    return {name for kind in rosgraph.Master('/pages_test').getSystemState() for name, nodes in kind if node in nodes}


MASTER = Master()


def setUpModule():
    os.environ['PATH'] = '/usr/bin:' + os.environ['PATH']  # as the tutorial has it
    MASTER.__enter__()
    unittest.addModuleCleanup(MASTER.__exit__)
    rospy.init_node('pages_test', disable_signals=True)


# ---- The tutorial --------------------------------------------------------------------------------


def steps(text):
    """The blocks in order: ('file', name, body) for those to be saved, ('sh', command, '') for each command."""
    end = 0
    for block in BLOCK.finditer(text):
        language, body = block.groups()
        before, end = text[end:block.start()].rstrip(), block.end()
        name = re.search(r'Save\s+this\s+as\s+`([^`]+)`:$', before)
        if name:
            yield 'file', name.group(1), body
        elif language == 'sh':
            for command in commands_in(block.group()):
                yield 'sh', command, ''
        elif not language:
            yield 'said', '', body


class Reader:
    """One who does what the tutorial says, in a folder of his own."""

    BY_HAND = ('./launch/sim', 'export PATH', 'source build/devel', 'mkdir -p ../crane')  # the test has done these
    ENDLESS = {'./pd': GOAL, 'python3 pd.py': GOAL, 'python3 balance.py': UPRIGHT}

    def __init__(self, folder):
        self.folder = folder
        self.said = ''       # by the last command that ended
        self.controlled = []  # the controllers that have brought the crane to the goal
        self._launch = self._states = None

    def save(self, name, body):
        with open(os.path.join(self.folder, name), 'w', encoding='utf-8') as file:
            file.write(body)

    def start(self, command):
        return subprocess.Popen(['bash', '-c', 'exec ' + command], cwd=self.folder, start_new_session=True,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True)

    def end(self, process):
        """Ends a process by Ctrl-C, which all in the terminal get."""
        os.killpg(process.pid, signal.SIGINT)
        try:
            self.said = process.communicate(timeout=LIMIT)[0]
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            raise

    def end_launch(self):
        if self._launch:
            self._states.close()
            self.end(self._launch)
            self._launch = None

    def do(self, command):
        if command.startswith(self.BY_HAND):
            return
        if command.startswith('roslaunch'):
            self.end_launch()
            self._launch = self.start(command + ' rviz:=false')
            self._states = Listener('/joint_states', JointState)
            try:
                self._states.wait_for_count(1)
            except AssertionError as problem:
                self.end_launch()
                raise AssertionError(command + '\n' + self.said) from problem
            return
        if command in self.ENDLESS:
            process = self.start(command)
            try:
                self._states.wait_for(Standing(self.ENDLESS[command]), after=len(self._states.messages))
            finally:
                self.end(process)
            assert re.search('off by|cart at', self.said) and 'Traceback' not in self.said, self.said
            if self.ENDLESS[command] == GOAL:
                assert re.search(r'off by .* rad', self.said).group() == FIRST_LINE, self.said
            self.controlled.append(command)
            return
        if 'run.bag' in command:
            self._states.wait_for_count(RECORDED)
        if 'crane.bag' in command or 'run.bag' in command:
            self.end_launch()
        warned = command.replace('-Wextra', '-Wextra -Werror')
        run = subprocess.run(['bash', '-c', warned], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                             universal_newlines=True, timeout=5 * LIMIT, check=False)
        assert run.returncode == 0, '%s: %d\n%s' % (command, run.returncode, run.stdout)
        self.said = run.stdout


class Standing:
    """True of a state that is the last of so many at the goal, up to whole turns."""

    def __init__(self, goal):
        self._goal, self._there = goal, 0

    def __call__(self, state):
        near = all(abs(math.remainder(q - goal, 2 * math.pi)) < ARRIVED for q, goal in zip(state.position, self._goal))
        self._there = self._there + 1 if near else 0
        return self._there >= STANDING


class Tutorial(InFolder):
    def setUp(self):
        super().setUp()
        self.text = text_of(os.path.join(ROOT, 'launch/README.md'))

    def test_does_what_it_says_step_by_step(self):
        upload(rod(), '/planar_chain')  # what another launch may have left
        reader = Reader(self.folder)
        heard = {}
        try:
            for kind, what, body in steps(self.text):
                if kind == 'file':
                    reader.save(what, body)
                elif kind == 'sh':
                    reader.do(what)
                    heard[what] = reader.said
                else:
                    self.assertEqual(reader.said, body)
        finally:
            reader.end_launch()
        self.assertEqual(reader.controlled, ['./pd', 'python3 pd.py', 'python3 balance.py'])
        self.assertEqual(heard['python3 pd_step.py'].count('off by'), 5)
        rates = [float(rate) for rate in re.findall(r'qd = +(\S+)', self.only(heard, 'simulate crane.yaml --duration'))]
        self.assertIn('no faults: 2 links', self.only(heard, 'simulate crane.yaml --check'))
        self.assertEqual(len(rates), 2)
        self.assertLess(max(map(abs, rates)), 1e-6)
        self.assertIn('[ -33.5383 -8.09654 ]', self.only(heard, 'equations'))
        for picture in ('crane.bag.png', 'strobe.png'):
            self.assertTrue(os.path.exists(self.path(picture)), picture)

    @staticmethod
    def only(heard, tool):
        (said,) = [said for command, said in heard.items() if f' {tool} ' in f'{command} ']
        return said

    def test_controllers_are_as_short_as_promised(self):
        lines = {name: body.count('\n') for kind, name, body in steps(self.text) if kind == 'file'}
        self.assertLessEqual(max(lines['pd.cpp'], lines['balance.py']), 40)
        self.assertLessEqual(max(lines['pd.py'], lines['pd_step.py']), 30)


# ---- All pages -----------------------------------------------------------------------------------


class Pages(InFolder):
    def test_links_lead_somewhere(self):
        for page in PAGES:
            prose = BLOCK.sub('', text_of(page))
            for target in re.findall(r'\]\(([^)\s]+)\)', prose):
                if target.startswith(('http://', 'https://')):
                    continue
                path, _, anchor = target.partition('#')
                there = os.path.normpath(os.path.join(os.path.dirname(page), path)) if path else page
                with self.subTest(page=name_of(page), link=target):
                    self.assertTrue(os.path.exists(there))
                    if anchor:
                        self.assertIn(anchor, anchors_of(there))

    def test_scenes_are_accepted(self):
        count = 0
        for page in PAGES:
            for language, body in BLOCK.findall(text_of(page)):
                if language == 'yaml' and body.startswith('chain:'):
                    count += 1
                    with open(self.path('scene.yaml'), 'w', encoding='utf-8') as file:
                        file.write(body)
                    run = subprocess.run([os.path.join(BIN, 'simulate'), self.path('scene.yaml'), '--duration', '0.1'],
                                         stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True,
                                         check=False)
                    with self.subTest(page=name_of(page)):
                        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertGreaterEqual(count, 2)

    def test_commands_name_tools_scenes_and_options_that_exist(self):
        count = 0
        for page in PAGES:
            for command in commands_in(text_of(page)):
                named = re.search(r'(?:rosrun planar_chain |\$bin/)(\w+)(.*)', command)
                with self.subTest(page=name_of(page), command=command):
                    for scene in re.findall(r'config/scenes/\w+\.yaml', command):
                        self.assertTrue(os.path.exists(os.path.join(ROOT, scene)))
                    if named:
                        count += 1
                        tool, rest = named.groups()
                        self.assertTrue(tool in ('bode', 'formulas', 'modes', 'sweep') and not HAS_PYTHON or os.access(os.path.join(BIN, tool), os.X_OK))
                        if tool in TOOLS:
                            self.assertEqual(set(re.findall(r'--[a-z][a-z-]*', rest)) - options_of(tool), set())
        self.assertGreaterEqual(count, 15)

    def test_the_program_for_cpp_is_the_one_that_is_tested(self):
        shown = [body for language, body in BLOCK.findall(text_of(os.path.join(ROOT, 'include/planar_chain/README.md')))
                 if language in ('cpp', 'cmake')]
        example = os.path.join(ROOT, 'test/cpp_example')
        self.assertEqual(shown, [text_of(os.path.join(example, name)) for name in ('main.cpp', 'CMakeLists.txt')])

    # ---- Nothing is missing ----

    def test_every_tool_has_its_place_and_its_options_exist(self):
        page = text_of(os.path.join(ROOT, 'src/tools/README.md'))
        for tool in TOOLS:
            with self.subTest(tool=tool):
                (row,) = re.findall(r'^### `%s`\n(.*?)(?=^##)' % tool, page, re.MULTILINE | re.DOTALL)
                named = set(re.findall(r'`(--[a-z][a-z-]*)', row))
                self.assertEqual(named - options_of(tool), set())

    def keys_refused_at(self, path, scene):
        """The keys that the reader lists in its fault for an unknown one."""
        with open(self.path('scene.yaml'), 'w', encoding='utf-8') as file:
            file.write(scene)
        run = subprocess.run([os.path.join(BIN, 'simulate'), self.path('scene.yaml'), '--duration', '0.1'],
                             stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True, check=False)
        (keys,) = re.findall(r'^(?:.*:[0-9]+: )?%s: expected one of (?:the keys )?(.*), got "unknown"$' % path, run.stderr,
                             re.MULTILINE)
        return keys.split(', ')

    def test_every_key_and_method_of_a_scene_has_its_place(self):
        page = text_of(os.path.join(ROOT, 'config/README.md'))
        link = 'mass: 1, inertia: 1, com: [0, 0], pin: [1, 0]'
        count = 0
        for path, more, inside in (
                ('unknown', 'unknown: 1', ''),
                ('links/a/unknown', '', 'unknown: 1'),
                ('links/a/joint/unknown', '', 'joint: {unknown: 1}'),
                ('links/a/initial/unknown', '', 'initial: {unknown: 1}'),
                ('loads/b/unknown', 'loads: {b: {link: a, moment: 1, unknown: 1}}', ''),
                ('springs/b/unknown', 'springs: {b: {link: a, ground: [1, 1], stiffness: 1, unknown: 1}}', ''),
                ('links/a/drag/unknown', '', 'drag: {coefficient: 1, unknown: 1}'),
                ('integrator/unknown', 'integrator: {unknown: 1}', ''),
                ('integrator/method', 'integrator: {method: unknown}', ''),
                ('base/unknown', 'base: {unknown: 1}', ''),
                ('base/x/unknown', 'base: {x: {unknown: 1}}', ''),
                ('publish/unknown', 'publish: {unknown: 1}', '')):
            for key in self.keys_refused_at(path, 'chain: [a]\nlinks: {a: {%s, %s}}\n%s\n' % (link, inside, more)):
                count += 1
                group = path.split('/')[2] + '/' if path.count('/') == 3 else ''
                with self.subTest(key=path.replace('unknown', key)):
                    self.assertTrue(key in ('joint', 'initial')  # maps, whose keys have theirs
                                    or re.search(r'^\|[^|]*`%s%s`' % (group, key), page, re.MULTILINE))
        self.assertGreaterEqual(count, 40)

    def test_every_key_of_a_joint_has_its_unit_in_plots_and_its_place_in_formulas(self):
        scene = 'chain: [a]\nlinks: {a: {mass: 1, inertia: 1, com: [0, 0], pin: [1, 0], joint: {%s}}}\n'
        keys = set(self.keys_refused_at('links/a/joint/unknown', scene % 'unknown: 1'))
        of_motors = set(self.keys_refused_at('links/a/joint/motor/unknown', scene % 'motor: {unknown: 1}'))
        words = {'name', 'type', 'drive', 'motor'}  # no numbers
        self.assertLess(words, keys)
        for path, needed in (('src/tools/plot_runs.py', (keys - words) | of_motors),
                             ('src/python/planar_chain/symbolic/chain.py', keys)):
            self.assertEqual(needed - set(re.findall(r'"(\w+)"', text_of(os.path.join(ROOT, path)))), set(), path)

    def test_every_argument_of_the_launch_file_has_its_place(self):
        page = text_of(os.path.join(ROOT, 'src/tools/README.md'))
        launch = xml.etree.ElementTree.parse(os.path.join(ROOT, 'launch/sim.launch'))
        for argument in launch.getroot().findall('arg'):
            if 'doc' in argument.attrib:
                with self.subTest(argument=argument.get('name')):
                    self.assertRegex(page, '(?m)^- `%s`[ :]' % argument.get('name'))

    def test_every_topic_and_service_of_the_node_has_its_place(self):
        page = text_of(os.path.join(ROOT, 'msg/README.md'))
        usual = ('/rosout', '/planar_chain/get_loggers', '/planar_chain/set_logger_level')
        with Node(rod(real_time_factor=0, tip={'line': {'point': [0.0, 0.0], 'direction': [1, 0]}})):
            rospy.wait_for_service('/planar_chain/step', LIMIT)
            names = names_of('/planar_chain')
            while True:  # until two looks agree: it registers one after the other
                time.sleep(0.5)
                before, names = names, names_of('/planar_chain')
                if before == names:
                    break
        self.assertLessEqual({'/planar_chain/view/energy', '/planar_chain/tip_wrench'}, names)
        for name in names - set(usual):
            with self.subTest(name=name):
                view = name.startswith('/planar_chain/view/')
                self.assertIn('`%s`' % (name.rpartition('/')[2] if view else name.lstrip('/')),
                              page.replace('`/', '`'))


if __name__ == '__main__':
    unittest.main(warnings='ignore')  # of sockets that ROS leaves open
