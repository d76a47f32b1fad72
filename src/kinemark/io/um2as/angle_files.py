"""Files of angles: `.shd`, `.elb` and `.wst` (UM²AS figure 3.21).

The thesis prints a `.wst` with φ, θ and ψ. For the elbow, whose angles are φ₂ and ψ₂ alone (3.3), it prints no file;
here `.elb` has these two columns, and one of three, with θ₂ between them, is read as well.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from ...data import KinemarkError
from ...data.array_types import Floats
from .tab_tables import read_rows, write_rows

ENDINGS = {"shoulder": ".shd", "elbow": ".elb", "wrist": ".wst"}
DECIMALS = 2  # of an angle in deg; of the format (UM²AS, appendix)


def read_angles(path: Path | str) -> Floats:
    """(F, 3) deg: φ, θ and ψ of one joint; θ is NaN where an elbow's file has only φ and ψ.

    Raises:
        KinemarkError: the ending is another one, or a row is wrong.
    """
    elbow = _ending(path) == ".elb"
    rows = read_rows(path, 2, 3) if elbow else read_rows(path, 3)
    if rows.header:
        raise KinemarkError(f"{path} has a header, and files of angles have none. Is it a .tdc file?")
    if rows.values.shape[1] == 3:
        return rows.values
    return np.insert(rows.values, 1, np.nan, axis=1)


def write_angles(path: Path | str, deg: ArrayLike) -> None:
    """Write φ, θ and ψ (F, 3) deg of one joint; of the elbow φ and ψ.

    Raises:
        ValueError: deg has another shape.
        KinemarkError: the ending is none of the three, or the file cannot be written.
    """
    deg = np.asarray(deg, np.float64)
    if deg.ndim != 2 or deg.shape[1] != 3 or not len(deg):
        raise ValueError(f"deg has shape {deg.shape}, wanted (frames, 3)")
    write_rows(path, deg[:, ::2] if _ending(path) == ".elb" else deg, decimals=DECIMALS)


def _ending(path: Path | str) -> str:
    suffix = Path(path).suffix.lower()
    if suffix not in ENDINGS.values():
        raise KinemarkError(f"{path} does not end in {', '.join(ENDINGS.values())}. Name it after its joint.")
    return suffix
