#!/usr/bin/python3
"""How often the true value lies within two of the deviations that a fit states: of made data with noise of 1 mrad. A normal estimate
lies there in 95.4 % of the runs.

    test/python/fit_statistics.py [RUNS [SEED]]        default: 200 runs, seed 0; PYTHONPATH finds planar_chain. A minute or two
"""
import sys

import numpy as np

from planar_chain import Scene, fit, simulate_many

NOISE = 1e-3  # rad
ROD = {"mass": 1.0, "inertia": 1 / 12, "com": [0.5, 0.0], "pin": [1.0, 0.0]}
SCENE = Scene({"chain": ["upper", "lower"], "links": {"upper": {**ROD, "joint": {"damping": 0.05}},
                                                      "lower": {**ROD, "joint": {"damping": 0.02}}}})
TRUE = {"links/lower/mass": 1.0, "links/lower/com/0": 0.5, "links/upper/joint/damping": 0.05, "links/lower/joint/damping": 0.02}
STARTS = [[-1.0, 0.6, 0.0, 0.0], [-2.2, -0.4, 1.0, 0.5]]
TIMES = np.linspace(0, 2, 101)  # s


def ratios(runs, seed):
    """(found − true)/deviation: runs × numbers."""
    random = np.random.default_rng(seed)
    motions = simulate_many(SCENE, TIMES, initial=STARTS).states[:, :, :2]
    first = SCENE.with_values({path: 1.1 * value for path, value in TRUE.items()})
    table = []
    for _ in range(runs):
        recordings = [{"t": TIMES, "q": motion + random.normal(scale=NOISE, size=motion.shape)} for motion in motions]
        result = fit(first, recordings, list(TRUE))
        if not result.converged:
            sys.exit(f"a fit did not converge: {result.reason}")
        table.append([(found.value - TRUE[found.path]) / found.deviation for found in result.numbers])
    return np.array(table)


def main():
    runs, seed = (list(map(int, sys.argv[1:])) + [200, 0][len(sys.argv) - 1:])[:2]
    table = ratios(runs, seed)
    for path, column in zip(TRUE, table.T):
        print(f"{path:28s} within two deviations {np.mean(abs(column) < 2):.1%}, mean {column.mean():+.3f}, spread {column.std():.3f}")
    print(f"{'all':28s} within two deviations {np.mean(abs(table) < 2):.1%}")


if __name__ == "__main__":
    main()
