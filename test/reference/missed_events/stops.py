#!/usr/bin/env python3
"""Prints the joint angles of hard.yaml and soft.yaml at 0.3 s, and when b comes to its stop and leaves it: by DOP853 of scipy, with
these instants as events. The centre of mass i is at c_i = sum_(j<i) e^(iθ_j) p_j + e^(iθ_i) s_i, and

    J_ij = ∂c_i/∂θ_j      M = Σ m_i Re(J_i* J_i^T) + diag(I)      M θ'' = Σ m_i Re(J_i* (g + Σ_j e^(iθ_j) r_ij ω_j²)) + torques"""

import os

import numpy as np
import yaml
from scipy.integrate import solve_ivp

END = 0.3
np.set_printoptions(precision=12)


def motion(scene):
    links = [scene['links'][name] for name in scene['chain']]
    joints = [link.get('joint', {}) for link in links]
    n = len(links)
    mass = np.array([link['mass'] for link in links])
    inertia = np.diag([link['inertia'] for link in links])
    arms = np.zeros((n, n), complex)  # of centre of mass i in link j
    for i in range(n):
        for j in range(i):
            arms[i, j] = complex(*links[j]['pin'])
        arms[i, i] = complex(*links[i]['com'])
    gravity = complex(*scene['gravity'])
    limit = joints[1]['lower']

    def slope(_, y, touches):
        theta, omega = y[:n], y[n:]
        along = arms * np.exp(1j * theta)
        columns = 1j * along
        m = np.real(columns.conj().T @ (mass[:, None] * columns)) + inertia
        force = mass * (gravity + along @ omega**2)
        torque = np.real(columns.conj().T @ force)
        q, rate = np.diff(theta, prepend=0), np.diff(omega, prepend=0)
        tau = np.array([-joint.get('drag', 0) * v * abs(v) for joint, v in zip(joints, rate)])
        if touches:
            tau[1] += joints[1]['stop_stiffness'] * (limit - q[1])
        torque += tau - np.append(tau[1:], 0)
        return np.concatenate([omega, np.linalg.solve(m, torque)])

    def gap(_, y, _touches):
        return y[1] - y[0] - limit

    gap.terminal = True
    q = np.array([link['initial']['angle'] for link in links])
    rates = np.array([link['initial'].get('velocity', 0) for link in links])
    y, t, touches, instants = np.concatenate([np.cumsum(q), np.cumsum(rates)]), 0.0, True, []
    while t < END:
        gap.direction = 1 if touches else -1
        run = solve_ivp(slope, (t, END), y, 'DOP853', args=(touches,), events=gap, rtol=1e-13, atol=1e-14, max_step=1e-3)
        t, y = run.t[-1], run.y[:, -1]
        if t < END:
            instants.append(t)
            touches = not touches
    return np.diff(y[:n], prepend=0), instants


for name in ('hard', 'soft'):
    with open(os.path.join(os.path.dirname(__file__), name + '.yaml'), encoding='utf-8') as file:
        print(name, *motion(yaml.safe_load(file)))
