from ._core import (Energy as Energy, EnergyBalance as EnergyBalance, Failed as Failed, Fault as Fault,
                    Refused as Refused, Scene as Scene, Simulation as Simulation, Statistics as Statistics,
                    equations as equations, equilibrium as equilibrium, inverse_dynamics as inverse_dynamics,
                    linearize as linearize, simulate as simulate)
