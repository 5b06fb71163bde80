#!/usr/bin/python3
"""A rod whose motor is too weak to lift it at once is swung up by pumping energy, then held by state feedback.
The gain comes from linearize()."""
import numpy as np
from planar_chain import Environment, linearize

ROD = {'mass': 1.0, 'inertia': 1 / 12, 'com': [0.5, 0.0], 'pin': [1.0, 0.0], 'initial': {'angle': -np.pi / 2}}
MOST, INERTIA, WEIGHT = 2.0, 1 / 3, 9.81 / 2   # N m, kg m², N m: the motor cannot lift the rod at once


class SwingUp(Environment):
    def __init__(self):
        super().__init__({'chain': ['rod'], 'links': {'rod': ROD}}, motors={'rod_joint': MOST}, period=0.02, longest=1000)

    def first_state(self, random):
        return [-np.pi / 2 + random.normal(scale=0.1)], [0.0]

    def reward(self, q, qd, action):
        return np.sin(q[0]) - 0.1 * qd[0] ** 2 - 0.01 * action[0] ** 2


def upright_gain(scene):
    """u = -gain·x by which both eigenvalues of A - B gain are -6/s."""
    A, B = linearize(scene, q=[np.pi / 2], qd=[0.0])
    return np.array([A[1, 0] + 36, A[1, 1] + 12]) / B[1, 0]


def policy(observation, gain):
    s, c, rate = observation
    if s > 0.95 and abs(rate) < 2:
        return np.clip(-gain @ [np.arctan2(-c, s), rate] / MOST, -1, 1)      # hold it
    energy = INERTIA * rate ** 2 / 2 + WEIGHT * (s - 1)      # 0: just enough to get up
    return -np.sign(energy * rate + 1e-9)                    # pump


env = SwingUp()
gain = upright_gain(env.scene)
observation, _ = env.reset(seed=1)
total, late = 0.0, False
while not late:
    observation, reward, _, late, info = env.step(policy(observation, gain))
    total += reward
print('after 20 s: %.6f rad from upright, return %.0f' % (abs(np.arctan2(-observation[1], observation[0])), total))
