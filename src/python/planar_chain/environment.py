"""A scene to learn on: reset, step and spaces in the form of Gymnasium, which need not be there."""

import numpy as np

from planar_chain import Scene, Simulation


class Box:
    """The arrays of one shape between `low` and `high`."""

    dtype = np.dtype(float)

    def __init__(self, low, high):
        self.low, self.high = np.array(low, dtype=float), np.array(high, dtype=float)
        self.shape = self.low.shape
        self.seed()

    def seed(self, seed=None):
        self._random = np.random.default_rng(seed)

    def sample(self):
        """A random array. Where a bound is infinite it is normally distributed, else evenly."""
        bounded = np.isfinite(self.low) & np.isfinite(self.high)
        even = self._random.uniform(np.where(bounded, self.low, 0), np.where(bounded, self.high, 1))
        return np.where(bounded, even, self._random.normal(size=self.shape))

    def contains(self, x):
        return np.shape(x) == self.shape and bool(np.all((self.low <= x) & (x <= self.high)))


class Environment:
    """motors: joints by name, with the largest torque of each, N m. An action is one number from -1 to 1 for each
    motor: its share of that torque, held for `period` (s). An observation is the sine and cosine of each relative
    angle and then the rates (rad/s): 3n numbers.

    Derive from it: `reward(q, qd, action)` is due after each step; `is_over(q, qd)` ends an episode;
    `first_state(random)` begins one, by default in the first state of the scene."""

    metadata = {"render_modes": []}
    render_mode = None

    def __init__(self, scene, motors, period=0.05, longest=500):
        self.scene = scene if isinstance(scene, Scene) else Scene(scene)
        self.period, self.longest = period, longest
        self._simulation = Simulation(self.scene)
        strangers = set(motors) - set(self.scene.joints)
        if strangers or not motors or not all(0 < most < np.inf for most in motors.values()):
            raise ValueError(f"motors: expected joints of {list(self.scene.joints)} with torques > 0 N m, got {motors}")
        if not (0 < period < np.inf and longest >= 1):
            raise ValueError(f"expected period > 0 s and longest >= 1 step, got {period} and {longest}")
        self._places = [self.scene.joints.index(joint) for joint in motors]
        self._most = np.array(list(motors.values()), dtype=float)
        n = len(self.scene)
        self.action_space = Box([-1.0] * len(motors), [1.0] * len(motors))
        self.observation_space = Box([-1.0] * 2 * n + [-np.inf] * n, [1.0] * 2 * n + [np.inf] * n)
        self._random = np.random.default_rng()
        self._steps = 0

    def first_state(self, random):  # pylint: disable=unused-argument
        """Returns q and q̇. random: a numpy.random.Generator."""
        n = len(self.scene)
        return self.scene.state[:n], self.scene.state[n:]

    def reward(self, q, qd, action):
        raise NotImplementedError

    def is_over(self, q, qd):  # pylint: disable=unused-argument
        return False

    @staticmethod
    def observation(q, qd):
        return np.concatenate([np.sin(q), np.cos(q), qd])

    def reset(self, *, seed=None, options=None):  # pylint: disable=unused-argument
        if seed is not None:
            self._random = np.random.default_rng(seed)
        self._steps = 0
        self._simulation.reset()
        self._simulation.set_state(*self.first_state(self._random))
        return self.observation(self._simulation.q, self._simulation.qd), {}

    def step(self, action):
        """Returns observation, reward, terminated, truncated, info."""
        action = np.atleast_1d(np.asarray(action, dtype=float))
        if action.shape != self.action_space.shape or not np.isfinite(action).all():
            raise ValueError(f"action: expected {self.action_space.shape[0]} finite numbers from -1 to 1, got {action}")
        action = np.clip(action, -1, 1)
        torques = np.zeros(len(self.scene))
        torques[self._places] = action * self._most
        self._simulation.hold_torques(torques)
        self._steps += 1
        self._simulation.advance_to(self._steps * self.period)
        q, qd = self._simulation.q, self._simulation.qd
        return (self.observation(q, qd), float(self.reward(q, qd, action)), bool(self.is_over(q, qd)),
                self._steps >= self.longest, {"q": q, "qd": qd})

    def close(self):
        pass
