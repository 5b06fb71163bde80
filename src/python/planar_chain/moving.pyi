from typing import Any, Sequence, Tuple, Union

from matplotlib.animation import FuncAnimation
from numpy.typing import ArrayLike

from ._core import Scene

def animate(scene: Scene, times: ArrayLike, states: ArrayLike, points: Sequence[Union[str, Tuple[str, ArrayLike]]] = ...,
            speed: float = ...) -> FuncAnimation: ...
