#!/usr/bin/python3
"""A master of one's own, for checks that are run by hand or that must kill it; own_master.py COMMAND… runs one with it."""

import os
import socket
import subprocess
import sys
import tempfile
import time

import rosgraph


def free_port():
    with socket.socket() as one:
        one.bind(('', 0))
        return one.getsockname()[1]


class Master:
    """A bare rosmaster on a free port, so that nothing else tidies up; this process and those it starts use it."""

    def __enter__(self):
        self._logs = tempfile.TemporaryDirectory()
        os.environ['ROS_MASTER_URI'] = 'http://localhost:%d' % free_port()
        os.environ['ROS_LOG_DIR'] = self._logs.name
        self.start()
        return self

    def start(self):
        self._process = subprocess.Popen(
            ['rosmaster', '--core', '-p', os.environ['ROS_MASTER_URI'].rpartition(':')[2]],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        while not rosgraph.is_master_online():
            time.sleep(0.05)

    def kill(self):
        self._process.kill()
        self._process.wait()

    def __exit__(self, *_):
        self.kill()
        self._logs.cleanup()


if __name__ == '__main__':
    with Master():
        STATUS = subprocess.call(sys.argv[1:])
    sys.exit(abs(STATUS))
