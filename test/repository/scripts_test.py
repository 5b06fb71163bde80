#!/usr/bin/python3
"""The scripts of the repository: launch/arguments, launch/record.sh, .ci/run, ROS in /opt/ros, and that one build serves launch/sim and
test/run. What the build needs and is missing is named at once.

    scripts_test.py [-DNAME=VALUE … for cmake] [unittest options]
"""

import os
import re
import shutil
import subprocess
import sys
import unittest

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), '../support'))
from in_folder import InFolder  # noqa: E402

CONFIGURATION = [argument for argument in sys.argv if argument.startswith('-D')]
ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '../..')
ROPE = os.path.join(ROOT, 'config/scenes/rope.yaml')


class Arguments(InFolder):
    def run_script(self, *arguments):
        run = subprocess.run([os.path.join(ROOT, 'launch/arguments'), '--', *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                             env={**os.environ, 'ROS_MASTER_URI': 'http://localhost:1', 'CMAKE_PREFIX_PATH': ''}, universal_newlines=True, check=False)
        self.assertEqual(run.stdout, '')
        return run.returncode, run.stderr

    def test_arguments_of_sim_launch_and_options_of_roslaunch_pass(self):
        for given in ((), ('scene:=rope', 'rviz:=false'), ('-p', '11411'), ('--port=11411', 'scene:=whip'),
                      ('--screen', '__name:=sim', 'record:=run'), ('real_time_factor:=.5', 'rviz:=False'), ('real_time_factor:=1e2', 'record:=false'),
                      ('scene_file:=' + ROPE, 'urdf:=none'), ('scene_file:=none', 'scene:=rope')):
            self.assertEqual(self.run_script(*given), (0, ''))

    def test_others_are_refused(self):
        for given, words in ((('sceen:=rope',), 'sim.launch has no argument sceen. It has: scene urdf '),
                             (('-p', '11411', 'rvis:=false'), 'sim.launch has no argument rvis.'),
                             (('owns_clock:=true',), 'sim.launch has no argument owns_clock.'),
                             (('scene_file:=/none.yaml',), 'scene_file: expected a file that can be read, got /none.yaml'),
                             (('urdf:=/',), 'urdf: expected a file that can be read, got /\n'),
                             (('rviz:=no',), 'rviz: expected true or false, got no'),
                             (('respawn:=yes',), 'respawn: expected true or false, got yes'),
                             (('real_time_factor:=abc',), 'real_time_factor: expected a number from 0 to 1000, got abc'),
                             (('real_time_factor:=-1',), 'real_time_factor: expected a number from 0 to 1000, got -1'),
                             (('real_time_factor:=1001',), 'real_time_factor: expected a number from 0 to 1000, got 1001'),
                             (('record:=/none/run',), 'record: expected a path in a folder that can be written, got /none/run'),
                             (('record:=2026.10',), 'record: expected a name that is neither a number nor true, which roslaunch rewrites, such as run_2026.10, got 2026.10'),
                             (('record:=',), 'record: expected the name of a bag, or false, got nothing'),
                             (('record:=/tmp/',), 'record: expected the name of a bag, got the folder /tmp/'),
                             (('record:=true',), 'such as run_true, got true'),
                             (('record:=run:=x',), 'record: expected a value without :=, with which roslaunch ignores it, got run:=x'),
                             (('--scene', 'rope'), 'Expected scene:=VALUE, got --scene'),
                             (('scene:=rop',), 'No scene is called rop. There are: acrobot '),
                             (('scene_file:=' + ROPE, 'scene:=rope'), 'Expected scene:= or scene_file:=, got both'),
                             (('scene:=rope', 'urdf:=' + ROPE), 'Expected scene:= or urdf:=, got both'),
                             (('rope',), 'Expected NAME:=VALUE, got rope')):
            status, said = self.run_script(*given)
            self.assertEqual(status, 2)
            self.assertIn(words, said)

    def test_a_urdf_is_no_scene_file(self):
        for text, refused in (('\n<robot name="r"/>\n', True), ('<<: {gravity: [0, 0]}\n', False)):
            with open(self.path('robot'), 'w', encoding='ascii') as file:
                file.write(text)
            said = f'scene_file: expected a scene in YAML, got a URDF (give it with urdf:={self.path("robot")})\n'
            self.assertEqual(self.run_script('scene_file:=' + self.path('robot')), (2, said) if refused else (0, ''))


class Recorder(InFolder):
    def record(self, bag):
        run = subprocess.run(['bash', os.path.join(ROOT, 'launch/record.sh'), 'echo', '-O', bag, '@joint_states', '/tf', '__name:=record'],
                             env={**os.environ, 'ROS_NAMESPACE': '/left/', 'ROS_MASTER_URI': 'http://localhost:1'},
                             stdout=subprocess.PIPE, universal_newlines=True, check=True)
        return run.stdout.splitlines()

    def test_an_earlier_bag_is_kept(self):
        topics = '/left/joint_states /tf __name:=record'
        run = self.path('a run')
        self.assertEqual(self.record(run), [f'-O {run} {topics}'])
        for there, number in (('.bag', 2), ('_2.bag.active', 3)):  # active: it is being recorded, or its recorder was killed
            with open(run + there, 'w', encoding='ascii'):
                pass
            for name in (run, run + '.bag'):
                self.assertEqual(self.record(name), [f'record: {run}.bag is there already; recording to {run}_{number}.bag',
                                                     f'-O {run}_{number} {topics}'])


    def test_what_a_bag_lacks_is_said(self):
        try:
            import rosbag  # pylint: disable=import-outside-toplevel
            from genpy import Time  # pylint: disable=import-outside-toplevel
            from std_msgs.msg import Header, String  # pylint: disable=import-outside-toplevel
            from geometry_msgs.msg import PointStamped  # pylint: disable=import-outside-toplevel
        except ImportError as missing:
            self.skipTest(str(missing))
        for name, lost in (('whole', ()), ('lacks', (4, 5)), ('ends', (0, 9))):  # the first and the last cannot be known to lack
            bag = self.path(name)
            with rosbag.Bag(bag + '.bag', 'w') as file:
                for k in set(range(10)) - set(lost):
                    file.write('/left/point', PointStamped(header=Header(seq=k)), Time(1 + 100 * k))
                    file.write('/left/word', String('x'), Time(1 + k))
            run = subprocess.run([sys.executable, os.path.join(ROOT, 'launch/recorded'), bag + '.bag'], stderr=subprocess.PIPE,
                                 universal_newlines=True, check=False)
            said = f'record: {bag}.bag lacks 2 of 10 messages of /left/point: the recorder was too slow. '
            self.assertEqual((run.returncode, run.stderr[:len(said)]), (1, said) if lost == (4, 5) else (0, ''))
        run = subprocess.run([sys.executable, os.path.join(ROOT, 'launch/recorded'), os.devnull], stderr=subprocess.PIPE,
                             universal_newlines=True, check=False)
        self.assertEqual((run.returncode, run.stderr), (1, 'record: /dev/null cannot be read: empty file\n'))
        recorder = self.path('recorder')
        with open(recorder, 'w', encoding='utf-8') as file:
            file.write(f'#!/bin/sh\ncp "{self.path("lacks")}.bag" "$2.bag"\n')
        os.chmod(recorder, 0o755)
        run = subprocess.run(['bash', os.path.join(ROOT, 'launch/record.sh'), recorder, '-O', self.path('made'), '/tf'],
                             stderr=subprocess.PIPE, universal_newlines=True, check=False)
        self.assertEqual(run.returncode, 1)
        self.assertIn(f'{self.path("made")}.bag lacks 2 of 10 messages of /left/point', run.stderr)


class Ci(InFolder):
    def test_all_runs_in_a_copy_with_a_blank_and_an_umlaut(self):
        for script in ('.ci/run', 'test/run', 'test/compilers', 'test/sanitized', 'build/log', 'build_other/log', 'gone'):
            os.makedirs(os.path.dirname(self.path(script)), exist_ok=True)
            with open(self.path(script), 'w', encoding='ascii') as file:
                file.write('#!/bin/bash\nmkdir -p build\nLC_ALL=C ls -A . .ci\ngit rev-parse --show-toplevel >>build/log\n')
            os.chmod(self.path(script), 0o755)
        shutil.copy(os.path.join(ROOT, '.ci/run'), self.path('.ci/run'))
        subprocess.run(['git', 'init', '-q', self.folder], check=True)
        copy = os.path.realpath(self.path('.ci/Ordner für Tests/planar_chain'))
        for count, names in ((3, '.ci .git build gone test'), (6, '.ci .git build test')):
            said = subprocess.run([self.path('.ci/run')], stdout=subprocess.PIPE, universal_newlines=True, check=True).stdout
            self.assertEqual(said, 3 * '\n'.join(['.:', *names.split(), '', '.ci:', 'run', '']))
            with open(os.path.join(copy, 'build/log'), encoding='utf-8') as log:  # the build of the copy stays
                self.assertEqual(log.read(), count * (copy + '\n'))
            if count == 3:
                os.remove(self.path('gone'))


class OptRos(InFolder):
    """launch/sim in a copy of the scripts, with a folder in the place of /opt/ros. ROS there has stand-ins that tell what they get."""

    def setUp(self):
        super().setUp()
        for folder in ('launch', 'config/scenes'):
            shutil.copytree(os.path.join(ROOT, folder), self.path(folder))
        with open(self.path('launch/prepare.sh'), 'r+', encoding='utf-8') as file:
            text = file.read()
            self.assertIn('"/opt/ros/$distro', text)
            file.seek(0)
            file.write(text.replace('/opt/ros', self.path('opt')))
        self.write('build/devel/setup.bash', '')

    def write(self, name, text):
        os.makedirs(os.path.dirname(self.path(name)), exist_ok=True)
        with open(self.path(name), 'w', encoding='utf-8') as file:
            file.write(text)
        os.chmod(self.path(name), 0o755)

    def put_ros(self, distro, marker='.catkin'):
        self.write('opt/%s/%s' % (distro, marker), '')
        self.write('opt/%s/setup.bash' % distro, 'export ENTERED=%s PATH="%s:$PATH"' % (distro, self.path('bin')))

    def script(self, command, **environment):
        """The last line of what a command prints in the folder."""
        run = subprocess.run(['bash', '-euc', command], cwd=self.folder, stdout=subprocess.PIPE, universal_newlines=True, check=True,
                             env={**{key: value for key, value in os.environ.items() if key != 'ROS_DISTRO'}, **environment})
        return run.stdout.splitlines()[-1]

    def test_the_one_of_ros_distro_comes_first(self):
        chosen = 'source launch/prepare.sh; echo "${ENTERED:-} $(printf "%s\n" "${to_run[@]}" "${to_test[@]}" | grep -E "tf$|rostest$|rviz$" | paste -sd " ")"'
        debian = ' rviz python3-rostest'
        self.put_ros('humble', marker='.colcon_install_layout')  # ROS 2
        self.assertEqual(self.script(chosen, ROS_DISTRO='humble'), debian)
        for distro, given, taken in (('noetic', {}, 'noetic'), ('one', {}, 'one'), ('other', {}, 'one'), ('', {'ROS_DISTRO': 'noetic'}, 'noetic'),
                                     ('', {'ROS_DISTRO': 'other'}, 'other'), ('', {'ROS_DISTRO': 'humble'}, 'one')):
            if distro:
                self.put_ros(distro)
            self.assertEqual(self.script(chosen, **given), '{0} ros-{0}-rviz ros-{0}-tf ros-{0}-rostest'.format(taken))

    def test_sim_starts_with_ros_one(self):
        self.put_ros('one')
        packages = self.script('source launch/prepare.sh; echo "${to_run[@]}"').split()
        self.assertIn('ros-one-ros-base', packages)
        self.write('bin/dpkg-query', '#!/bin/sh\nprintf "installed %s\\n" ' + ' '.join(packages))
        self.write('bin/cmake', '#!/bin/sh\necho "[100%] Building $ENTERED"')
        self.write('bin/roslaunch', '#!/bin/sh\necho "roslaunch $ENTERED $*"')
        self.assertEqual(self.script('launch/sim scene:=rope'), 'roslaunch one planar_chain sim.launch scene:=rope')


class Missing(InFolder):
    def test_all_that_is_missing_is_named_at_once(self):
        python = self.path('python3')
        with open(python, 'w', encoding='ascii') as file:
            file.write('#!/bin/sh\necho "/none;.so"\n')  # the folder of Python.h
        os.chmod(python, 0o755)
        run = subprocess.run(['cmake', '-S', ROOT, '-B', self.path('build'), '-DPLANAR_CHAIN_ROS=OFF', '-DSKBUILD=2', '-DPYTHON_EXECUTABLE=' + python,
                              '-DCMAKE_FIND_ROOT_PATH=/none', '-DCMAKE_FIND_ROOT_PATH_MODE_PACKAGE=ONLY', '-DCMAKE_FIND_ROOT_PATH_MODE_LIBRARY=ONLY'],
                             stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, universal_newlines=True, check=False)
        self.assertEqual(run.returncode, 1)
        line = ('sudo apt install libboost-program-options-dev libeigen3-dev libtinyxml2-dev libyaml-cpp-dev nlohmann-json3-dev python3-dev\n')
        self.assertIn(line, run.stderr)
        with open(os.path.join(ROOT, 'README.md'), encoding='utf-8') as page:
            self.assertTrue(set(line.split()) <= set(re.search(r'sudo apt install (?:.*\\\n)?.*', page.read()).group().split()))


class OneBuild(InFolder):
    def flags(self, script):
        """The compiler flags of the core with the options of this script."""
        with open(os.path.join(ROOT, script), encoding='utf-8') as file:
            options = re.search(r'\bbuild ((?:-D\S+[\s\\]*)+)', file.read()).group(1).replace("\\", "").split()
        subprocess.run(['cmake', '-S', ROOT, '-B', self.folder, *CONFIGURATION, *options],
                       stdout=subprocess.DEVNULL, check=True)
        with open(self.path('CMakeFiles/planar_chain_core.dir/flags.make'), encoding='utf-8') as file:
            return file.read()

    def test_both_scripts_compile_alike(self):
        self.assertEqual(self.flags('launch/sim'), self.flags('test/run'))

    def build(self, cmake):
        """Status, output and errors of a build by this shell function in the place of cmake."""
        script = 'set -euo pipefail; source launch/prepare.sh; cmake() { %s; }; build_in "$1" all -DA=1' % cmake
        run = subprocess.run(['bash', '-c', script, 'bash', self.path('build')], cwd=ROOT, stdout=subprocess.PIPE,
                             stderr=subprocess.PIPE, universal_newlines=True, check=False)
        return run.returncode, run.stdout, run.stderr

    def test_a_build_shows_how_far_it_is_and_errors_alone(self):
        steps = 'for k in $(seq -f "%3.0f" 0 3 99); do echo "[$k%] Building [ 50%]"; done'
        begin, log = 'Building (%s/build.log)' % self.path('build'), self.path('build/build.log')
        self.assertEqual(self.build(steps), (0, begin + ' 0% 12% 24% 36% 48% 60% 72% 84% 96%\n', ''))
        with open(log, encoding='ascii') as file:
            self.assertEqual(len(file.readlines()), 68)
        fails = 'echo "error: $*" >&2; return 1'
        error = 'error: -S . -B %s -DA=1\n' % self.path('build')
        self.assertEqual(self.build(fails), (1, begin + '\n', error))
        with open(self.path('build/CMakeCache.txt'), 'w', encoding='ascii'):
            pass
        self.assertEqual(self.build('echo "[ 50%] Built target a"; echo "[100%] Built target b"'), (0, '', ''))
        self.assertEqual(self.build('echo "[ 50%] Built target a"; echo "[ 60%] Linking b"; echo "[100%] Built target b"'),
                         (0, begin + ' 60% 100%\n', ''))
        self.assertEqual(self.build(fails), (1, '', error))


if __name__ == '__main__':
    unittest.main(argv=[argument for argument in sys.argv if argument not in CONFIGURATION])
