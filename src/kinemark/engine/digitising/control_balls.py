"""Control points in the images of a session's cameras, pointed at by an operator, ball by ball and camera by camera.

What is said is kept in the CSV file of control points that the session names, which `kinemark calibrate` reads; and the
fixed mark of the laboratory, the reference marker, in `session.toml`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...data import KinemarkError
from ...data.errors import users_mistake
from ...detect import Centroids
from ...digitise import ImageMarkers, find_markers
from ...geometry.camera import in_image
from ...io.control_points import SNAP, PointedPoints, read_pointed, write_pointed
from ...io.images import ImageSource
from ...io.um2as import read_rf
from ..recordings import methods_of, open_cameras
from ..session_changes import change_session
from ..settings import DigitisedPoints, Settings
from ..sources import frame_of

REFERENCE = "reference marker"
"""What is asked for after the last ball."""
DECIMALS = 7
"""Of its place, px: as many as a `.rf` file of UM²AS has, so that both give the same shift to the last bit; by
definition."""


@dataclass(frozen=True, slots=True)
class ControlBalls:
    """The control points of a session in its images.

    Attributes:
        root: folder of the session. settings: of it. way: its table of control points.
    """

    root: Path
    settings: Settings
    way: DigitisedPoints

    @classmethod
    def of(cls, root: Path, settings: Settings) -> ControlBalls:
        """Those that calibrate a session, or that give the world of its wand.

        Raises:
            KinemarkError: it has none, or none with images.
        """
        way = settings.calibration.control_points or settings.calibration.world_points
        if way is None or way.images is None:
            raise KinemarkError(
                "This session is calibrated another way: control_points with points and images is wanted in "
                "[calibration]."
            )
        return cls(root, settings, way)

    @property
    def file(self) -> Path:
        """Where answers are kept."""
        return self.root / self.way.points

    @property
    def points(self) -> PointedPoints:
        """What was said until now; raises KinemarkError where the file cannot be used."""
        return read_pointed(self.file, self.settings.cameras.names)

    def method(self, camera: str, threshold: float | None = None, inverted: bool | None = None) -> Centroids:
        """How markers are found in a camera's image; what is None stands in the session.

        Raises:
            KinemarkError: the threshold is no grey level.
        """
        names = self.settings.cameras.names
        own = methods_of(self.settings, names).get(camera, self.settings.detect)
        method = own if isinstance(own, Centroids) else Centroids()
        with users_mistake():
            method = method if threshold is None else replace(method, threshold=threshold)
            return method if inverted is None else replace(method, inverted=inverted)

    def source(self, camera: str) -> ImageSource:
        """The images of a camera; raises KinemarkError where it or they are not there."""
        if camera not in self.settings.cameras.names:
            raise KinemarkError(f"There is no camera {camera!r}. Look at the list again.")
        assert self.way.images is not None
        return open_cameras(self.root, self.settings, self.way.images, self.settings.cameras.names)[camera]

    def image(self, camera: str) -> NDArray[np.uint8 | np.uint16]:
        """The image (H, W) of the control points."""
        return frame_of(self.source(camera), 0)

    def markers(self, camera: str, threshold: float | None = None, inverted: bool | None = None) -> ImageMarkers:
        """What can be pointed at in it."""
        return find_markers(self.image(camera), method=self.method(camera, threshold, inverted))

    def say(self, camera: str, name: str, uv: tuple[float, float] | None, *, asked: bool = True) -> None:
        """A ball's place in an image, px, None for not seen; or the reference marker's. `asked` False takes it back.

        Raises:
            KinemarkError: there is no such ball or camera, or a file cannot be written.
        """
        if name == REFERENCE:
            marks = {**(self.settings.calibration.reference_marker or {})}
            marks.pop(camera, None)
            if uv is not None and asked:
                marks[camera] = ((round(uv[0], DECIMALS), round(uv[1], DECIMALS)),)
            plain = {key: [list(place) for place in places] for key, places in marks.items()}
            change_session(self.root, {("calibration", "reference_marker"): plain or None})
            return
        write_pointed(self.file, self.points.said(camera, name, uv, asked=asked))

    def reference_of_file(self, name: str) -> tuple[float, float]:
        """The reference marker of one of the session's `.rf` files, px; raises KinemarkError where there is no such."""
        files = {path.name: path for path in self.reference_files()}
        if name not in files:
            raise KinemarkError(f"There is no file {name!r} of a reference marker in the session's folder.")
        u, v = read_rf(files[name]).tolist()
        return u, v

    def reference_files(self) -> list[Path]:
        """UM²AS's files of reference markers in the session's folder."""
        return sorted(path for path in self.root.glob("*.rf*") if path.suffix[3:].isdecimal())


def snapped(markers: ImageMarkers, u: float, v: float) -> tuple[float, float]:
    """The centroid of the marker that is pointed at, px: the one whose white pixel it is, else the nearest within snap.

    Raises:
        KinemarkError: there is none.
    """
    inside = in_image(markers.size, u, v)
    owner = int(markers.owner[round(v), round(u)]) if inside else -1
    if owner < 0 and len(markers.uv):
        distance = np.hypot(markers.uv[:, 0] - u, markers.uv[:, 1] - v)
        owner = int(distance.argmin()) if inside and distance.min() <= SNAP else -1
    if owner < 0:
        raise KinemarkError(
            f"No white pixel of a marker is within {SNAP:g} px of ({u:.0f}, {v:.0f}). Point at one, change the "
            "threshold, or say that the camera does not see it."
        )
    found_u, found_v = markers.uv[owner].tolist()
    return found_u, found_v
