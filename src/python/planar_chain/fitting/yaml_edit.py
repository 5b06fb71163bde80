"""Other numbers in the text of a YAML scene: order, formatting and the comments on other lines stay."""

import re

import yaml

from .varied import NOT_NEGATIVE, leaves
from .recordings import BadFit


def written(value):
    """A number as all YAML readers take it for one."""
    text = f"{float(value):.10g}"
    mantissa, e, exponent = text.partition("e")
    return mantissa + ("" if "." in mantissa else ".0") + e + exponent


def with_fitted(text, deviations, numbers):
    """The text with these numbers. A comment behind one of them, which may be "a guess", gives way to its standard deviation. Both by path."""
    text = with_numbers(text, numbers)
    notes = {}
    for path in numbers:
        notes.setdefault(line_of(text, path.split("/")), []).append(f"{re.search('[^/]+(/[0-9]+)?$', path)[0]} ± {deviations[path]:.2g}")
    ends = {}  # of the last token of each line
    for token in yaml.scan(text, yaml.SafeLoader):
        if token.end_mark.index > token.start_mark.index:
            ends[token.end_mark.line] = token.end_mark.column
    lines = text.split("\n")
    for line, found in notes.items():
        lines[line] = lines[line][:ends[line]] + "  # fitted: " + ", ".join(found)
    return "\n".join(lines)


def line_of(text, keys):
    node = yaml.compose(text, yaml.SafeLoader)
    for key in keys:
        _, node = entry_of(node, key)
    return node.end_mark.line


def with_numbers(text, numbers):
    """The text with these numbers. numbers: by path. Everything else has the value that it had."""
    wanted = values_of(text)
    for path, value in numbers.items():
        wanted["/" + path] = float(value)
    for _ in range(1000):  # a number may stand for several places, which then get their own
        present = values_of(text)
        for path in present.keys() - wanted.keys():  # came by an alias of what got a new entry
            if path.rpartition("/")[2] not in NOT_NEGATIVE:
                raise BadFit(f"--output: expected a text in which {path[1:]} can be left out, got an alias that brings it")
            wanted[path] = 0.0  # as if it were not there
        different = [path for path, value in wanted.items() if not same(present.get(path), value)]
        if not different:
            return text
        text = with_number(text, different[0], wanted)
    raise BadFit("--output: expected a scene whose numbers can be replaced in its text, got one with too many aliases")


def values_of(text):
    return leaves(yaml.safe_load(text))


def same(one, other):
    try:
        return float(one) == float(written(other)) or float(one) == float(other)
    except (TypeError, ValueError):
        return one == other


def with_number(text, path, wanted):
    """The text with one more value, or one other: that of wanted at the path, which begins with a slash."""
    keys, value = path.strip("/").split("/"), scalar(wanted[path])
    whole = (keys, value) if not keys[-1].isdigit() else (keys[:-1], listed(path, wanted))  # of a list that is not there
    node = yaml.compose(text, yaml.SafeLoader)
    for k, key in enumerate(keys):
        found = entry_of(node, key)
        if found is None and isinstance(node, yaml.MappingNode):
            return insert(text, node, whole[0][k:], whole[1])
        if found is None:
            raise BadFit(f"--output: expected a number at {path[1:]} in the scene's text, got something else")
        after, node = found
        if node.start_mark.index < after:  # an alias: its place gets values of its own
            start, end = next(place for place in aliases(text) if place[0] >= after)
            own = value if k + 1 == len(keys) else whole[1] if k + 1 == len(whole[0]) else (
                f"{{<<: {text[start:end]}, {nested(whole[0][k + 1:], whole[1])}}}")
            return text[:start] + own + text[end:]
    return text[:node.start_mark.index] + value + text[node.end_mark.index:]


def scalar(value):
    return written(value) if isinstance(value, float) else yaml.safe_dump(value, default_flow_style=True).split("\n", 1)[0]


def listed(path, wanted):
    above = path.rpartition("/")[0] + "/"
    return "[" + ", ".join(scalar(value) for leaf, value in wanted.items() if leaf.startswith(above)) + "]"


def aliases(text):
    """Where each alias starts and ends."""
    return [(event.start_mark.index, event.end_mark.index) for event in yaml.parse(text, yaml.SafeLoader)
            if isinstance(event, yaml.AliasEvent)]


def entry_of(node, key):
    """The node below this key and where it starts at the earliest. None if it is not there, or comes by a merge."""
    if isinstance(node, yaml.MappingNode):
        return next(((name.end_mark.index, value) for name, value in node.value if name.value == key), None)
    if isinstance(node, yaml.SequenceNode) and key.isdigit() and int(key) < len(node.value):
        starts = [node.start_mark.index, *(item.end_mark.index for item in node.value)]
        return starts[int(key)], node.value[int(key)]
    return None


def nested(keys, value):
    *outer, last = keys
    text = f"{last}: {value}"
    for key in reversed(outer):
        text = f"{key}: {{{text}}}"
    return text


def insert(text, node, keys, value):
    """A new entry at the end of a map."""
    entry = nested(keys, value)
    if node.flow_style:
        end = node.end_mark.index - 1
        before = text[:end].rstrip()
        return before + (", " if node.value else "") + entry + text[len(before):]
    name, last = node.value[-1]
    end = text.find("\n", last_index(last) - 1)
    end = len(text) if end < 0 else end
    return text[:end] + "\n" + " " * name.start_mark.column + entry + text[end:]


def last_index(node):
    """Where the text of a node ends, without blank lines and comments after a block."""
    while not isinstance(node, yaml.ScalarNode) and not node.flow_style and node.value:
        node = node.value[-1][1] if isinstance(node, yaml.MappingNode) else node.value[-1]
    return node.end_mark.index
