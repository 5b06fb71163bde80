from typing import Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._core import Scene

_Array = NDArray[np.float64]

def state_space(scene: Scene, inputs: Sequence[str], outputs: Sequence[str], q: Optional[ArrayLike] = ..., qd: Optional[ArrayLike] = ...,
                t: float = ..., tau: Union[None, str, ArrayLike] = ..., friction: str = ..., motors: bool = ...) -> Tuple[_Array, _Array, _Array, _Array]: ...
