"""Measures what Python adds to a step of 5 ms of the double pendulum, the same motion by scipy, and batches."""
import functools
import importlib.metadata
import importlib.util
import statistics
import subprocess
import time

PERIOD = 0.005  # s
EXACT = {"rtol": 1e-10, "atol": 1e-10}
ROD = {"mass": 1.0, "inertia": 1 / 12, "com": [0.5, 0.0], "pin": [1.0, 0.0]}
SCENE = {"chain": ["upper", "lower"], "links": {"upper": {**ROD, "initial": {"angle": 1.2}},
                                                "lower": {**ROD, "initial": {"angle": 0.9}}}}


def why_not():
    """Returns why the study cannot be made; empty if it can."""
    try:
        found = importlib.util.find_spec("planar_chain._core")
    except ImportError:
        found = None
    return "" if found else "Python does not find the module planar_chain"


# ---- One motion, each way takes the times of its ends of steps and returns its last state ----------

def in_cpp(scene, times):
    from planar_chain import simulate  # pylint: disable=import-outside-toplevel
    return simulate(scene, times)[-1]


def in_python(scene, times):
    from planar_chain import Simulation  # pylint: disable=import-outside-toplevel
    simulation = Simulation(scene)
    for t in times:
        simulation.advance_to(t)
    return simulation.state


def with_states(scene, times):
    import numpy  # pylint: disable=import-outside-toplevel
    from planar_chain import Simulation  # pylint: disable=import-outside-toplevel
    simulation = Simulation(scene)
    states = numpy.empty((len(times), 4))
    for state, t in zip(states, times):
        simulation.advance_to(t)
        state[:] = simulation.state
    return states[-1]


@functools.lru_cache()
def right_side(is_compiled):
    """ẏ of two uniform rods of 1 kg and 1 m by Lagrange, y = [q, q̇], solved by hand; as machine code by numba."""
    from math import cos, sin  # pylint: disable=import-outside-toplevel

    def slopes(_, y):
        a, b = y[0], y[0] + y[1]
        u, v = y[2], y[2] + y[3]
        c, s = cos(a - b) / 2, sin(a - b) / 2
        f, g = -s * v * v - 1.5 * 9.81 * cos(a), s * u * u - 0.5 * 9.81 * cos(b)
        det = 4 / 9 - c * c
        alpha, beta = (f / 3 - c * g) / det, (4 / 3 * g - c * f) / det
        return [u, v - u, alpha, beta - alpha]

    if not is_compiled:
        return slopes
    import numba  # pylint: disable=import-outside-toplevel
    machine_code = numba.njit(slopes)
    return lambda t, y: machine_code(t, y)  # scipy's Fortran looks at the arguments of Python's functions


def by_solve_ivp(scene, times, is_compiled=False):
    from scipy.integrate import solve_ivp  # pylint: disable=import-outside-toplevel
    return solve_ivp(right_side(is_compiled), (0, times[-1]), scene.state, "DOP853", times, **EXACT).y[:, -1]


def by_fortran(scene, times):
    from scipy.integrate import ode  # pylint: disable=import-outside-toplevel
    solver = ode(right_side(True)).set_integrator("dop853", nsteps=10**6, **EXACT).set_initial_value(scene.state)
    for t in times:
        state = solver.integrate(t)
    return state


def by_lsoda(scene, times):
    import numpy  # pylint: disable=import-outside-toplevel
    from scipy.integrate import odeint  # pylint: disable=import-outside-toplevel
    return odeint(right_side(True), scene.state, numpy.append(0, times), tfirst=True, **EXACT)[-1]


WAYS = {"planar_chain in C++ (simulate)": in_cpp, "planar_chain from Python (advance_to)": in_python,
        "planar_chain from Python, and each state kept": with_states, "scipy's solve_ivp, DOP853": by_solve_ivp,
        "scipy's solve_ivp, DOP853, ẏ by numba": functools.partial(by_solve_ivp, is_compiled=True),
        "scipy's ode, Fortran's dop853, ẏ by numba": by_fortran, "scipy's odeint, LSODA, ẏ by numba": by_lsoda}


def steps(seconds, runs):
    """Rows of the table: medians of CPU times. What is not installed has no numbers."""
    import numpy  # pylint: disable=import-outside-toplevel
    from planar_chain import Scene, simulate  # pylint: disable=import-outside-toplevel
    scene = Scene(SCENE)
    times = PERIOD * numpy.arange(1, round(seconds / PERIOD) + 1)
    exact = simulate(Scene({**SCENE, "integrator": {"tolerance": 1e-13}}), times[-1:])[0]
    for name, run in WAYS.items():
        row = f'"a step of 5 ms",2,"{name}"'
        try:
            error = abs(run(scene, times) - exact)[:2].max()  # it also warms up
        except ImportError:
            yield f"{row},,,\n"
            continue
        spent = []
        for _ in range(runs):
            began = time.process_time()
            run(scene, times)
            spent.append((time.process_time() - began) / len(times))
        yield f"{row},{statistics.median(spent):.3e},,{error:.1e}\n"


def version(package):
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return "not installed"


def versions():
    return {package: version(package) for package in ("numpy", "scipy", "numba")}


def measure(batches, is_quick):
    """A table with a header. batches: the path of that program."""
    many = subprocess.run([batches, *(("8", "1") if is_quick else ("32", "11"))], stdout=subprocess.PIPE,
                          universal_newlines=True, check=True).stdout
    return "task,links,way,seconds,faster,error\n" + "".join(steps(*((1, 3) if is_quick else (10, 9)))) + many
