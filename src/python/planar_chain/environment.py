"""A scene to learn on: reset, step, render and spaces as Gymnasium has them. Where Gymnasium is installed, an Environment
is a gymnasium.Env and its spaces are gymnasium.spaces.Box. Else the few lines here take their place."""

import inspect

import numpy as np

from planar_chain import Scene, Simulation
from planar_chain.fitting.recordings import is_number

try:
    from gymnasium import Env
    from gymnasium.spaces import Box as _Box
except ImportError:
    class Env:  # pylint: disable=too-few-public-methods
        """In the place of gymnasium.Env."""

        def reset(self, *, seed=None, options=None):  # pylint: disable=unused-argument
            if seed is not None or not hasattr(self, "np_random"):
                self.np_random = np.random.default_rng(seed)

    class _Box:
        """In the place of gymnasium.spaces.Box: the arrays of one shape between `low` and `high`."""

        def __init__(self, low, high, dtype=np.float64):
            self.dtype = np.dtype(dtype)
            self.low, self.high = np.array(low, dtype=dtype), np.array(high, dtype=dtype)
            self.shape = self.low.shape
            self.seed()

        def __repr__(self):
            return f"Box({self.low}, {self.high}, {self.shape}, {self.dtype})"

        def seed(self, seed=None):
            self._random = np.random.default_rng(seed)

        def sample(self):
            """A random array. Where a bound is infinite it is normally distributed, else evenly."""
            bounded = np.isfinite(self.low) & np.isfinite(self.high)
            even = self._random.uniform(np.where(bounded, self.low, 0), np.where(bounded, self.high, 1))
            return np.where(bounded, even, self._random.normal(size=self.shape))

        def contains(self, x):
            return np.shape(x) == self.shape and bool(np.all((self.low <= x) & (x <= self.high)))


class Box(_Box):
    """The arrays of one shape between `low` and `high`, of doubles."""

    def __init__(self, low, high):
        super().__init__(np.array(low, dtype=float), np.array(high, dtype=float), dtype=np.float64)


