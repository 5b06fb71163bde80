"""Equations of motion as formulas: SymPy's objects, and functions in C, MATLAB and Python made from them."""

from .formulas import Formulas, formulas
from .letters import Letter, NoFormula

__all__ = ["Formulas", "Letter", "NoFormula", "formulas"]
