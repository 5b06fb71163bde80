"""What the page shows of models.csv: a line for each model, and a picture."""
import matplotlib.pyplot as plt

from figures import RED, logarithmic, panels
from results import grouped, number

COLOURS = {"both": "#2b8a3e", "ours": "#1f77b4", "figure": RED, "open": "#e08214", "machine": "#5b6b8c"}
WORDS = {"both": "both are right", "ours": "ours is right", "figure": "the figure is right", "open": "not decided",
         "machine": "recording of a machine"}
LEAST = 1e-16  # of the axis: smaller differences are drawn there


def doubt(row):
    return max(number(row["second_differs"]), number(row["tighter_differs"]))


def lines(rows):
    """The row of each model in which the figure and ours differ most, of those that are the least right."""
    order = list(WORDS).index
    return [{**max(group, key=lambda row: (row["right"] != "machine" and order(row["right"]), number(row["difference"]))),
             "source": group[0]["source"]} for group in grouped(rows, "model").values()]


def differences(rows):
    """A line for each model: how much figures differ from ours, and our own runs from one another."""
    models = grouped(rows, "model")
    figure, (axes,) = panels(1, 0.25 * len(models) + 1.5)
    height = figure.get_figheight()
    figure.subplots_adjust(left=0.31, right=0.97, bottom=0.45 / height, top=1 - 0.75 / height)
    for k, group in enumerate(models.values()):
        axes.barh(k, max(2 * LEAST, *(doubt(row) for row in group)) - LEAST, left=LEAST, height=0.62, color="grey", alpha=0.3, linewidth=0)
        for row in group:
            axes.plot(max(number(row["difference"]), LEAST), k, linestyle="", marker="o", markersize=4.5, alpha=0.75, markeredgewidth=0,
                      color=COLOURS[row["right"]])
        axes.plot([number(row["bdf_errs"]) for row in group], [k] * len(group), linestyle="", marker="|", markersize=8, color="black")
    logarithmic(axes, "difference, rad (a cart: m; multipliers: 1)")
    axes.set(yscale="linear", xlim=(LEAST, 1), ylim=(len(models) - 0.4, -0.6), yticks=range(len(models)))
    axes.set_yticklabels(models)
    used = dict.fromkeys(sorted((row["right"] for row in rows), key=list(WORDS).index))
    handles = [plt.Line2D([], [], linestyle="", marker="o", markersize=4.5, color=COLOURS[right], label=WORDS[right]) for right in used]
    figure.legend(handles=[*handles, plt.Rectangle((0, 0), 1, 1, color="grey", alpha=0.3, linewidth=0, label="our runs differ by so much"),
                           plt.Line2D([], [], linestyle="", marker="|", markersize=8, color="black",
                                      label="error of BDF at the authors' tolerance")], loc="upper center", ncol=3)
    return figure
