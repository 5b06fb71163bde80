#!/usr/bin/python3
"""Disks that fill: under a node that the real rosbag records, and under simulate --bag at each of its last pages.

    disk_full_test.py BIN       BIN: the folder that holds simulate; ROS's environment is needed, and no master

The disk is a small tmpfs, which nobody else sees; where such a thing may not be mounted, the test is skipped (77).
"""

import os
import subprocess
import sys
import unittest

import roslib.packages
import rosbag
import rospy
from planar_chain.msg import LinkStates, SimStatus
from sensor_msgs.msg import JointState

from bag_load import faults_in
from ros_node import LIMIT, Listener, Node, nanoseconds, rod

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), '../support'))
from in_folder import InFolder  # noqa: E402
from own_master import Master  # noqa: E402

BIN = ''
SKIPPED = 77
PAGE = 4096


class DiskFull(InFolder):
    def setUp(self):
        super().setUp()
        self.disk = self.path('disk')
        os.mkdir(self.disk)
        subprocess.run(['mount', '-t', 'tmpfs', '-o', 'size=2m', 'tmpfs', self.disk], check=True)
        self.addCleanup(subprocess.run, ['umount', self.disk], check=True)

    def resize(self, size):
        subprocess.run(['mount', '-o', 'remount,size=%d' % size, self.disk], check=True)

    def test_a_recorder_that_dies_of_it_takes_nothing_with_it(self):
        scene = rod()
        scene['links']['rod'].update(repeat=50)
        bag = os.path.join(self.disk, 'run.bag')
        record = roslib.packages.find_node('rosbag', 'record')[0]
        with Master():
            rospy.init_node('disk_full', disable_signals=True)
            states = Listener('/joint_states', JointState)
            links = Listener('/planar_chain/link_states', LinkStates)
            statuses = Listener('/planar_chain/status', SimStatus)
            with Node(scene) as node:
                states.wait_for_count(1)
                # By itself rosbag would not begin on a disk with less than 1 GB left.
                recorder = subprocess.run([record, '-L', '1k', '-O', bag, '/joint_states', '/planar_chain/link_states'],
                                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True,
                                          timeout=LIMIT)
                self.assertIn('Error', recorder.stdout)  # which one, depends on what it was about to write
                self.assertNotEqual(recorder.returncode, 0)
                for listener in (states, links, statuses):
                    listener.wait_for_count(len(listener.messages) + 20)
            status, log = node.wait()
        self.assertEqual((status, 'WARN' in log, 'ERROR' in log), (0, False, False), log)
        self.assertEqual({status.fault for status in statuses.messages}, {''})
        for listener in (states, links):
            self.assertEqual(faults_in(list(map(nanoseconds, listener.messages)), 200, 'its stamps'), [])
        with self.assertRaises((rosbag.ROSBagUnindexedException, rosbag.ROSBagException)):
            rosbag.Bag(bag + '.active')

    def simulate(self):
        bag = os.path.join(self.disk, 'run.bag')
        scene = self.path('scene.yaml')
        with open(scene, 'w', encoding='ascii') as file:
            file.write('chain: [a]\nlinks: {a: {mass: 1, inertia: 1, com: [0, 1], pin: [0, 2]}}\n')
        run = subprocess.run([os.path.join(BIN, 'simulate'), scene, '--duration', '12', '--bag', bag],
                             stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True, timeout=LIMIT)
        return bag, run

    def test_simulate_says_so_and_leaves_no_bag_that_looks_whole(self):
        bag, run = self.simulate()
        self.assertEqual(run.returncode, 0, run.stderr)
        size = os.path.getsize(bag)
        self.assertGreater(size, 10 ** 6)  # more than a chunk
        os.remove(bag)

        pages = -(-size // PAGE)
        for missing in [1, 2, 3, 10, pages // 2, pages - 1, pages]:
            self.resize(PAGE * max(1, pages - missing))
            bag, run = self.simulate()
            self.assertEqual((run.returncode, run.stdout), (1, ''), missing)
            self.assertIn('cannot write %s: No space left on device' % bag, run.stderr)
            with self.assertRaises((rosbag.ROSBagUnindexedException, rosbag.ROSBagException)):
                rosbag.Bag(bag)
            os.remove(bag)

        self.resize(PAGE * pages)
        bag, run = self.simulate()
        self.assertEqual(run.returncode, 0, run.stderr)
        with rosbag.Bag(bag) as whole:
            self.assertEqual(whole.get_message_count('/joint_states'), 2400)


def in_a_namespace_of_its_own():
    """Runs this again where it may mount."""
    here = ['unshare', '--mount', *(['--map-root-user'] if os.geteuid() != 0 else [])]
    allowed = subprocess.run([*here, 'mount', '-t', 'tmpfs', 'tmpfs', '/mnt'], stderr=subprocess.PIPE, check=False)
    if allowed.returncode != 0:
        print('skipped: ' + allowed.stderr.decode())
        sys.exit(SKIPPED)
    os.execvp(here[0], [*here, 'env', 'MAY_MOUNT=1', sys.executable, *sys.argv])


if __name__ == '__main__':
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    if not os.environ.get('MAY_MOUNT'):
        in_a_namespace_of_its_own()
    BIN = sys.argv.pop(1)
    unittest.main(warnings='ignore')
