from typing import Any, Dict, List

from .._core import Scene

class NoFormula(ValueError): ...

class Letter:
    symbol: Any
    value: float
    unit: str
    meaning: str
    latex: str

class Formulas:
    links: List[str]
    joints: List[str]
    driven: List[int]
    letters: Dict[Any, Letter]
    given: Dict[Any, Any]
    closed: Any
    def __getattr__(self, name: str) -> Any: ...
    @property
    def absolute(self) -> Dict[Any, Any]: ...
    @property
    def acting(self) -> Dict[Any, Any]: ...
    def in_q(self, expression: Any) -> Any: ...
    def used_letters(self) -> Dict[Any, Letter]: ...
    def with_numbers(self) -> Formulas: ...

def formulas(scene: Scene) -> Formulas: ...
