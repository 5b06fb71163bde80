#!/usr/bin/python3
"""Every #include of the project points down: from a room to rooms below it, never up and never in a circle."""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).absolute().parents[2]

# Each room with the rooms whose headers it may include. Add a room here, with what lies below it.
BELOW = {
    "planar": [],
    "model": ["planar"],
    "reading": ["model"],
    "simd": ["planar"],
    "ode": ["simd"],
    "recursion": ["model"],
    "lanes": ["recursion", "simd"],
    "effects": ["reading", "lanes", "ode"],
    "dynamics": ["effects"],
    "sensors": ["lanes"],
    "scene": ["dynamics"],
    "run": ["scene", "sensors"],
    "batch": ["run"],
    "ros/messages": ["batch"],
    "ros/view": ["ros/messages"],
    "ros/node": ["ros/view"],
    "ros/pull": ["ros/node"],
    "ros/bag": ["ros/node"],
    "python": ["batch"],
    "tools": ["ros/bag"],
    "report": ["tools"],
    "report/benchmark": ["report"],
}

# The room that keeps the promise of a public header.
PUBLIC = {
    "planar.h": "planar",
    "chain.h": "model", "derivatives.h": "model", "events.h": "model", "fault.h": "model", "motion.h": "model", "motion_law.h": "model",
    "scene.h": "model", "sensors.h": "model",
    "value.h": "reading",
    "energy.h": "dynamics", "linear_motor.h": "model", "kane.h": "dynamics", "kinematics.h": "dynamics", "linear_model.h": "dynamics",
    "scene_reader.h": "scene", "urdf_reader.h": "scene",
    "simulation.h": "run",
    "batch.h": "batch",
}

# Of each group of rooms, what its files must not include from outside the project.
FOREIGN = {
    "the core": (lambda room: not room.startswith(("ros/", "report")), r"<(ros|rosbag|tf2_ros|\w+_msgs)/"),
    "ode": (lambda room: room in ("ode", "simd"), r"<(yaml-cpp|tinyxml2)"),
    "the chain": (lambda room: room == "model", r"<(yaml-cpp|tinyxml2)"),
}

INCLUDE = re.compile(r'^#include ([<"][^>"]+[>"])', re.MULTILINE)


def all_below(room):
    found = {room}
    for lower in BELOW[room]:
        found |= all_below(lower)
    return found


def room_of(header):
    """The room of a header as an #include names it; None: not one of ours."""
    if header == "report_build.h":  # made by the build
        return None
    folder, _, name = header.rpartition("/")
    return PUBLIC[name] if folder == "planar_chain" else folder


def files():
    """(file, its room, what it includes of ours, all that it includes)."""
    for folder in ("include/planar_chain", "src"):
        for file in sorted((ROOT / folder).rglob("*")):
            if file.suffix not in (".h", ".cpp"):
                continue
            room = PUBLIC[file.name] if folder != "src" else str(file.relative_to(ROOT / folder).parent)
            includes = INCLUDE.findall(file.read_text(encoding="utf-8"))
            yield file, room, [i[1:-1] for i in includes if i[0] == '"'], includes


def faults():
    graph = {}
    for file, room, ours, includes in files():
        name = file.relative_to(ROOT)
        if room not in BELOW:
            yield f"{name}: {room} is no room; name it in BELOW"
            continue
        spelt = str(name).split("/", 1)[1]
        graph[spelt] = [header for header in ours if room_of(header)]
        for header in ours:
            other = room_of(header)
            if other and other not in all_below(room):
                yield f"{name} ({room}) includes {header} ({other}), which is not below it"
            if str(name).startswith("include/") and not header.startswith("planar_chain/"):
                yield f"{name} is public and includes {header}, which is not"
        for group, (belongs, pattern) in FOREIGN.items():
            for include in includes:
                if belongs(room) and re.match(pattern, include):
                    yield f"{name}: {group} must not include {include}"
    yield from circles(graph)


def circles(graph):
    """Headers that include each other."""
    done, path = set(), []

    def visit(header):
        if header in path:
            yield "a circle: " + " → ".join(path[path.index(header):] + [header])
        elif header not in done:
            path.append(header)
            for other in graph.get(header, []):
                yield from visit(other)
            path.pop()
            done.add(header)

    for header in graph:
        yield from visit(header)


def main():
    found = list(faults())
    print("\n".join(found) if found else "every arrow points down")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
