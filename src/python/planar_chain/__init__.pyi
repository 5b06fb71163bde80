from ._core import (Energy as Energy, EnergyBalance as EnergyBalance, Failed as Failed, Fault as Fault, FrameMotion as FrameMotion,
                    Measurement as Measurement, NotReached as NotReached, Refused as Refused, Run as Run, Runs as Runs, SavedState as SavedState, Scene as Scene, Simulation as Simulation,
                    Statistics as Statistics, equations as equations, equilibrium as equilibrium, inverse_dynamics as inverse_dynamics,
                    inverse_kinematics as inverse_kinematics,
                    linearize as linearize, simulate as simulate, simulate_many as simulate_many)
from .environment import Box as Box, Environment as Environment
from .fitting.fit import Fit as Fit, fit as fit
from .fitting.recordings import BadFit as BadFit, Recording as Recording
from .modal import Modes as Modes, modes as modes
from .moving import animate as animate
from .symbolic import NoFormula as NoFormula, formulas as formulas
from .systems import state_space as state_space
