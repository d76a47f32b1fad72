"""What the other cameras say of a marker that one does not show.

Where two or more other cameras were digitised, the epipolar lines of their images meet in this one where the marker
must be: the point that they give in space (`geometry.triangulate`), projected (1). If a marker that serves nobody yet
has a white pixel within the tolerance of that place, it is proposed; else the marker is hidden there, and "not present"
is (2).

One other camera gives a line. Markers that serve nobody and lie on it within the tolerance are looked for, where the
marker is expected somewhere within the reach of the search from there; exactly one is proposed (3). Where none lies on
the line in the whole image, the marker cannot be seen (4). Else nothing is proposed.

The other cameras' places are without the shift of their images, and this one's shift is added to what is drawn (5).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..data import Rig
from ..data.array_types import Bools, Floats
from ..data.arrays import column, set_columns
from ..geometry import epipolar_lines, fundamental, line_distance, project, triangulate, undistort
from .image_markers import ImageMarkers, nearest_free
from .semi_automatic import SemiAutomatic
from .state import PlaceProposal


@dataclass(frozen=True, slots=True, eq=False)
class OtherViews:
    """What was digitised in other cameras.

    Attributes:
        rig: C calibrated cameras.
        camera: index of the one that is being digitised.
        uv: (C, M, F, 2) px, without shifts; NaN where not digitised or not present.
    """

    rig: Rig
    camera: int
    uv: Floats

    def __post_init__(self) -> None:
        set_columns(self, uv=column("uv", self.uv, np.float64, len(self.rig), None, None, 2))
        if not 0 <= self.camera < len(self.rig):
            raise ValueError(f"camera is {self.camera}, wanted 0 to {len(self.rig) - 1}")


def propose(
    views: OtherViews,
    frame: int,
    marker: int,
    *,
    shift: Floats,
    expected: Floats,
    image_markers: ImageMarkers,
    free: Bools,
    method: SemiAutomatic,
) -> PlaceProposal | None:
    """The answer that other cameras give, if they do.

    Args:
        views: of the other cameras.
        frame: counted from 0.
        marker: index.
        shift: (2,) px of the image.
        expected: (2,) px where the marker is expected by its motion; NaN where that is not known.
        image_markers: the image.
        free: (B) which of its markers serve nobody yet.
        method: its tolerance and reach.
    """
    uv = views.uv[:, marker, frame].copy()
    uv[views.camera] = np.nan
    seen = np.flatnonzero(np.isfinite(uv).all(1))
    if len(seen) >= 2:
        return _where_lines_meet(views, uv, shift, image_markers, free, method)
    if len(seen) == 1:
        return _on_the_line(views, int(seen[0]), uv[seen[0]], shift, expected, image_markers, free, method)
    return None


def _where_lines_meet(
    views: OtherViews, uv: Floats, shift: Floats, image_markers: ImageMarkers, free: Bools, method: SemiAutomatic
) -> PlaceProposal | None:
    """(1) and (2)."""
    ideal = np.stack([undistort(camera, at[None]) for camera, at in zip(views.rig, uv, strict=True)], 1)
    xyz = triangulate(ideal, views.rig.P)
    place = project(views.rig[views.camera], xyz)[0] + shift  # (1), (5)
    if not np.isfinite(place).all():
        return None
    near = nearest_free(image_markers, place, free=free, side=2 * int(np.ceil(method.tolerance)) + 1)
    if near is None or near[0] > method.tolerance:
        return PlaceProposal(place, False)  # (2)
    return PlaceProposal(image_markers.uv[near[1]], True)


def _on_the_line(
    views: OtherViews,
    other: int,
    uv: Floats,
    shift: Floats,
    expected: Floats,
    image_markers: ImageMarkers,
    free: Bools,
    method: SemiAutomatic,
) -> PlaceProposal | None:
    """(3) and (4)."""
    here, there = views.rig[views.camera], views.rig[other]
    line = epipolar_lines(fundamental(there.P, here.P), undistort(there, uv[None]))
    ideal = undistort(here, image_markers.uv[free] - shift)  # (5)
    on = np.flatnonzero(free)[np.abs(line_distance(line, ideal)) <= method.tolerance]
    if not len(on):
        return PlaceProposal(np.full(2, np.nan), False)  # (4)
    if np.isfinite(expected).all():
        reach = method.grid * method.expansions / 2
        on = on[np.abs(image_markers.uv[on] - expected).max(1) <= reach]
    return PlaceProposal(image_markers.uv[on[0]], True) if len(on) == 1 else None
