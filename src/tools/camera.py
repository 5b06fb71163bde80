"""Where rviz's camera stands."""

import math

ANGLE = math.pi / 4  # of rviz's camera, upright


def place(view, centre, half, frame=None):
    """Fits a view: its centre (x, y) and half its height, m, in the world or in a frame of a chain."""
    distance = half / math.tan(view.get('Field of View', ANGLE) / 2)
    if view['Class'] == 'rviz/Orbit':
        view['Distance'] = distance
        view['Focal Point'].update(X=centre[0], Z=centre[1])
    elif view['Class'] == 'rviz/FrameAligned':  # in the axes of its frame: the world's z is up, a chain's is to the front
        x, y = centre
        view['Pitch'], position = (math.pi / 2, (x, y, distance)) if frame else (0, (x, -distance, y))
        view['Position'] = dict(zip('XYZ', position))
    if frame:
        view['Target Frame'] = frame
