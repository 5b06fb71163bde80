#!/usr/bin/python3
"""How many calls of ~step a second a rospy client makes, over one connection, a tick a call; then with a tenth of the
calls and ten ticks each.

    step_speed.py [SECONDS]

needs a master (roscore) and runs the node itself.
"""

import sys
import time

import rospy
from planar_chain.srv import Step

from ros_node import Node, rod, service


def measure(step, ticks, seconds):
    """Calls a second."""
    calls, began = 0, time.monotonic()
    while time.monotonic() - began < seconds:
        assert step(torques=[0.1], n=ticks).success
        calls += 1
    return calls / (time.monotonic() - began)


def main():
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 5.0
    rospy.init_node('step_speed', anonymous=True)
    with Node(dict(rod(), real_time_factor=0)):
        step = service('step', Step)
        for ticks in (1, 10):
            print('%5d ticks a call: %.0f calls a second' % (ticks, measure(step, ticks, seconds)))


if __name__ == '__main__':
    main()
