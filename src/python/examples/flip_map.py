#!/usr/bin/python3
"""When the double pendulum first flips, released at rest from each pair of angles: a picture.

    flip_map.py [SIZE [SECONDS [PICTURE]]]      SIZE × SIZE starts; default 1000 20 flip_map.png

Two equal uniform rods. θ₁, θ₂: angles of the rods from hanging. Where 3 cos θ₁ + cos θ₂ > 2 the energy is too low for
any flip; the blue line is the edge."""
import sys

import numpy as np
from planar_chain import Scene, simulate_many

ROD = {"mass": 1.0, "inertia": 1 / 12, "com": [0.5, 0.0], "pin": [1.0, 0.0]}
SCENE = Scene({"chain": ["upper", "lower"], "links": {"upper": ROD, "lower": ROD}, "integrator": {"tolerance": 1e-6}})
PERIOD = 0.05  # s, between two looks


def flip_times(angles, seconds):
    """Returns when either rod first passes the upright, s; infinite: not within these seconds. [θ₁, θ₂]."""
    times = np.arange(0, seconds + PERIOD / 2, PERIOD)
    flips = np.full((len(angles), len(angles)), np.inf)
    for theta, row in zip(angles, flips):
        still = np.zeros_like(angles)
        starts = np.column_stack([still + theta - np.pi / 2, angles - theta, still, still])  # relative angles, rates
        states = simulate_many(SCENE, times, initial=starts).states
        hanging = np.cumsum(states[:, :, :2], axis=2) + np.pi / 2
        flipped = (abs(hanging) > np.pi + 1e-9).any(axis=2)  # some start upright
        first = flipped.argmax(axis=1)
        row[flipped.any(axis=1)] = times[first[flipped.any(axis=1)]]
    return flips


def draw(angles, flips, picture):
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import colors, pyplot
    figure, axes = pyplot.subplots(figsize=(7.6, 6.4), constrained_layout=True)
    image = axes.pcolormesh(angles, angles, np.where(np.isinf(flips), np.nan, flips).T, cmap="magma_r", rasterized=True,
                            norm=colors.LogNorm(0.5, PERIOD * round(np.nanmax(flips[np.isfinite(flips)]) / PERIOD)))
    axes.contour(angles, angles, (3 * np.cos(angles)[:, None] + np.cos(angles)[None, :]).T, [2], colors="C0")
    figure.colorbar(image, label="first flip (s); blank: none")
    axes.set(xlabel="θ₁ (rad)", ylabel="θ₂ (rad)", aspect="equal", title="Double pendulum: when it first flips")
    figure.savefig(picture, dpi=110)


if __name__ == "__main__":
    given = sys.argv[1:] + ["1000", "20", "flip_map.png"][len(sys.argv) - 1:]
    grid = np.linspace(-np.pi, np.pi, int(given[0]))
    draw(grid, flip_times(grid, float(given[1])), given[2])
