#!/usr/bin/env python3
"""Prints each part of the motion of motor.yaml and the state at 0.25 s: by DOP853 of scipy, with the instants at which the motor
comes to its line, leaves it, and is faster than its no-load speed, as events:

    J q'' = τ − k q − d q'      T x' = u − x      τ = x, s l or 0      s = sign x      l = L (1 − s q'/ω_0)"""

import numpy as np
from scipy.integrate import solve_ivp

J, K, D, L, FASTEST, T = 0.1 + 0.5685998051954296**2, 100, 0.1, 0.5, 5, 0.01
np.set_printoptions(precision=13)


def side_of(y, u):
    return 1 if y[2] > 0 or (y[2] == 0 and u > 0) else -1


def place_of(y, u):
    s = side_of(y, u)
    line = L * (1 - s * y[1] / FASTEST)
    return 'free' if s * y[2] < line else 'line' if line > 0 else 'idle'


def slope(place, s, u):
    def of(_, y):
        torque = {'free': y[2], 'line': s * L - L / FASTEST * y[1], 'idle': 0}[place]
        return [y[1], (torque - K * y[0] - D * y[1]) / J, (u - y[2]) / T]
    return of


def changes(place, s):
    """Each is 0 where another place is due."""
    def beyond(_, y, side=s):
        return side * y[2] - L * (1 - side * y[1] / FASTEST)

    def standstill(_, y):
        return L * (1 - s * y[1] / FASTEST)

    def ahead(_, y):  # while x has this side
        return max(beyond(0, y, 1) if y[2] > 0 else -1, beyond(0, y, -1) if y[2] < 0 else -1)

    def empty(_, y):
        return s * y[2]

    events = {'free': [ahead], 'line': [beyond, standstill], 'idle': [standstill, empty]}[place]
    for event in events:
        event.terminal = True
    return events


t, y = 0.0, np.array([-1.6730199310440281, -0.009370372500910825, 0])
for end, u in ((0.2, -L), (0.25, 0.1)):
    while t < end:
        s, place = side_of(y, u), place_of(y, u)
        run = solve_ivp(slope(place, s, u), (t, end), y, 'DOP853', events=changes(place, s), rtol=1e-13, atol=1e-15, max_step=1e-4)
        print(place, t, run.t[-1], run.y[:, -1])
        t, y = run.t[-1], run.y[:, -1]
        if t < end:  # behind the change
            y = y + 1e-13 * np.array(slope(place, s, u)(t, y))
            t += 1e-13
