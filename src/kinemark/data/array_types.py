"""Names for the array types that signatures use most. Shapes and units are in the docstrings."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
"""Double precision."""

Ints: TypeAlias = NDArray[np.int64]
"""Indices and counts."""

Bools: TypeAlias = NDArray[np.bool_]
"""Masks."""

GreyLevels: TypeAlias = NDArray[np.uint8 | np.uint16]
"""Pixels of images of 8 or 16 bits."""
