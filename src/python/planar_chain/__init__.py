"""Planar chains of rigid bodies on numpy arrays: Scene, Simulation, simulate, fit and more.

The messages are in planar_chain.msg and planar_chain.srv. A program that takes them alone loads nothing else."""

import importlib

_HOMES = {"BadFit": "fitting.recordings", "Box": "environment", "Environment": "environment", "Fit": "fitting.fit",
          "Recording": "fitting.recordings", "fit": "fitting.fit", "NoFormula": "symbolic",
          "formulas": "symbolic", "Modes": "modal", "modes": "modal", "state_space": "systems", "animate": "moving", **{name: "_core" for name in (
    "Energy", "EnergyBalance", "Failed", "Fault", "FrameMotion", "Measurement", "NotReached", "Refused", "Run", "Runs", "SavedState", "Scene", "Simulation", "Statistics", "equations",
    "equilibrium", "inverse_dynamics", "inverse_kinematics", "linearize", "simulate", "simulate_many")}}
__all__ = list(_HOMES)


def __getattr__(name):
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module("." + _HOMES[name], __name__), name)
    globals()[name] = value
    return value


def __dir__():
    return sorted({*globals(), *__all__})
