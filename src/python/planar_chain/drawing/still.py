"""One pose after another in a square picture."""

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from .movie import CHAIN
from .poses import SPRING, Pose, in_view, lines_of

DPI = 100
MARGIN = 1.1
SMALL = 300  # pixels: in smaller pictures, lines and marks are thinner in proportion


class Still:
    """size: of the picture, pixels. The ground pin is in the middle."""

    def __init__(self, size):
        self.size, self.pose = size, None
        figure = Figure(figsize=(size / DPI, size / DPI), dpi=DPI * min(1, size / SMALL))
        figure.set_size_inches(size / figure.dpi, size / figure.dpi)
        self.canvas = FigureCanvasAgg(figure)
        self.axes = figure.add_axes([0, 0, 1, 1])
        self.axes.axis("off")

    def draw(self, places, half):
        """places: of one instant. half: at least so much is seen to each side, m. Returns size × size × 3 bytes, and how much it was."""
        seen = in_view(places)
        half = max(half, abs(seen.real).max(), abs(seen.imag).max())
        self.axes.set(xlim=(-MARGIN * half, MARGIN * half), ylim=(-MARGIN * half, MARGIN * half))
        lines = lines_of(places, 2 * MARGIN * half / (72 * self.canvas.figure.get_figwidth()))
        if self.pose is None:
            self.pose = Pose(self.axes, lines, CHAIN, SPRING)
        self.pose.show(lines, 0)
        self.canvas.draw()
        return np.array(self.canvas.buffer_rgba())[..., :3], half
