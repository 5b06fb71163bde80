#!/usr/bin/python3
"""What Python adds to a step of 5 ms of the double pendulum, and the same motion by scipy's integrators.

    speed.py [SECONDS]      simulated time of each run; prints medians of nine, in CPU time
"""
import functools
import statistics
import sys
import time

import numpy as np
from planar_chain import Scene, Simulation, simulate

PERIOD = 0.005  # s
ROD = {"mass": 1.0, "inertia": 1 / 12, "com": [0.5, 0.0], "pin": [1.0, 0.0]}
SCENE = Scene({"chain": ["upper", "lower"], "links": {"upper": {**ROD, "initial": {"angle": 1.2}},
                                                      "lower": {**ROD, "initial": {"angle": 0.9}}}})


def in_cpp(times):
    return simulate(SCENE, times)[-1]


def in_python(times):
    simulation = Simulation(SCENE)
    for t in times:
        simulation.advance_to(t)
    return simulation.state


def with_states(times):
    simulation = Simulation(SCENE)
    states = np.empty((len(times), 4))
    for state, t in zip(states, times):
        simulation.advance_to(t)
        state[:] = simulation.state
    return states[-1]


def right_side(_, y):
    """ẏ of two uniform rods of 1 kg and 1 m by Lagrange, y = [q, q̇], solved by hand."""
    a, b = y[0], y[0] + y[1]
    u, v = y[2], y[2] + y[3]
    c, s = np.cos(a - b) / 2, np.sin(a - b) / 2
    f, g = -s * v * v - 1.5 * 9.81 * np.cos(a), s * u * u - 0.5 * 9.81 * np.cos(b)
    det = 4 / 9 - c * c
    alpha, beta = (f / 3 - c * g) / det, (4 / 3 * g - c * f) / det
    return [u, v - u, alpha, beta - alpha]


EXACT = {"rtol": 1e-10, "atol": 1e-10}


def by_scipy(times, f=right_side):
    from scipy.integrate import solve_ivp
    return solve_ivp(f, (0, times[-1]), SCENE.state, "DOP853", times, **EXACT).y[:, -1]


@functools.lru_cache()
def compiled():
    """ẏ as machine code by numba."""
    import numba
    f = numba.njit(right_side)
    f(0.0, SCENE.state)
    return lambda t, y: f(t, y)  # scipy's Fortran looks at the arguments of Python's functions


def by_scipy_compiled(times):
    return by_scipy(times, compiled())


def by_fortran(times):
    from scipy.integrate import ode
    solver = ode(compiled()).set_integrator("dop853", nsteps=10**6, **EXACT).set_initial_value(SCENE.state)
    for t in times:
        state = solver.integrate(t)
    return state


def by_lsoda(times):
    from scipy.integrate import odeint
    return odeint(compiled(), SCENE.state, np.append(0, times), tfirst=True, **EXACT)[-1]


def main():
    times = PERIOD * np.arange(1, round(float(sys.argv[1] if len(sys.argv) > 1 else 10) / PERIOD) + 1)
    exact = simulate(Scene({**SCENE.to_dict(), "integrator": {"tolerance": 1e-13}}), times[-1:])[0]
    print("| loop over steps of 5 ms | µs per step | error of an angle, rad |\n|---|--:|--:|")
    for name, run in (("C++ (`simulate`)", in_cpp), ("Python (`advance_to`)", in_python),
                      ("Python, and each state kept", with_states), ("scipy's `solve_ivp`, DOP853", by_scipy),
                      ("the same, ẏ by numba", by_scipy_compiled), ("scipy's `ode`, Fortran's dop853, ẏ by numba", by_fortran),
                      ("scipy's `odeint`, LSODA, ẏ by numba", by_lsoda)):
        spent = []
        for _ in range(9):
            began = time.process_time()
            try:
                end = run(times)
            except ImportError as missing:
                print(f"| {name} | {missing} | |")
                break
            spent.append((time.process_time() - began) / len(times) * 1e6)
        else:
            print(f"| {name} | {statistics.median(spent):.2f} | {abs(end - exact)[:2].max():.1e} |")


if __name__ == "__main__":
    main()
