#!/usr/bin/env python3
"""Prints angle and rate of the wheel of turning_wheel.yaml at 0.3 s, and how often it passes its rest: by DOP853 of scipy, with the
instants of the rests as events. The rod turns on the wheel's centre, so the pin adds no inertia: with absolute angles

    0.06 θ₁'' = k (θ₂ − θ₁) + d (ω₂ − ω₁) − c sign ω₁        0.02 θ₂'' = −k (θ₂ − θ₁) − d (ω₂ − ω₁)

where 0.06 is the wheel's inertia and the rod's mass at its pin."""

import numpy as np
from scipy.integrate import solve_ivp

K, D, C, END = 20000.0, 0.02, 1.0, 0.3


def torque(y):
    return K * (y[1] - y[0]) + D * (y[3] - y[2])


def slope(_, y, sign):
    return [y[2], y[3], (torque(y) - C * sign) / 0.06, -torque(y) / 0.02]


def rest(_, y, _sign):
    return y[2]


t, y, passed, sign = 0.0, np.array([0, 0.03, 9.3, 9.3]), 0, 1.0
rest.terminal = True
while t < END:
    rest.direction = -sign
    run = solve_ivp(slope, (t, END), y, method="DOP853", rtol=1e-12, atol=1e-14, events=rest, max_step=1e-4, args=(sign,))
    t, y = run.t[-1], run.y[:, -1].copy()
    if run.status == 1:
        assert abs(torque(y)) > C, "it sticks"
        y[2], sign, passed = 0.0, np.sign(torque(y)), passed + 1
print(f"{y[0]:.9f} {y[2]:.9f} {passed}")
