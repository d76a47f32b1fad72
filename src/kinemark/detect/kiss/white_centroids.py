"""The centroid of a group is the mean of its white pixels, and how exact that is.

    x_c = Σ x_i / n,    y_c = Σ y_i / n                                  (2)

Which pixels are white tells where the outline crosses a line only to within a pixel: each end of a run is wrong by an
amount evenly spread over one pixel, of variance 1/12. An end at distance e from the centroid moves it by e / A for
every pixel, so

    var x_c = Σ e² / (12 A²), over the ends of all rows,                 (A)

and var y_c the same over the ends of all columns. An ellipse with half axes a = w/2, b = h/2 has half rows
a √(1 − y²/b²), thus Σ e² = 2 ∫ a² (1 − y²/b²) dy = 8 a² b / 3 and A = π a b, so that

    var x_c = 2 / (9 π² b) = 4 / (9 π² h),    var y_c = 4 / (9 π² w)      (B)

in px²; 0.075 px for a disc of 8 px. Noise of the grey levels moves the outline by a few hundredths of a pixel and adds
nothing that counts beside this. (B) is a mean over radii: for one radius in particular the variance is 0.35 to 1.75
times that, with two periods a pixel, as the outline's turning points meet the pixel grid.

A marker separated from another has, in place of its own outline, a cut that was drawn without knowing where it ought to
be. Its error grows with the marker: a share s of its width and height stands for it,

    var x_c += (s w)²,    var y_c += (s h)²,    s = 0.035                (C)

which is what simulated pairs of discs show (0.6 to 1.1 diameters apart; `tests/test_detect_kiss.py`).

Sources: Shafiq, Tümer and Güler 2001 (KISS), equation 2; (A) to (C) are ours.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...data.array_types import Floats
from .pixel_groups import KissGroups, rectangles, white_pixels
from .white import pixels_of

SHARE = 0.035  # of a part's length, the standard deviation of a separated centroid; studies/kiss_proposed.py judges it


def centroids(groups: KissGroups, *, height: int) -> tuple[Floats, Floats]:
    """Means (G, 2) of the white pixels in their frames of this height, px, and their covariances (G, 2, 2), px²."""
    brect, white = rectangles(groups), np.maximum(white_pixels(groups), 1)
    n = groups.last - groups.first + 1
    x = np.bincount(groups.of, n * (groups.first + groups.last) / 2, len(white)) / white  # (2)
    y = np.bincount(groups.of, n * (groups.y - groups.frame[groups.of] * height), len(white)) / white
    cov = np.zeros((len(white), 2, 2))
    for k, (along, across) in enumerate(((brect.width, brect.height), (brect.height, brect.width))):
        cov[:, k, k] = 4 / (9 * np.pi**2) / across + np.where(groups.separated, (SHARE * along) ** 2, 0.0)  # (B) (C)
    return np.stack([x, y], -1), cov


def peaks(images: NDArray[np.uint8 | np.uint16], groups: KissGroups, *, darkest: bool = False) -> Floats:
    """(G) the brightest grey level of each group in frames (n, H, W), or its darkest."""
    if len(groups.frame) == 0:
        return np.zeros(0)
    line, column = pixels_of(groups.y, groups.first, groups.last)
    grey = images.reshape(-1, images.shape[2])[line, column]
    first_pixel = np.concatenate([[0], np.cumsum(white_pixels(groups))[:-1]])
    return (np.minimum if darkest else np.maximum).reduceat(grey, first_pixel).astype(np.float64)
