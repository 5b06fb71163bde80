"""animate(): a motion as a picture that moves."""

import numpy as np

from .described import described
from .drawing.body import Body, base_under
from .drawing.movie import Movie
from .drawing.track import Track


def animate(scene, times, states, points=("tip",), speed=1.0):
    """Returns a matplotlib Animation of a motion. It shows itself in a notebook; .save() writes a .gif, .mp4 or .html.

    times: rising, s, of the scene's loads and base too. states: one row for each time, q or (q, q̇), as of simulate(). points: whose
    paths are drawn: "tip", a frame of the scene, or (LINK, [x, y]), m in the frame of the link. speed: seconds of motion in a second."""
    times, states, n = np.array(times, dtype=float), np.array(states, dtype=float), len(scene)
    if times.ndim != 1 or len(times) < 2 or not np.isfinite(times).all() or not (np.diff(times) > 0).all():
        raise ValueError(f"times: expected two or more that rise, got {times}")
    if states.ndim != 2 or states.shape[0] != len(times) or states.shape[1] not in (n, 2 * n) or not np.isfinite(states[:, :n]).all():
        raise ValueError(f"states: expected {len(times)} rows of {n} or {2 * n} finite numbers, got an array of shape {states.shape}"
                         + " with others" * (not np.isfinite(states).all()))
    if not 0 < speed < np.inf:
        raise ValueError(f"speed: expected a number above 0, got {speed!r}")
    body, q = Body(described(scene)), states[:, :n]
    track = Track(body, times, q, base_of(scene, body, times, q) if body.moves else None, times)
    return Movie([track], [""], [points_of(body, points)], speed)


def base_of(scene, body, times, q):
    """x, y (m) and angle (rad) of the ground pin at each time, by the laws of the scene."""
    first = np.array([scene.position(scene.links[0], [0, 0], row, t=t, with_angle=True) for t, row in zip(times, q)])
    return base_under(body, first, 0, q)


def points_of(body, points):
    found = {}
    for point in points:
        name, at = (point, None) if isinstance(point, str) else point
        if name not in ("tip", *body.names, *(body.frames if at is None else ())):
            raise ValueError(f"points: expected tip, a frame of {list(body.frames)}, or (LINK, [x, y]) with a link of {body.names}, got {point!r}")
        found[str(point)] = body.point(name, at)
    return found
