"""Markers that the image's edge cuts off.

Nothing is known of the pixels beyond, so a whole disc is fitted to those that there are. It is believed where it leaves
little, is known well (`plausible.whole_disc`), and explains its pixels as well as an ellipse does, that is with

    χ² (disc) / s < χ² (ellipse) / s + EVIDENCE                          (1)

s = max(1, χ² (ellipse) / pixels) forgives what neither explains.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..data.array_types import Floats
from ..native import shape_images
from . import discs
from .patches import CutOut
from .plausible import whole_disc
from .starts import disc_start, ellipse_start

EVIDENCE = 25.0  # of χ², by which a disc must win; chosen, as in `overlap`: studies/overlapping_markers.py judges it


def discs_at_edge(cut: CutOut) -> tuple[NDArray[np.bool_], Floats, Floats]:
    """Which of n groups are one disc that the edge cuts (n), its x, y and r (n, 3), and its centre's cov (n, 2, 2)."""
    whole = discs.fit(shape_images.discs, disc_start(cut, 1), cut.patches)
    any_form = discs.fit(shape_images.ellipse, ellipse_start(cut), cut.patches)
    s = np.maximum(1.0, any_form.chi2 / np.maximum((cut.patches.weight > 0).sum(1), 1))
    sure = whole_disc(whole, cut) & (whole.chi2 < any_form.chi2 + EVIDENCE * s)  # (1)
    r = whole.parameters[:, 2]
    floor = discs.FLOOR / (np.pi * r**2)
    cov = whole.cov[:, :2, :2] * s[:, None, None] + floor[:, None, None] * np.eye(2)
    return sure, whole.parameters[:, :3], cov
