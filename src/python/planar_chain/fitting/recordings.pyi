from typing import Any, Dict, List, Optional

import numpy as np
from numpy.typing import ArrayLike, NDArray

_Array = NDArray[np.float64]

class BadFit(ValueError): ...

class Recording:
    name: str
    start: float
    t: _Array
    q: _Array
    qd: Optional[_Array]
    loads: Dict[str, Any]
    def __init__(self, name: str, t: ArrayLike, q: ArrayLike, qd: Optional[ArrayLike] = ..., loads: Optional[Dict[str, Any]] = ...,
                 start: float = ...) -> None: ...
    def __len__(self) -> int: ...
    @property
    def duration(self) -> float: ...
    def pieces(self, seconds: float) -> List[Recording]: ...
