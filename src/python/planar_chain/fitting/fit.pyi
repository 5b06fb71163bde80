from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from planar_chain._core import Scene

from .recordings import Recording

_Array = NDArray[np.float64]
_Recordings = Union[str, Recording, Dict[str, Any], Sequence[Union[str, Recording, Dict[str, Any]]]]
_Vary = Union[str, Sequence[str], Dict[str, Union[None, float, Tuple[float, float, float]]]]

class Found:
    path: str
    value: float
    deviation: float
    first: float
    low: float
    high: float
    at_bound: str

class Prediction:
    name: str
    from_first_sample: _Array
    from_first_window: _Array
    from_fitted_start: _Array

class Fit:
    joints: List[str]
    units: List[str]
    numbers: List[Found]
    scene: Scene
    covariance: _Array
    correlation_time: float
    noise: _Array
    pair: Optional[Tuple[int, int]]
    recordings: List[Recording]
    angles: List[_Array]
    errors: List[Tuple[str, _Array]]
    until: List[float]
    states: List[_Array]
    offsets: List[_Array]
    delays: List[Optional[float]]
    not_told: List[str]
    warnings: List[str]
    open: List[str]
    combinations: int
    predictions: List[Prediction]
    converged: bool
    interrupted: bool
    reason: str
    bad: str
    runs: int
    evaluations: int

def fit(scene: Union[str, Scene], recordings: _Recordings, vary: _Vary, *, predict: _Recordings = ..., offsets: bool = ...,
        delay: bool = ..., effort: bool = ..., node: Optional[str] = ..., many_turns: bool = ..., pieces: Optional[float] = ...,
        windows: Sequence[float] = ..., progress: Optional[Callable[[float, float, int], None]] = ...) -> Fit: ...
