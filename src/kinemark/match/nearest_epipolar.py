"""Matching between two cameras by the nearest distance to the epipolar line (Swamidas 1997, 3.1.3 to 3.1.5).

An image (u, v) of the first camera, the base, is the image of some point of the ray

    P(λ) = C + λ d(u, v),    0 < λ < ∞                                   (1)    (3.6)

and two points of it, brought into the second camera (3.7), are two points of the epipolar line there. The line does not
depend on which two, and is ℓ = F (u, v, 1)ᵀ with the fundamental matrix F of the two cameras (2). Every image of the
second camera lies at the distance

    d = |ℓ₁ u' + ℓ₂ v' + ℓ₃| / √(ℓ₁² + ℓ₂²)                              (3)

from it, and the nearest one is the match. The document's search is by "the nearest vertical distance" from the line,
along v alone,

    d_v = |ℓ₁ u' + ℓ₂ v' + ℓ₃| / |ℓ₂| = d √(1 + (ℓ₁ / ℓ₂)²)                (4)

For one line that is the same order. Where two images of the base ask for one image, the nearer has it and the other
looks on among those left: pairs are taken in the order of the distance, each image once. There (4) favours the flatter
line and (3) neither; yet all lines run through one point, the epipole, and where that is far from the image rivals are
all but parallel. So where one camera sees more than the other, what is left over there goes without, as the document's
flag for unequal numbers has it.

The document has no limit to it: a marker that only one camera sees is paired with whatever is nearest, if the other
camera has an image left. It has no third camera either, so two markers in one epipolar plane are told apart by chance.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..data import Detections, KinemarkError, Matches, Rig
from ..data.array_types import Floats, Ints
from ..data.method import ONE, Method, parameter
from ..geometry import epipolar_lines, fundamental
from ..geometry.ideal_pixels import check_cameras, ideal_pixels
from .distinguishing import Distinguishing, distinguished
from .epipolar_triplets import costs
from .stage import MATCH

UPRIGHT = 1e-9
"""|ℓ₂| of a line of unit normal, at least, as (4) would divide by nothing; chosen: far below any real slope."""


@dataclass(frozen=True, slots=True)
class NearestEpipolar(Method):
    """Of two cameras, the image nearest to the epipolar line of each image of the base camera."""

    cameras: tuple[str, ...] = parameter(
        (),
        meaning="names of the base camera and of the other one; empty where the rig has just two, the first is the "
        "base",
    )
    search_band: float | None = parameter(
        None, former="band", unit="px", above=0,
        meaning="images farther than this from the line are no match; None: no limit, as in the document",
    )  # fmt: skip
    distance: Literal["perpendicular", "vertical"] = parameter(
        "perpendicular",
        meaning="from the line: perpendicular to it; or vertical, along v, as the document says",
    )
    size_spread: float | None = parameter(
        None, unit=ONE, above=0,
        meaning="markers of different sizes: share by which the sizes of one marker by its two images differ; None: "
        "sizes are not compared, as in the document",
    )  # fmt: skip
    brightness_spread: float | None = parameter(
        None, unit=ONE, above=0,
        meaning="markers of different brightness: share by which the brightnesses of one marker's two images differ, "
        "each as a share of its camera's median; None: not compared",
    )  # fmt: skip
    banks: tuple[tuple[float, ...], ...] = parameter(
        (), unit="mm", above=0,
        meaning="banks of three markers, of each the three distances between them, or segments, of each its length; "
        "empty: none",
    )  # fmt: skip
    bank_tolerance: float = parameter(10.0, unit="mm", above=0, meaning="by which these distances may be off")
    line_sd: float = parameter(
        1.0, unit="px", above=0,
        meaning="standard deviation of a right match's distance from the line, against which sizes, brightness and "
        "banks are weighed",
    )  # fmt: skip

    def check_together(self) -> None:
        """Refuse any other number of cameras than two, and of distances in a bank than one or three."""
        if wrong := [bank for bank in self.banks if len(bank) not in (1, 3)]:
            raise ValueError(f"banks has {wrong[0]}, wanted the length of a segment or the three distances of a bank")
        if len(self.cameras) not in (0, 2) or len(set(self.cameras)) != len(self.cameras):
            raise ValueError(f"cameras are {list(self.cameras)}, wanted two different names, or none")


@MATCH.method("nearest_epipolar", NearestEpipolar, source="Swamidas 1997, 3.1.3 to 3.1.5")
def match_nearest(detections: Detections, rig: Rig, *, method: NearestEpipolar = NearestEpipolar()) -> Matches:
    """Pairs of detections of two cameras, frame by frame; all other cameras go unused.

    Raises:
        KinemarkError: detections and rig name other cameras; the two cameras are not named, or not there; a frame has
            far too many images.
    """
    check_cameras(detections, rig)
    r, s = two = _two_cameras(rig, method.cameras)
    uv = ideal_pixels(detections, rig, cameras=two)
    F = fundamental(rig.P[r], rig.P[s])
    found = [_frame_pairs(detections, uv, f, two, rig, F, method) for f in range(detections.n_frames)]
    frame = np.repeat(np.arange(detections.n_frames), [len(i) for i, _ in found])
    detection = np.full((len(frame), len(rig)), -1)
    detection[:, r] = np.concatenate([i for i, _ in found] or [np.zeros(0, np.int64)])
    detection[:, s] = np.concatenate([j for _, j in found] or [np.zeros(0, np.int64)])
    return Matches(frame, detection, costs(detection, uv, rig.P), detections.n_frames)


def _two_cameras(rig: Rig, names: tuple[str, ...]) -> tuple[int, int]:
    """Places of the base camera and of the other in the rig."""
    if not names and len(rig) != 2:
        raise KinemarkError(
            f"The method matches two cameras, and there are {len(rig)}: {list(rig.names)}. "
            "Name two of them in `cameras`, the base first."
        )
    if missing := [name for name in names if name not in rig.names]:
        raise KinemarkError(f"Cameras {missing} are not among {list(rig.names)}. Name two of these.")
    first, second = names or rig.names
    return rig.names.index(first), rig.names.index(second)


def _frame_pairs(
    detections: Detections,
    uv: Floats,
    f: int,
    cameras: tuple[int, int],
    rig: Rig,
    F: Floats,
    method: NearestEpipolar,
) -> tuple[Ints, Ints]:
    """Rows of the base and of the other camera that belong together in frame f."""
    i, j = (np.arange(*detections.start[c, f : f + 2]) for c in cameras)
    line = epipolar_lines(F, uv[i])  # (2)
    distance = np.abs(line[:, :2] @ uv[j].T + line[:, 2:])  # (3)
    if method.distance == "vertical":
        distance = distance / np.maximum(np.abs(line[:, 1:2]), UPRIGHT)  # (4)
    band = np.inf if method.search_band is None else method.search_band
    by = Distinguishing(
        method.line_sd, method.size_spread, method.brightness_spread, method.banks, method.bank_tolerance
    )
    cost = distinguished(distance, (uv[i], uv[j]), (i, j), detections, rig, cameras, by)
    a, b = nearest_pairs(np.where(distance <= band, cost, np.inf))
    return i[a], j[b]


def nearest_pairs(cost: Floats) -> tuple[Ints, Ints]:
    """Rows and columns of cost (n, m) taken in rising order, each once; infinite cost is never taken.

    The cheapest pair of all is cheapest for both its members. So all pairs of which that holds may be taken together,
    and again among the rest: it comes to the same as one by one.
    """
    cost = np.where(np.isnan(cost), np.inf, cost)
    rows, columns = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    while np.isfinite(cost).any():
        best = cost.argmin(1)
        n = np.arange(len(cost))
        agree = (cost.argmin(0)[best] == n) & np.isfinite(cost[n, best])
        rows.append(n[agree])
        columns.append(best[agree])
        cost[agree] = np.inf
        cost[:, best[agree]] = np.inf
    row, column = np.concatenate(rows), np.concatenate(columns)
    order = np.argsort(row)
    return row[order], column[order]