class Environment(Env):
    """motors: joints by name, with the largest torque of each (N m; N of prismatic joints), at most its `effort_limit`. An
    action is one number from -1 to 1 for each motor: its share of that torque, held for `period` (s). One beyond is refused;
    Gymnasium's wrapper ClipAction clips it. An observation is the positions of prismatic joints (m), the sines and cosines of the relative
    angles, and the rates (m/s, rad/s). render_mode "rgb_array": render() returns a picture of the chain.

    Derive from it: `reward(q, qd, action)` is due after each step; `is_over(q, qd)` ends an episode;
    `first_state(random)` begins one, by default in the first state of the scene."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 20}

    def __init__(self, scene, motors, period=0.05, longest=500, render_mode=None):
        if type(self).reward is Environment.reward:
            raise TypeError(f"{type(self).__name__}: expected a class derived from Environment that defines "
                            "reward(self, q, qd, action), got none")
        for name, arguments in (("reward", "q, qd, action"), ("is_over", "q, qd"), ("first_state", "random")):
            signature = inspect.signature(getattr(self, name))
            try:
                signature.bind(*arguments.split(", "))
            except TypeError:
                raise TypeError(f"{name}: expected a function of {arguments}, got one of {signature}") from None
        self.scene = scene if isinstance(scene, Scene) else Scene(scene)
        self.period, self.longest = period, longest
        self._simulation = Simulation(self.scene)
        if not (isinstance(motors, dict) and motors and set(motors) <= set(self.scene.joints)
                and all(is_number(most) and 0 < most < np.inf for most in motors.values())):
            raise ValueError(f"motors: expected joints of {self.scene.joints} with torques > 0 N m, such as "
                             f"{{{self.scene.joints[-1]!r}: 5.0}}, got {motors!r}")
        for k, (joint, most) in enumerate(zip(self.scene.joints, self.scene.effort_limits)):
            if motors.get(joint, 0) > most:
                raise ValueError(f"motors: expected at most the effort_limit of {joint}, {most:g} {'N' if self.scene.prismatic[k] else 'N m'}, "
                                 f"got {motors[joint]!r}")
        if not (is_number(period) and 0 < period < np.inf and is_number(longest) and longest >= 1):
            raise ValueError(f"expected period > 0 s and longest >= 1 step, got {period!r} and {longest!r}")
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(f"render_mode: expected None or rgb_array, got {render_mode!r}")
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": 1 / period}
        self._places = [self.scene.joints.index(joint) for joint in motors]
        self._most = np.array(list(motors.values()), dtype=float)
        self._hold(self._most)  # refuses driven joints
        n = len(self.scene)
        self._prismatic = np.array(self.scene.prismatic)
        m = np.count_nonzero(self._prismatic)
        self.action_space = Box([-1.0] * len(motors), [1.0] * len(motors))
        largest = np.array([np.inf] * m + [1.0] * 2 * (n - m) + [np.inf] * n)
        self.observation_space = Box(-largest, largest)
        self._steps = None  # before the first reset()
        self._still, self._half = None, 0.0

    def __repr__(self):
        return f"<{type(self).__name__}, n = {len(self.scene)}, motors: {', '.join(self.scene.joints[k] for k in self._places)}>"

    def _hold(self, torques):
        all_torques = np.zeros(len(self.scene))
        all_torques[self._places] = torques
        self._simulation.hold_torques(all_torques)

    def first_state(self, random):  # pylint: disable=unused-argument
        """Returns q and q̇. random: a numpy.random.Generator."""
        n = len(self.scene)
        return self.scene.state[:n], self.scene.state[n:]

    def reward(self, q, qd, action):
        raise NotImplementedError("Environment: expected a reward(self, q, qd, action) in the derived class")

    def is_over(self, q, qd):  # pylint: disable=unused-argument
        return False

    def observation(self, q, qd):
        angles = q[~self._prismatic]
        return np.concatenate([q[self._prismatic], np.sin(angles), np.cos(angles), qd])

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed, options=options)
        self._steps, self._half = 0, 0.0
        self._simulation.reset()
        first = self.first_state(self.np_random)
        try:
            q, qd = first
            self._simulation.set_state(q, qd)
        except (TypeError, ValueError) as problem:
            raise ValueError(f"first_state: expected two arrays, q and qd, of {len(self.scene)} numbers, got {first!r} "
                             f"({problem})") from None
        return self.observation(*self._state()), {}

    def step(self, action):
        """Returns observation, reward, terminated, truncated, info."""
        if self._steps is None:
            raise ValueError("step: expected a reset() before the first one, got none")
        given = np.atleast_1d(np.ma.filled(np.asanyarray(action, dtype=object), np.nan))
        if given.shape != self.action_space.shape or not all(map(is_number, given)):
            raise ValueError(f"action: expected {self.action_space.shape[0]} numbers from -1 to 1, got {action}")
        action = given.astype(float)
        for k in np.flatnonzero(~(abs(action) <= 1))[:1]:
            raise ValueError(f"action[{k}], of {self.scene.joints[self._places[k]]}: expected a number from -1 to 1, got {float(action[k])}")
        self._hold(action * self._most)
        self._steps += 1
        self._simulation.advance_to(self._steps * self.period)
        # Each has arrays of its own: one may change them.
        return (self.observation(*self._state()), _finite(self.reward(*self._state(), action)), bool(self.is_over(*self._state())),
                self._steps >= self.longest, dict(zip(("q", "qd"), self._state())))

    def _state(self):
        return self._simulation.q, self._simulation.qd

    def render(self, size=400):  # pylint: disable=arguments-differ
        """Returns the chain as size × size × 3 bytes, red, green, blue: the origin in the middle, y upwards. It shows as much as the
        episode needed so far. It needs render_mode, and matplotlib."""
        if self.render_mode is None:
            raise ValueError(f'render: expected {type(self).__name__}(…, render_mode="rgb_array"), got one without a render_mode')
        # pylint: disable=import-outside-toplevel  # who learns without pictures needs no matplotlib
        from planar_chain.described import described
        from planar_chain.drawing.body import Body, Places, base_under
        from planar_chain.drawing.still import Still
        if self._still is None or self._still.size != size:
            self._still = Still(size)
            self._body = Body(described(self.scene))
        motions, q = self._simulation.link_motions(), self._simulation.q[np.newaxis]
        first = np.array([[*motions["inner_pin"][0], motions["angle"][0]]])
        places = Places(self._body, base_under(self._body, first, 0, q), q, np.array([self._simulation.time]))
        picture, self._half = self._still.draw(places, max(self._half, self._body.reach))
        return picture

    def close(self):
        pass


def _finite(reward):
    try:
        number = float(reward)
    except (OverflowError, TypeError, ValueError):
        number = np.nan
    if not np.isfinite(number):
        raise ValueError(f"reward: expected a finite number, got {reward!r}")
    return number
