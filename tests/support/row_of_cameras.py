"""Cameras in a row, all as high: no line of two of them tells that one is turned about the vertical."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from kinemark.data import Rig
from support.laboratory import camera


def row(n):
    """n cameras in a row, all as high."""
    return Rig(tuple(camera(f"c{i}", (x, -4200.0, 1100.0)) for i, x in enumerate(np.linspace(-2500, 2500, n))))


def turned(rig, angles):
    """The cameras turned about the vertical by angles in rad."""
    return replace(
        rig,
        cameras=tuple(
            replace(one, R=(R := one.R @ Rotation.from_euler("z", by).as_matrix()), t=-R @ one.centre)
            for one, by in zip(rig, angles, strict=True)
        ),
    )
