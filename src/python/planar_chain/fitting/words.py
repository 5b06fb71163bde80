"""What the data cannot tell, in words."""

import numpy as np

from .deviations import SMALL
from .varied import value_at

ALONE = 0.9999  # the part of a number in the lost directions from which on it is lost by itself
ORTHOGONAL = 0.03
DIFFERENCE = 1e-6  # of a number, relative: half the digits are left for the slope


def combinations(scene_values, numbers):
    """Functions of the numbers' values that free swings see, by their words: of each link, and with what hangs on it."""
    chain = scene_values["chain"]
    links = scene_values["links"]

    def reader(values):
        given = {number.path: value for number, value in zip(numbers, values)}

        def read(link, key):
            path = f"links/{link}/{key}"
            return given.get(path, value_at(scene_values, path) or 0.0)
        return read

    def moment(link):
        return lambda values: reader(values)(link, "mass") * reader(values)(link, "com/0")

    def inertia(link):
        def about_pin(values):
            read = reader(values)
            return read(link, "inertia") + read(link, "mass") * (read(link, "com/0") ** 2 + read(link, "com/1") ** 2)
        return about_pin

    def outer(values, k):
        return sum(reader(values)(link, "mass") * float(links[link].get("repeat", 1)) for link in chain[k + 1:])

    def with_outer(k, own, power):
        return lambda values: own(values) + outer(values, k) * reader(values)(chain[k], "pin/0") ** power

    def ratio(above, below):
        return lambda values: above(values) / (below(values) or 1.0)

    for k, link in enumerate(chain):
        one, two = moment(link), inertia(link)
        yield f"mass·com of {link}", one
        yield f"inertia + mass·com² of {link} (about its inner pin)", two
        yield f"(inertia + mass·com²)/(mass·com) of {link}", ratio(two, one)
        if k + 1 < len(chain):
            both = with_outer(k, one, 1), with_outer(k, two, 2)
            yield f"mass·com of {link} + pin·(masses beyond)", both[0]
            yield f"inertia + mass·com² of {link} + pin²·(masses beyond)", both[1]
            yield (f"the ratio of inertia + mass·com² + pin²·(masses beyond) and mass·com + pin·(masses beyond), of {link}",
                   ratio(both[1], both[0]))


def gradient(function, values, sizes):
    """The gradient of a combination by relative changes of the numbers, scaled to length 1."""
    base, slopes = function(values), []
    for k, size in enumerate(sizes):
        moved = np.array(values)
        moved[k] += DIFFERENCE * size
        slopes.append((function(moved) - base) / DIFFERENCE)
    length = np.linalg.norm(slopes)
    return np.array(slopes) / length if length > 0 else None


def not_told(deviations, scene_values):
    """A list of sentences: each direction that the data leave open, and then what is seen of the numbers in it."""
    numbers, lost = deviations.numbers, deviations.lost
    if not len(lost):
        return []
    sentences = []
    involved = np.linalg.norm(lost, axis=0)
    alone = [k for k, size in enumerate(involved) if size > ALONE]
    sentences += [f"{numbers[k].path} is not seen" for k in alone]
    together = np.flatnonzero((involved > SMALL) & (involved <= ALONE))
    if len(together):
        sentences.append(f"{names(numbers[k].path for k in together)} cannot all be told apart: the data leave "
                         f"{counted(len(lost) - len(alone), 'combination')} of them open. Leave out of --vary what you know otherwise")
        seen = seen_of(deviations, scene_values, together)
        if seen:
            sentences.append(f"only {'; '.join(seen)} {'is' if len(seen) == 1 else 'are'} seen")
        sentences += [in_percent(numbers, row) for row in lost if max(abs(np.delete(row, alone)), default=0) > SMALL]
    return sentences


def seen_of(deviations, scene_values, together):
    """The combinations of these numbers that no lost direction changes."""
    numbers, seen, basis = deviations.numbers, [], np.zeros((0, len(deviations.numbers)))
    for words, function in combinations(scene_values, numbers) if "links" in scene_values else ():
        slopes = gradient(function, deviations.values, deviations.sizes)
        if slopes is None or (abs(slopes[together]) > SMALL).sum() < 2 or np.linalg.norm(deviations.lost @ slopes) > ORTHOGONAL:
            continue
        rest = slopes - basis.T @ (basis @ slopes)
        if np.linalg.norm(rest) > SMALL:  # else what is listed already says it
            basis = np.vstack([basis, rest / np.linalg.norm(rest)])
            seen.append(words)
    return seen


def in_percent(numbers, direction):
    direction = direction / direction[abs(direction).argmax()]
    parts = [f"{number.path} {100 * part:+.0f} %" for number, part in zip(numbers, direction) if abs(part) > SMALL / 2]
    return f"open: {', '.join(parts)}, together, change next to nothing that was measured"


def names(paths):
    *most, last = paths
    return f"{', '.join(most)} and {last}" if most else last


def counted(count, what):
    return f"{count} {what}{'' if count == 1 else 's'}"
