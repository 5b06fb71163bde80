#!/usr/bin/python3
"""Writes extremes/NAME.csv for each scene extremes/NAME.yaml, as trajectories.py does.

    ./extremes.py [NAME ...]
"""

import trajectories

trajectories.FOLDER = trajectories.HERE / "extremes"
trajectories.DURATIONS = {
    "masses_down": 0.75, "masses_up": 0.5, "massless_link": 0.5, "lengths_down": 2, "lengths_up": 2, "spin": 0.03125,
    "heavy": 0.03125, "points": 1,
}

if __name__ == "__main__":
    trajectories.main()
