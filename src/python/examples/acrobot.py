#!/usr/bin/python3
"""Random search for a controller of the acrobot: prints each episode that is better than all before."""
import numpy as np
from planar_chain import Environment

ROD = {'mass': 1.0, 'inertia': 1 / 12, 'com': [0.5, 0.0], 'pin': [1.0, 0.0]}
HANGING = {'initial': {'angle': -np.pi / 2}}


class Acrobot(Environment):
    """A motor in the hip alone. The feet have to come 1 m above the bar, soon."""

    def __init__(self):
        scene = {'chain': ['body', 'legs'], 'links': {'body': {**ROD, **HANGING}, 'legs': ROD}}
        super().__init__(scene, motors={'legs_joint': 5.0}, period=0.1, longest=300)

    def reward(self, q, qd, action):
        return 0.0 if self.is_over(q, qd) else -1.0

    def is_over(self, q, qd):
        return np.sin(q[0]) + np.sin(q[0] + q[1]) > 1.0  # m, height of the feet


def episode(env, weights):
    observation, _ = env.reset()
    total, over, late = 0.0, False, False
    while not over and not late:
        observation, reward, over, late, _ = env.step(np.tanh(weights @ observation))
        total += reward
    return total


env, random = Acrobot(), np.random.default_rng(1)
best, most = np.zeros((1, 6)), -np.inf
for k in range(100):                     # random search: keep what is better
    weights = best + random.normal(size=best.shape)
    total = episode(env, weights)
    if total > most:
        best, most = weights, total
        print('episode %d: up after %.1f s' % (k, -total * env.period) if total > -300 else 'episode %d: never up' % k)
