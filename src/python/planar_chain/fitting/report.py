"""What a fit says: as text, and as an object for JSON."""

import math

import numpy as np


def finite(value):
    """JSON has no infinity."""
    return float(value) if math.isfinite(value) else None


def by_joint(joints, errors):
    return {joint: finite(error) for joint, error in zip(joints, errors)}


def total(errors):
    return float(np.sqrt(np.mean(np.square(errors))))


def table_of_errors(result, title, heads, rows):
    """rows: the cells below the heads, and the error of each joint. The table has their total if they have one unit."""
    if len(set(result.units)) == 1:
        title, joints = f"{title}, {result.units[0]}", [*result.joints, "all"]
        rows = [(cells, [*errors, total(errors)]) for cells, errors in rows]
    else:
        joints = [f"{joint} ({unit})" for joint, unit in zip(result.joints, result.units)]
    return ["", title + ":", *table([[*heads, *joints]] + [[*cells, *(f"{error:.3g}" for error in errors)] for cells, errors in rows])]


def as_json(result):
    joints = result.joints
    return {
        "units": dict(zip(joints, result.units)),
        "converged": result.converged, "interrupted": result.interrupted, "reason": result.reason, "bad": result.bad,
        "numbers": [{"path": found.path, "value": found.value, "deviation": finite(found.deviation), "first": found.first,
                     "low": finite(found.low), "high": finite(found.high), "at_bound": found.at_bound} for found in result.numbers],
        "correlation_time": result.correlation_time, "noise": by_joint(joints, result.noise),
        "not_told": result.not_told, "warnings": result.warnings,
        "data": [{"name": name, "until": until, "error": by_joint(joints, error), "state": state.tolist(), "offsets": by_joint(joints, offsets),
                  "delay": delay} for (name, error), until, state, offsets, delay in
                 zip(result.errors, result.until, result.states, result.offsets, result.delays)],
        "predictions": [{"name": one.name, "from_first_sample": by_joint(joints, one.from_first_sample),
                         "from_first_window": by_joint(joints, one.from_first_window),
                         "from_fitted_start": by_joint(joints, one.from_fitted_start)} for one in result.predictions],
        "runs": result.runs, "evaluations": result.evaluations}


def table(rows):
    """Lines of columns as wide as needed, the first from the left."""
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return ["  " + "  ".join(cell.ljust(width) if k == 0 else cell.rjust(width) for k, (cell, width) in enumerate(zip(row, widths)))
            for row in rows]


def as_text(result):
    rows = [["number", "value", "deviation", "first"]]
    rows += [[found.path, f"{found.value:.6g}", f"{found.deviation:.2g}", f"{found.first:g}"] for found in result.numbers]
    lines = [f"The fit is bad: {result.bad}.", ""] * bool(result.bad) + table(rows)
    if result.correlation_time > 1:
        lines.append(f"  Residuals correlate over {result.correlation_time:.0f} samples; the deviations count each {result.correlation_time:.0f} as one.")
    lines += section("Not determined by the data", result.not_told)
    lines += section("Warnings", result.warnings)
    lines += table_of_errors(result, "Error on the data, root mean square", ["recording", "until"],
                             [([name, f"{end:.4g} s"], errors) for (name, errors), end in zip(result.errors, result.until)])
    for k, offsets in enumerate(result.offsets):
        if np.any(offsets):
            words = ", ".join(f"{offset:+.5f} {unit}" for offset, unit in zip(offsets, result.units))
            lines.append(f"  {result.recordings[k].name}: offsets of the encoders {words}")
        if result.delays[k]:
            lines.append(f"  {result.recordings[k].name}: delay {1e3 * result.delays[k]:.2f} ms")
    if result.predictions:
        lines += table_of_errors(result, "Error of the predictions", ["recording", "start"], [
            ([one.name, start], errors) for one in result.predictions for start, errors in (
                ("first sample", one.from_first_sample), ("fitted to the first window", one.from_first_window),
                ("fitted to all", one.from_fitted_start))])
    return "\n".join(lines)


def section(title, sentences):
    return ["", title + ":", *(f"  - {sentence}" for sentence in sentences)] if sentences else []
