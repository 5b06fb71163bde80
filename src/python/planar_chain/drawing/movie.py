"""Motions as a picture that moves, by matplotlib's animations."""

import html
import io
import os
import shutil
import tempfile

import numpy as np
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, FuncAnimation
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from .player import page
from .poses import PATHS, SPRING, Pose, View, in_view, lines_of

FPS = 25          # a whole number of the 1/100 s of a GIF
DPI = 100
COLOURS, SAMPLES = 128, 4  # of a GIF; pictures from which they are chosen
CHAIN = "#0072B2"
TRAIL, RECENT = 4.0, 0.8  # s of the movie: the faint and the strong part of a path
WIDE, HIGH = 6.2, 4.6   # inch, of all panels
LEAST = 3.4, 1.4        # of one, but not more than its share
LETTERS = 13            # of a title, in an inch
LEFT, RIGHT, BELOW, ABOVE = 0.75, 0.15, 0.6, 0.4  # inch, around each
MOST_ABREAST = 3
KINDS = ".gif", ".mp4", ".html"


class NoWriter(RuntimeError):
    """What a kind of file needs, and is not there."""


class Panel:
    """A motion in a movie. times: of its pictures. points: of Body.point(), by their names."""

    def __init__(self, track, times, points):
        self.track, self.times = track, times
        self.places = track.at(times)
        paths = [track.path(*point) for point in points.values()]
        moving = [(track.broken(path), self.places.of(*point)) for path, point in zip(paths, points.values()) if track.moves(path)]
        self.paths, self.heads = zip(*moving) if moving else ((), ())
        self.view = View(np.concatenate([in_view(self.places), *paths]), track.body.reach)
        self.broken_t = track.broken(track.t)
        self.broken_t[np.isnan(self.broken_t)] = track.t[track.events]

    def begin(self, axes, title, unit, speed):
        self.trail, self.recent = TRAIL * speed, RECENT * speed
        self.lines = lines_of(self.places, unit)
        styles = {"alpha": 0.4, "linewidth": 0.8}, {"linewidth": 1.4}, {"marker": "o", "markersize": 3, "zorder": 3}
        self.trails = [[axes.plot([], [], color=PATHS[k % len(PATHS)], **style)[0] for style in styles] for k in range(len(self.paths))]
        self.pose = Pose(axes, self.lines, CHAIN, SPRING)
        axes.set_title(title.replace("$", r"\$"), loc="left", fontsize="medium")
        axes.set(xlabel="x (m)", ylabel="y (m)")
        axes.locator_params(nbins=5)
        axes.grid(alpha=0.3)

    def show(self, k):
        self.pose.show(self.lines, k)
        last = np.searchsorted(self.broken_t, self.times[k], side="right")
        for path, head, lines in zip(self.paths, self.heads, self.trails):
            for line, length in zip(lines, (self.trail, self.recent)):
                part = np.append(path[np.searchsorted(self.broken_t, self.times[k] - length):last], head[k])
                line.set_data(part.real, part.imag)
            lines[2].set_data(head[k:k + 1].real, head[k:k + 1].imag)


class Movie(FuncAnimation):
    """Motions side by side. tracks: one or more. points: for each, those of Body.point(), by their names, whose paths are drawn.
    speed: seconds of motion in a second of the movie."""

    def __init__(self, tracks, titles, points, speed=1.0):
        span = max(track.t[-1] - track.t[0] for track in tracks)
        self.seconds = speed / FPS * np.arange(int(np.ceil(span / speed * FPS - 1e-9)) + 1)
        self.panels = [Panel(track, track.t[0] + np.minimum(self.seconds, track.t[-1] - track.t[0]), named) for track, named in zip(tracks, points)]
        figure, grid, box = sheet(self.panels)
        for panel, axes, title in zip(self.panels, grid, titles):
            most = int(box[0] * LETTERS)
            panel.begin(axes, title if len(title) <= most else "…" + title[1 - most:], panel.view.limit(axes, box), speed)
        self.clock = figure.text(0.99, 0.015, "", ha="right", va="bottom")
        moving = [self.clock, *(artist for panel in self.panels for artist in (*panel.pose.artists.values(), *np.ravel(panel.trails)))]
        self.moving, self.still = sorted(moving, key=lambda artist: artist.zorder), None
        super().__init__(figure, self._show, frames=len(self.seconds), init_func=lambda: (), interval=1000 / FPS, repeat=True)

    def _show(self, k):
        for panel in self.panels:
            panel.show(k)
        self.clock.set_text(f"t = {self.seconds[k]:.2f} s")
        return ()

    def save(self, filename, writer=None, **how):  # pylint: disable=arguments-differ
        """Writes a .gif, .mp4 or .html. how: as of matplotlib's Animation.save()."""
        writer = writer or writer_of(str(filename))
        if isinstance(writer, Pictures):
            writer.movie, writer.palette = self, self.palette()
        super().save(filename, writer=writer, **{"dpi": DPI, **how})

    def picture(self):
        """What the figure shows now, as a picture of PIL. What does not move is drawn once."""
        canvas = self._fig.canvas
        if self.still is None:
            for artist in self.moving:
                artist.set_visible(False)
            canvas.draw()
            self.still = canvas.copy_from_bbox(self._fig.bbox)
            for artist in self.moving:
                artist.set_visible(True)
        canvas.restore_region(self.still)
        for artist in self.moving:
            artist.draw(canvas.get_renderer())
        return Image.frombuffer("RGBA", canvas.get_width_height(), bytes(canvas.buffer_rgba()), "raw", "RGBA", 0, 1).convert("RGB")

    def palette(self):
        """The colours of a few pictures, as a picture of PIL."""
        samples = []
        for k in np.linspace(0, len(self.seconds) - 1, SAMPLES).astype(int):
            self._show(k)
            samples.append(np.asarray(self.picture()))
        return Image.fromarray(np.concatenate(samples)).quantize(COLOURS)

    def _repr_html_(self):
        """Shows itself in a notebook."""
        writer = Page()
        self.save(os.devnull, writer)
        width, height = writer.frame_size
        return (f'<iframe srcdoc="{html.escape(writer.text)}" width="{width + 20}" height="{height + 60}" '
                'style="border: 0; max-width: 100%"></iframe>')


