from typing import List, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._core import Scene

class Modes:
    q: NDArray[np.float64]
    tau: NDArray[np.float64]
    joints: List[str]
    frequencies: NDArray[np.float64]
    damping: NDArray[np.float64]
    shapes: NDArray[np.number]
    kinds: List[str]
    poles: NDArray[np.complex128]

def modes(scene: Scene, q: Optional[ArrayLike] = ..., t: float = ..., tau: Union[None, str, ArrayLike] = ...,
          friction: str = ...) -> Modes: ...
