"""What the model lacks, from the residuals: whether a torque that it does not have would explain them.

A small torque of a shape such as -sign q̇ along the fitted motion changes the angles by c. Only the part of c counts that no unknown
of the fit can make. The share of the residuals' squares that it explains, and the sign of its factor, decide. A damper that was fitted
can hide dry friction and drag from each other, so two shapes are also judged together."""

import itertools

import numpy as np

from planar_chain import Scene, simulate_many

from .varied import AT_BOUND, NOT_ZERO, value_at
from .problem import is_floating, joint_links, most_steps

SHARE, SHARE_OF_TWO = 0.25, 0.5  # of the residuals' squares that a hint explains at least; that two shapes do
OWN = 1e-3  # the part of a change that no unknown can do; less is an error of the differences
ALIKE = 0.9  # of the best share of a joint: others above it are named too
PROBE = 1e-3  # of the torque of a probe, in the chain's typical torque
DEPENDENT = 1e-9  # of the largest singular value: unknowns that do less do nothing beside the errors of differences
SAME = 1e-4  # the same of shapes: two that differ by less are one
DELAY = 1e-3  # s: the difference for a delay
SHAPES = {  # the torque along a motion; the key of a joint that gives it, and what it is
    "sign q̇": (lambda q, qd: -np.sign(qd), "friction", "dry friction"),
    "q̇ |q̇|": (lambda q, qd: -qd * abs(qd), "drag", "drag"),
    "q̇": (lambda q, qd: -qd, "damping", "damping"),
}
MOST_RECORDINGS, MOST_JOINTS, MOST_TIMES = 4, 6, 400


def hints(problem, solution):
    """A list of sentences: the strongest of each joint, and what explains nearly as much."""
    if max(solution.noise) < problem.errors_of_runs:
        return []
    few = [indices[::-(-len(indices) // MOST_TIMES)] if r < MOST_RECORDINGS else indices[:0] for r, indices in enumerate(solution.samples)]
    used = [r for r, indices in enumerate(few) if len(indices)]
    low, high = problem.bounds()
    inside = (solution.x > low + AT_BOUND) & (solution.x < high - AT_BOUND)  # what ran to its bound cannot do more
    unknowns = problem.jacobian(solution.x, few)[:, inside] / solution.noise[problem.joints_of(few)][:, None]
    residuals = problem.residuals(solution.x, few) / solution.noise[problem.joints_of(few)]
    basis, values, _ = np.linalg.svd(unknowns, full_matrices=False)
    basis = basis[:, values > DEPENDENT * values.max(initial=NOT_ZERO)]
    left = residuals - basis @ (basis.T @ residuals)

    def judged(*columns):
        """The share that these explain, and their least factor."""
        columns = np.transpose(columns) / solution.noise[problem.joints_of(few)][:, None]
        rest = columns - basis @ (basis.T @ columns)
        if not np.isfinite(rest).all() or (np.sum(rest ** 2, axis=0) <= OWN ** 2 * np.sum(columns ** 2, axis=0)).any():
            return 0.0, 0.0
        factors = np.linalg.lstsq(rest, left, rcond=SAME)[0]
        return 1 - np.sum((left - rest @ factors) ** 2) / (left @ left), -max(factors)

    said, fitted = [], [number.path for number in problem.numbers]
    links = joint_links(problem.values)
    for j in [j for j in problem.free if not is_floating(problem.values, links[j])][:MOST_JOINTS]:
        lacking = {shape: (f"links/{links[j]}/joint/{key}", what, probe(problem, solution, few, used, j, torque))
                   for shape, (torque, key, what) in SHAPES.items()
                   if f"links/{links[j]}/joint/{key}" not in fitted}
        said += of_joint(problem, problem.joints[j], lacking, judged)
    if not problem.has_delay and any(recording.loads for recording in problem.recordings):
        share, factor = judged(of_delay(problem, solution, few))
        if share > SHARE and factor > 0:
            said.append(f"residuals correlate with a delay of {1e3 * factor:.1f} ms between torque and motion ({100 * share:.0f} % of their "
                        "squares): try --delay")
    return said


def of_joint(problem, joint, lacking, judged):
    """The strongest hints of a joint, of one shape; if there is none, of two."""
    for count, least in ((1, SHARE), (2, SHARE_OF_TWO)):
        found = []
        for shapes in itertools.combinations(lacking, count):
            paths, whats, columns = zip(*(lacking[shape] for shape in shapes))
            share, factor = judged(*columns)
            if share > least and factor > 0:
                vary = " ".join(path if value_at(problem.values, path) else path + "=0" for path in paths)
                found.append((share, f"residuals correlate with {' and '.join(shapes)} of {joint}{', together' * (count - 1)} "
                                     f"({100 * share:.0f} % of their squares): the model lacks {' and '.join(whats)}; try --vary {vary}"))
        if found:
            return [words for share, words in sorted(found, reverse=True) if share > ALIKE * max(found)[0]]
    return []


def probe(problem, solution, samples, used, j, torque):
    """The change of the residuals by a small torque of a shape in joint j, over its factor."""
    angles, n = [np.zeros((0, len(problem.joints)))] * len(samples), len(problem.joints)
    for r in used:
        recording, (values, state, _, delay) = problem.recordings[r], problem.parts(solution.x, r)
        scene, parameters = problem.scene_of(r, delay, values), problem.parameters(r, [values] * 2)
        t = np.round(recording.t[samples[r]], 12)
        motion = simulate_many(scene, t, initial=[state] * 2, parameters=parameters, most_steps=most_steps(t)).states[0]
        shape = np.nan_to_num(torque(motion[:, :n], motion[:, n:])[:, j])
        size = PROBE * max(number.scale for number in problem.numbers) / max(abs(shape).max(), NOT_ZERO)
        tree = scene.to_dict()
        loads = {**(tree.get("loads") or {}), "fit_probe": {"joint": problem.joints[j], "torque": 0.0, "times": t.tolist(),
                                                            "values": shape.tolist()}}
        runs = simulate_many(Scene({**tree, "loads": loads}), t, initial=[state] * 2,
                             parameters={**parameters, "loads/fit_probe/torque": [-size, size]}, most_steps=most_steps(t)).states[:, :, :n]
        angles[r] = np.nan_to_num((runs[1] - runs[0]) / (2 * size))
    return np.concatenate([motion[mask] for motion, mask in zip(angles, problem.measured(samples))])


def of_delay(problem, solution, samples):
    rows = [(r, *problem.parts(solution.x, r)[:2], delay) for r in range(len(problem.recordings)) for delay in (0.0, DELAY)]
    motions = problem.motions(rows, samples)
    changes = [np.nan_to_num((late - prompt) / DELAY) for prompt, late in zip(motions[::2], motions[1::2])]
    return np.concatenate([change[mask] for change, mask in zip(changes, problem.measured(samples))])