def sheet(panels):
    """A figure with axes for each panel, and their size, inch."""
    columns = min(len(panels), MOST_ABREAST)
    rows = -(-len(panels) // columns)
    widest, highest = WIDE / columns, HIGH / min(rows, 2)
    wanted = np.array([panel.view.box(widest, highest, np.minimum(LEAST, widest)) for panel in panels]).max(axis=0)
    box = np.round(wanted / 0.02) * 0.02  # an even number of pixels, for an .mp4
    cell = box + [LEFT + RIGHT, BELOW + ABOVE]
    figure = Figure(figsize=cell * [columns, rows], dpi=DPI)
    FigureCanvasAgg(figure)
    width, height = cell * [columns, rows]
    grid = [figure.add_axes([(LEFT + cell[0] * (k % columns)) / width, (BELOW + cell[1] * (rows - 1 - k // columns)) / height,
                             box[0] / width, box[1] / height]) for k in range(len(panels))]
    return figure, grid, box


# ---- Writers -----------------------------------------------------------------------------------


def writer_of(filename):
    """Raises NoWriter or ValueError."""
    kind = os.path.splitext(filename)[1]
    if kind not in KINDS:
        raise ValueError(f"expected a name that ends in .gif, .mp4 or .html, got {filename}")
    if kind != ".mp4":
        return Gif() if kind == ".gif" else Page()
    if not FFMpegWriter.isAvailable():
        raise NoWriter("a .mp4 needs the program ffmpeg, which is not installed (Debian, Ubuntu: apt install ffmpeg); .gif and .html do not")
    return FFMpegWriter(fps=FPS, extra_args=["-crf", "20", "-pix_fmt", "yuv420p"], codec="libx264")


def write(movie, path, progress=lambda done, pictures: None):
    """Saves a movie. A file that is there stays as it is until the movie is complete."""
    with tempfile.TemporaryDirectory() as folder:
        made = os.path.join(folder, "movie" + os.path.splitext(path)[1])
        movie.save(made, progress_callback=progress)
        with open(made, "rb") as source, open(path, "wb") as file:
            shutil.copyfileobj(source, file)


def in_colours(picture, palette):
    """The nearest colours for PIL; but the background, the colour of the first corner of both, is exact."""
    rgb, entries, background = np.asarray(picture), palette.getpalette(), palette.getpixel((0, 0))
    entries[3 * background:3 * background + 3] = rgb[0, 0].tolist()
    places = np.array(picture.quantize(palette=palette, dither=0))
    places[(rgb == rgb[0, 0]).all(axis=2)] = background
    found = Image.fromarray(places, "P")
    found.putpalette(entries)
    return found


class Pictures(AbstractMovieWriter):
    """Keeps each picture of a Movie as a PNG, in the colours of `palette`."""

    def __init__(self):
        super().__init__(fps=FPS)
        self.pictures, self.movie, self.palette = [], None, None

    def setup(self, fig, outfile, dpi=None):
        super().setup(fig, outfile, dpi)  # which is abstract
        fig.set_dpi(dpi)
        self.movie.still = None

    def grab_frame(self, **how):
        png = io.BytesIO()
        in_colours(self.movie.picture(), self.palette).save(png, "PNG")
        self.pictures.append(png)


class Gif(Pictures):
    def finish(self):
        first, *others = map(Image.open, self.pictures)
        first.save(self.outfile, save_all=True, append_images=others, duration=1000 // FPS, loop=0)


class Page(Pictures):
    """One HTML file, which needs no other. text: what it holds."""

    def finish(self):
        with Image.open(self.pictures[0]) as first:
            self.text = page([picture.getvalue() for picture in self.pictures], first.size, first.convert("RGB").getpixel((0, 0)), FPS)
        with open(self.outfile, "w", encoding="utf-8") as file:
            file.write(self.text)
