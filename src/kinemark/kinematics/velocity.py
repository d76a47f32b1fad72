"""How fast a body or a joint turns.

Between the frames before and after, R turns by R(t + h) R(t − h)ᵀ; its rotation vector over 2 h is

    ω(t) = log(R(t + h) R(t − h)ᵀ) / 2 h                                                                (1)

in the axes that R's columns are written in: exact for a steady turn whatever its axis, and no differences of angles,
which break where angles jump or lock.
"""

from __future__ import annotations

import numpy as np
import scipy

from ..data.array_types import Floats


def angular_velocity(R: Floats, *, rate: float) -> Floats:
    """ω (F, 3) deg/s of rotations R (F, 3, 3), NaN at both ends and beside missing frames.

    Of a joint's matrices (child in parent) it is the child's velocity against the parent, in the parent's axes; of a
    segment's axes, in the laboratory.

    Raises:
        ValueError: R has another shape or the rate is not above 0.
    """
    if R.ndim != 3 or R.shape[1:] != (3, 3) or not rate > 0:
        raise ValueError(f"R has shape {R.shape} and rate is {rate}, wanted (F, 3, 3) and a rate above 0")
    omega = np.full((len(R), 3), np.nan)
    turn = R[2:] @ np.swapaxes(R[:-2], 1, 2)
    known = np.isfinite(turn).all((1, 2))
    if known.any():
        omega[1:-1][known] = (
            np.degrees(scipy.spatial.transform.Rotation.from_matrix(turn[known]).as_rotvec()) * rate / 2
        )  # (1)
    return omega
