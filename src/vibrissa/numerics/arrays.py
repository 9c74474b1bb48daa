"""Types of arrays, for annotations."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
StrArray = NDArray[np.str_]
ObjectArray = NDArray[np.object_]
Index = NDArray[np.integer[Any]] | NDArray[np.bool_] | slice | int | list[int] | tuple[Any, ...]
