"""The page of a report: index.html and its pictures, from the tables of a folder and page.html.jinja.

report.py measures and calls write().
"""
import collections
import io
import json
import math
import pathlib
import re

import jinja2
import matplotlib.pyplot as plt

import figures
import results
from results import grouped, number, read_table


def digits(value, form=".3g", times=1):
    """A number, or the text of one."""
    value = math.nan if value in (None, "") else times * float(value)
    return format(value, form) if math.isfinite(value) else "–"


def shorter(svg):
    """Half of the size: tenths of a point, each marker's colour once, no empty rotations, no indentation."""
    svg = re.sub(r"<[^>]*>", lambda tag: re.sub(r"(\d+\.\d)\d+", r"\1", tag.group()), svg)
    svg = re.sub(r'(<use [^>]*?) style="fill: (#\w+); stroke: \2"', r"\1", svg)
    svg = re.sub(r'style="stroke: (#\w+)"/>(?=\s*</defs>)', r'style="fill: \1; stroke: \1"/>', svg)
    return re.sub(r"\s*\n\s*", "\n", re.sub(r' transform="rotate\(-0 [^"]*"', "", svg))


def floor_of(ends):
    """Below this error the rounding of the scene's numbers decides, or the reference is not known."""
    return max(number(row[column]) for row in ends for column in ("rounding", "uncertainty")
               if row["quantity"] == "theta")


def write(folder, data, titles):
    """Writes index.html and its pictures from the tables of the folder; titles: the lines of scenes.csv by name."""
    def save(figure, name):
        content = io.StringIO()
        figure.savefig(content, format="svg", metadata={"Date": None})
        plt.close(figure)
        (folder / f"{name}.svg").write_text(shorter(content.getvalue()), encoding="utf-8")
        return f"{name}.svg"

    about = json.loads((folder / "about.json").read_text(encoding="utf-8"))
    tables = collections.defaultdict(list, {name: read_table(results.table(folder, name)) for name in about})
    measured = grouped(tables["race"], "scene")
    scenes = {name: {**title, "rows": measured[name], "floor": floor_of(read_table(data / f"{name}.csv"))}
              for name, title in titles.items() if name in measured}
    environment = jinja2.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True,
                                     undefined=jinja2.StrictUndefined)
    environment.filters.update(digits=digits, grouped=grouped, name_of=results.name_of)
    template = pathlib.Path(__file__).resolve().with_name("page.html.jinja").read_text(encoding="utf-8")
    page = environment.from_string(template).render(
        about=about, tables=tables, scenes=scenes, figures=figures, results=results, save=save,
        cells={(name, level): results.verdict(scene["rows"], level, scene["floor"])
               for name, scene in scenes.items() for level in results.LEVELS})
    (folder / "index.html").write_text(page, encoding="utf-8")
