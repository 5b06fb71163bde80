#!/usr/bin/python3
"""Effects that a scene lacks do not run in the loop, by callgrind: no function of theirs, and no line inlined elsewhere.

    left_out_test.py BIN [unittest options]        BIN: the folder that holds simulate
"""
import os
import re
import sys
import tempfile
import unittest

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../support"))
import callgrind  # noqa: E402

BIN = ""

# What belongs to an effect: (functions, source files); a cost is the effect's if both match.
ANYWHERE = r""
# Once for many steps, or for a step of an implicit method, or at a contact, it may be asked for.
IN_EVALUATIONS = (r"^(?!planar_chain::Simulation::|planar_chain::Dynamics::(timeDerivative|enter|change|switched)"
                  r"|planar_chain::Effects::(enter|enterState|change|listActive|until|longestStep|findStiffness)"
                  r"|planar_chain::(Springs|\(anonymous namespace\)::SpringEffect)::(addStiffness|acting))")
EFFECTS = {
    "springs and dampers": [(IN_EVALUATIONS, r"^springs\.")],
    "limits": [(ANYWHERE, r"^(stops|switches)\.")],
    "loads": [(ANYWHERE, r"^(loads|timed_terms)\.cpp$"), (IN_EVALUATIONS, r"^timed_terms\.h$")],
    "springs to the ground and air drag": [(ANYWHERE, r"^(ground_springs|air_drag|point_forces)\.cpp$")],
    "implicit solve": [(ANYWHERE, r"^(linearized|linearized_segments|linear_kernel|rosenbrock|radau)\.")],
    "what is published": [(r"Simulation::(energy|jointTorques|linkMotions)|::Messages::", ANYWHERE),
                          (r"Dynamics::(jointTorques|linkMotions)", ANYWHERE)],
}

# What a scene must say to have it: keys of each joint, of the scene; the method.
SPRINGS = "stiffness: 10, damping: 0.1, "
LIMITS = "lower: -0.1, upper: 0.1, stop_stiffness: 1000, stop_damping: 1, "
LOADS = """
loads:
  turn: {joint: link_1_joint, torque: 1}
  push: {link: link_2, force: [1, 0], moment: 1, frequency: 1}
"""
SCENES = {
    "springs and dampers": (SPRINGS, "", "dopri5"),
    "limits": (LIMITS, "", "dopri5"),
    "loads": ("", LOADS, "dopri5"),
    "springs to the ground and air drag": ("", "springs: {rope: {link: link_2, ground: [1, 1], stiffness: 10}}", "dopri5"),
    "implicit solve": ("", "", "rodas5p"),
}
LENGTHS = {"link by link": 3, "in segments": 100}


def costs(links, joint, more, method, inside="planar_chain::Simulation::advanceTo(*"):
    """Instructions by (function, file) while a chain of so many links moves."""
    scene = f"""
chain: [link]
links:
  link: {{mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0], repeat: {links}, joint: {{{joint}}},
         initial: {{angle: 0.05}}}}
{more}
integrator: {{method: {method}, tolerance: 1e-4, step: 0.001}}
"""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "scene.yaml")
        with open(path, "w") as file:
            file.write(scene)
        command = [os.path.join(BIN, "simulate"), path, "--duration", "0.1", "--rate", "100",
                   "--csv", os.path.join(folder, "out.csv")]
        return callgrind.run(command, inside)[1].where


def of_effect(where, effect):
    """The calls that belong to the effect, in words."""
    return [f"{count} in {file}: {function}" for (function, file), count in where.most_common()
            if any(re.search(functions, function) and re.search(files, file) for functions, files in EFFECTS[effect])]


class LeftOut(unittest.TestCase):
    def check(self, where, effect, runs):
        found = of_effect(where, effect)
        if bool(found) != runs:
            self.fail("\n".join(["instructions that nobody needs:", *found] if found else ["nothing of it runs"]))

    def test_a_bare_chain_runs_nothing_of_any_effect(self):
        for length, links in LENGTHS.items():
            for method in ("rk4", "dopri5"):
                where = costs(links, "", "", method)
                self.assertGreater(sum(where.values()), 10000)
                for effect in EFFECTS:
                    with self.subTest(effect=effect, length=length, method=method):
                        self.check(where, effect, False)

    def test_what_a_scene_has_is_seen_and_nothing_else(self):
        for length, links in LENGTHS.items():
            for own, scene in SCENES.items():
                where = costs(links, *scene)
                for effect in EFFECTS:
                    with self.subTest(scene=own, effect=effect, length=length):
                        self.check(where, effect, effect == own)

    def test_what_is_published_is_seen_where_it_is_written(self):
        where = costs(3, "", "", "dopri5", inside="main")
        self.check(where, "what is published", True)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    BIN = sys.argv.pop(1)
    unittest.main()
