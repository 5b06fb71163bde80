#!/usr/bin/python3
"""Writes the pages of a report and their pictures from the tables of a folder: index.html, with every table and pictures
as SVG; README.md, with short tables and pictures as PNG, which a code host shows.

    render.py FOLDER

report.py measures and calls write().
"""
import collections
import hashlib
import io
import math
import pathlib
import re
import sys

import jinja2
import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import PIL.Image
import PIL.PngImagePlugin

sys.dont_write_bytecode = True  # the script lies in a folder of sources

import figures  # noqa: E402  pylint: disable=wrong-import-position
import models_page  # noqa: E402  pylint: disable=wrong-import-position
import results  # noqa: E402  pylint: disable=wrong-import-position
from results import grouped, number, read_table  # noqa: E402  pylint: disable=wrong-import-position

HERE = pathlib.Path(__file__).resolve().parent
DPI = 100    # of a PNG
BLUR = 20    # of a PNG: the mean square of what a pixel's colour misses, red + green + blue


def digits(value, form=".3g", times=1):
    """A number, or the text of one; without a power of ten from 1000 to 999,999."""
    value = math.nan if value in (None, "") else times * float(value)
    if form == ".3g" and 1000 <= value < 1e6:
        return f"{float(format(value, form)):,.0f}"
    return format(value, form) if math.isfinite(value) else "–"


def shorter(svg):
    """Half of the size: tenths of a point, each marker's colour once, no empty rotations, no indentation."""
    svg = re.sub(r"<[^>]*>", lambda tag: re.sub(r"(\d+\.\d)\d+", r"\1", tag.group()), svg)
    svg = re.sub(r'(<use [^>]*?) style="fill: (#\w+); stroke: \2"', r"\1", svg)
    svg = re.sub(r'style="stroke: (#\w+)"/>(?=\s*</defs>)', r'style="fill: \1; stroke: \1"/>', svg)
    return re.sub(r"\s*\n\s*", "\n", re.sub(r' transform="rotate\(-0 [^"]*"', "", svg))


def origins(about, tables):
    """A line for each commit, processor and time of measurement, with its sections; that of most sections last."""
    sections = {}
    for study, title in results.SECTIONS.items():
        if tables[study]:
            sections.setdefault(", ".join(about[study][fact] for fact in ("commit", "compiler", "cpu", "date")), []).append(title)
    order = sorted(sections, key=lambda origin: len(sections[origin]))
    for most in order[-1:]:
        sections[most] = ["the other sections" if len(order) > 1 else "all sections"]
    return [f"Commit {origin}: {'; '.join(sections[origin])}." for origin in order]


def with_palette(image):
    """The picture with few colours: even areas keep theirs, edges take the nearest of those that reduce the blur most."""
    pixels = np.asarray(image.convert("RGB")).astype(int) @ [65536, 256, 1]
    colours, places, counts = np.unique(pixels, return_inverse=True, return_counts=True)
    places = places.reshape(pixels.shape)
    corner = places[:-1, :-1]
    even = np.bincount(corner[(corner == places[1:, :-1]) & (corner == places[:-1, 1:])], minlength=len(colours))
    parts = np.stack([colours >> 16, colours >> 8 & 255, colours & 255], axis=-1)
    kept = [k for k in np.argsort(-even, kind="stable")[:256] if even[k] >= 16]
    while True:
        distances = ((parts[:, None] - parts[kept]) ** 2).sum(axis=2)
        misses = counts * distances.min(axis=1)
        if misses.sum() <= BLUR * counts.sum() or len(kept) == 256:
            break
        kept.append(misses.argmax())
    picture = PIL.Image.fromarray(distances.argmin(axis=1).astype(np.uint8)[places], "P")
    picture.putpalette(parts[kept].astype(np.uint8).tobytes())
    return picture


def floor_of(ends):
    """Below this error the rounding of the scene's numbers decides, or the reference is not known."""
    return max(number(row[column]) for row in ends for column in ("rounding", "uncertainty")
               if row["quantity"] == "theta")


def drawn_from(path):
    """The digest of the drawing that a PNG was made from; none if there is no such file."""
    try:
        with PIL.Image.open(path) as image:
            return image.text.get("Description")
    except FileNotFoundError:
        return None


class Pictures:
    """Saves figures of matplotlib in a folder, each as NAME.svg and NAME.png."""

    def __init__(self, folder):
        self.folder = folder

    def save(self, figure, name):
        """Returns the name. A PNG that shows the same drawing stays as it is."""
        content = io.StringIO()
        figure.savefig(content, format="svg", metadata={"Date": None})
        svg = shorter(content.getvalue())
        digest = hashlib.sha256(svg.encode()).hexdigest()
        (self.folder / f"{name}.svg").write_text(svg, encoding="utf-8")
        if drawn_from(self.folder / f"{name}.png") != digest:
            self.save_png(figure, self.folder / f"{name}.png", digest)
        plt.close(figure)
        return name

    @staticmethod
    def save_png(figure, path, digest):
        content = io.BytesIO()
        figure.savefig(content, format="png", dpi=DPI)
        facts = PIL.PngImagePlugin.PngInfo()
        facts.add_text("Description", digest)
        facts.add_text("Software", f"Matplotlib {matplotlib.__version__}")
        with PIL.Image.open(content) as image:
            with_palette(image).save(path, optimize=True, pnginfo=facts)


def write(folder, data, titles):
    """Writes index.html and README.md, and their pictures, from the tables of the folder; titles: the lines of scenes.csv
    by name."""
    about = results.read_about(folder)
    tables = collections.defaultdict(list, {name: read_table(results.table(folder, name)) for name in about})
    measured = grouped(tables["race"], "scene")
    scenes = {name: {**title, "rows": measured[name], "floor": floor_of(read_table(data / f"{name}.csv"))}
              for name, title in titles.items() if name in measured}
    cells = {side: {(name, level): results.verdict(scene["rows"], level, scene["floor"], side)
                    for name, scene in scenes.items() for level in results.LEVELS} for side in results.SIDES}
    facts = dict(about=about, tables=tables, scenes=scenes, figures=figures, models_page=models_page, results=results, save=Pictures(folder).save, cells=cells)
    environment = jinja2.Environment(trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined,
                                     autoescape=lambda name: name.endswith(".html.jinja"),
                                     loader=jinja2.FileSystemLoader([str(HERE), str(HERE / "sections")]))  # installed they lie in one
    environment.filters.update(digits=digits, grouped=grouped, name_of=results.name_of, side_of=results.side_of, origins=origins)
    for page, template in (("index.html", "page.html.jinja"), ("README.md", "page.md.jinja")):  # the first draws for both
        text = environment.get_template(template).render(facts)
        (folder / page).write_text(re.sub(r"\n{3,}", "\n\n", text), encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    SCENES = HERE.parents[1] / "test/reference/report"
    write(pathlib.Path(sys.argv[1]), SCENES, {row["name"]: row for row in read_table(SCENES / "scenes.csv")})
