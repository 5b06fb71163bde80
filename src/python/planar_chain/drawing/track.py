"""A motion as it is drawn: states at times, and places at any time between."""

import numpy as np

from .body import Places, spans_of

STAYS = 1e-6  # of the reach: what moves less has no path


class Track:
    """t: time of each state, s. q, base: a row for each: of the joints; x, y (m) and angle (rad) of the ground pin, None if it stands
    still. scene_time: the t of the scene's loads, s. events: numbers k of states that do not continue the state k − 1."""

    def __init__(self, body, t, q, base=None, scene_time=None, events=()):
        self.body, self.t, self.q, self.events = body, t, q, sorted(events)
        self.base = np.zeros((len(t), 3)) if base is None else base
        self.scene_time = np.full(len(t), np.nan) if scene_time is None else scene_time

    def at(self, times, spans=None, shift=0.0):
        """The Places at these times, linear between states. Before an event the last state stays."""
        events = self.events
        t = np.insert(self.t, events, self.t[events])
        states = np.column_stack([self.base, self.scene_time, self.q])
        states = np.insert(states, events, states[[k - 1 for k in events]], axis=0)
        now = np.column_stack([np.interp(times, t, column) for column in states.T])
        return Places(self.body, now[:, :3], now[:, 4:], now[:, 3], self.spans() if spans is None else spans, shift)

    def spans(self, seen=slice(None)):
        return spans_of(self.body, self.q[seen])

    def path(self, link, point, shift=0.0):
        """Where a point of a link is at each state."""
        return Places(self.body, self.base, self.q, shift=shift).of(link, point)

    def moves(self, path):
        """True if the path is not that of a point at rest, such as a pinned tip."""
        return np.ptp(path.real) + np.ptp(path.imag) >= STAYS * self.body.reach

    def broken(self, path):
        """The path with gaps where lines must not join states."""
        return np.insert(path, self.events, np.nan)
