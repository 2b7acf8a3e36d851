"""What the compiled core offers to Python."""

import numpy as np
from numpy.typing import NDArray

BUILT_FROM: str

def has_x86_64_v3() -> bool: ...
def sum_of(values: NDArray[np.float64]) -> float: ...
