"""Pieces of a report's page: pictures inline, tables, feet; how each contestant is drawn."""
import base64
import html
import io

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  pylint: disable=wrong-import-position

from PIL import Image  # noqa: E402  pylint: disable=wrong-import-position

plt.rcParams.update({"svg.hashsalt": "planar_chain", "font.size": 9, "axes.grid": True, "grid.alpha": 0.25,
                     "axes.spines.top": False, "axes.spines.right": False, "figure.dpi": 100})

OWN = "planar_chain"
COLOURS = {"auto": "black", "rk4": "#9467bd", "dopri5": "#1f77b4", "dop853": "#17becf", "rodas5p": "#d62728",
           "radau13": "#ff7f0e", "taylor": "#2b8a3e", "ros34pw2": "#e377c2", "ros34pw2_fixed": "#8c564b"}
PEER_COLOURS = ["#8fbc8f", "#98df8a", "#556b2f", "#bcbd22", "#7f7f7f", "#393b79", "#8c6d31", "#5254a3", "#637939",
                "#3182bd", "#a55194", "#c7c7c7", "#e6550d", "#17a589"]
PEER_MARKS = "sDv^<>pP*hXd8H"


def name_of(who):
    """(engine, method) in words."""
    return who[1] if who[0] == OWN else f"{who[0]}: {who[1]}"


def picture(figure, name, alt, folder=None, kind="svg"):
    """The figure inline, and as a file of its own where a folder is given. Those of thousands of marks are shorter as
    png."""
    if folder is not None:
        figure.savefig(folder / f"{name}.svg", metadata={"Date": None})
    content = io.BytesIO()
    figure.savefig(content, format=kind, metadata={"Date": None} if kind == "svg" else None)
    plt.close(figure)
    if kind == "png":  # 256 colours, chosen so that none is far off: a third of the size
        few = Image.open(content).convert("RGB").quantize(256, method=1)
        content = io.BytesIO()
        few.save(content, format="png", optimize=True)
    mime = "svg+xml" if kind == "svg" else kind
    data = base64.b64encode(content.getvalue()).decode()
    return f'<img id="{name}" alt="{html.escape(alt)}" src="data:image/{mime};base64,{data}">'


def table(header, rows, classes=None):
    """Cells are text; classes(row, column) may give a cell's class."""
    lines = ["<div class=wide><table><tr>" + "".join(f"<th>{html.escape(cell)}</th>" for cell in header) + "</tr>"]
    for i, row in enumerate(rows):
        cells = []
        for j, cell in enumerate(row):
            kind = classes(i, j) if classes else ""
            cells.append(f"<td{f' class={kind}' if kind else ''}>{html.escape(str(cell))}</td>")
        lines.append("<tr>" + "".join(cells) + "</tr>")
    return "\n".join(lines) + "</table></div>"


def foot(about):
    """Under each figure: what made it."""
    engines = "; ".join(f"{name} {version}" for name, version in about["engines"].items())
    return (f"<p class=foot>{html.escape(about['command'])} — commit {html.escape(about['commit'])}, "
            f"{html.escape(about['compiler'])}, {html.escape(about['flags'].strip())}, {html.escape(about['cpu'])}, "
            f"{about['date']}{'; ' + html.escape(engines) if engines else ''}</p>")


def styles(rows):
    """(engine, method): how it is drawn, the same on every picture."""
    found = {}
    peers = sorted({(row["engine"], row["method"]) for row in rows if row["engine"] != OWN})
    for k, peer in enumerate(peers):
        found[peer] = dict(color=PEER_COLOURS[k % len(PEER_COLOURS)], linestyle="--", linewidth=1,
                           marker=PEER_MARKS[k % len(PEER_MARKS)], markersize=3.5)
    for row in rows:
        if row["engine"] == OWN:
            is_auto = row["method"] == "auto"
            found[OWN, row["method"]] = dict(color=COLOURS.get(row["method"], "grey"), marker="o",
                                             linewidth=2.4 if is_auto else 1.3, markersize=4 if is_auto else 3,
                                             zorder=5 if is_auto else 3)
    return found
