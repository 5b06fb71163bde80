"""auto beside the next best program: a cell is a scene and an error of the angles. The aim is at most half of that program's time."""
import collections

from results import AUTO, OWN, times_to

LEVELS = {3: "1e-3", 6: "1e-6", 9: "1e-9"}  # rad
UNDER_OUR_EQUATIONS = ("odeint", "SUNDIALS")  # integrators of others: no program of theirs
AIM = 0.5

# Times in s, None where the error is not reached; best: (engine, method) of the next best program.
Cell = collections.namedtuple("Cell", "scene error ours best theirs ratio")


def cells(scenes):
    for scene, facts in scenes.items():
        reached = times_to(facts["rows"])
        ours = reached.get(AUTO, {})
        others = {who: times for who, times in reached.items() if who[0] not in (OWN, *UNDER_OUR_EQUATIONS)}
        for level, error in LEVELS.items():
            best = min((who for who, times in others.items() if level in times), key=lambda who: others[who][level], default=None)
            theirs = others[best][level] if best else None
            yield Cell(scene, error, ours.get(level), best, theirs, ours[level] / theirs if best and level in ours else None)


def told(cell):
    beside = (f"{1e3 * cell.ours:.3g} beside {1e3 * cell.theirs:.3g} ms, ratio {cell.ratio:.2f}" if cell.ratio else
              f"{1e3 * cell.theirs:.3g} ms, not reached by auto")
    return f"{cell.scene} to {cell.error} ({cell.best[0]}: {beside})"


def first_lines(scenes):
    """What others do better, and where the aim is missed."""
    both = [cell for cell in cells(scenes) if cell.best]
    faster = [cell for cell in both if not cell.ratio or cell.ratio > 1]
    missed = [cell for cell in both if cell.ratio and AIM < cell.ratio <= 1]
    if not both:
        return "No other program was measured."
    return " ".join([
        f"Another program reaches {len(both)} cells (a scene, to an error of 1e-3, 1e-6 or 1e-9 rad). auto takes at most half of the next "
        f"best program's time in {len(both) - len(faster) - len(missed)} of them.",
        f"Another program is faster in {len(faster)}: {'; '.join(map(told, faster))}." if faster else "No other program is faster in any.",
        *([f"auto takes more than half of its time in {len(missed)}: {'; '.join(map(told, missed))}."] if missed else []),
        f"Not counted: integrators of others under our own equations ({', '.join(UNDER_OUR_EQUATIONS)})."])
