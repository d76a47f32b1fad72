"""Options that commands of the upper limb system share: how images are looked at, and what is known besides."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
from cyclopts import Parameter

from ..data import KinemarkError
from ..data.array_types import Floats
from ..data.errors import users_mistake

if TYPE_CHECKING:  # these take long to import, and --help does without
    from ..detect import Centroids
    from ..digitise import ImageMarkers, OtherViews

Switch = Parameter(negative="")
Many = Parameter(consume_multiple=True, negative="")


@dataclass(frozen=True)
class ImageOptions:
    """How markers are found in images.

    Attributes:
        threshold: Grey level above which a pixel is white, 0 to 255.
        inverted: Threshold type inverted: black markers on a white background.
        white_pixels: Centroids are the means of the white pixels, as those of UM²AS; no disc is fitted.
    """

    threshold: float = 60.0
    inverted: Annotated[bool, Switch] = False
    white_pixels: Annotated[bool, Switch] = False

    def centroids(self) -> Centroids:
        """The method that does so."""
        from ..detect import Centroids

        with users_mistake():
            method = Centroids(threshold=self.threshold, inverted=self.inverted)
        if not self.white_pixels:
            return method
        return replace(method, centroid="white", max_discs=1, correct_occlusion=False)

    def markers(self, images: Path, frame: int) -> ImageMarkers:
        """Those of a frame, counted from 1.

        Raises:
            KinemarkError: there is no such frame, or an option cannot be.
        """
        from ..digitise import find_markers
        from ..engine.sources import frame_of
        from ..io.images import open_images

        source = open_images(images)
        if not 1 <= frame <= source.n_frames:
            raise KinemarkError(f"{images} has no frame {frame}, but 1 to {source.n_frames}. Name another.")
        return find_markers(frame_of(source, frame - 1), method=self.centroids())


@dataclass(frozen=True)
class CameraOptions(ImageOptions):
    """The same of a camera whose pixels may not be square.

    Attributes:
        threshold: Grey level above which a pixel is white, 0 to 255.
        inverted: Threshold type inverted: black markers on a white background.
        white_pixels: Centroids are the means of the white pixels, as those of UM²AS; no disc is fitted.
        aspect_ratio: What V is multiplied by to make pixels square; see kinemark aspect.
    """

    aspect_ratio: float = 1.0

    def square(self) -> Floats:
        """(2,) what U and V of the images are multiplied by in the files.

        Raises:
            KinemarkError: the ratio cannot be.
        """
        if not 0.1 < self.aspect_ratio < 10:
            raise KinemarkError(f"{self.aspect_ratio:g} is no aspect ratio of pixels. Measure it: kinemark aspect")
        return np.array([1.0, self.aspect_ratio])


@dataclass(frozen=True)
class ReferenceOptions:
    """The marker that never moves.

    Attributes:
        reference: which of them is the reference marker; none without it.
        reference_file: where it was when the camera was calibrated, as box.rf1; the first frame says it without this.
        confirm_reference: ask in every frame whether the reference marker is the right one.
    """

    reference: str | None = None
    reference_file: Path | None = None
    confirm_reference: Annotated[bool, Switch] = False

    def place(self) -> Floats | None:
        """(2,) where it was in the calibration, as the file has it; None where nobody says it."""
        from ..io.um2as import read_rf

        return read_rf(self.reference_file) if self.reference_file and self.reference else None


@dataclass(frozen=True)
class OtherCameras:
    """What other cameras know.

    Attributes:
        calibration: the parameters of all cameras, so that others can propose what is missing here.
        others: what is digitised of other cameras, as feeding.da2 feeding.da3.
        take_proposals: take what they propose, and do not ask.
    """

    calibration: Annotated[list[Path] | None, Many] = None
    others: Annotated[list[Path] | None, Many] = None
    take_proposals: Annotated[bool, Switch] = False

    def views(self, camera: int, markers: int, square: Floats) -> OtherViews | None:
        """Of so many markers, in the pixels of the images of a camera; None where no files are given.

        Raises:
            KinemarkError: a camera has no calibration, or a file cannot be read.
        """
        from ..digitise import OtherViews
        from ..engine.calibration.from_known_points import rig_of_cp
        from ..io.um2as import read_da_set

        if not self.others:
            return None
        rig = rig_of_cp(self.calibration) if self.calibration else None
        uv, numbers = read_da_set(self.others, markers=markers)
        wanted = [f"cam{n}" for n in sorted({camera, *numbers})]
        if rig is None or not set(wanted) <= set(rig.names):
            raise KinemarkError(f"To ask other cameras, --calibration must name the .cp files of {', '.join(wanted)}.")
        own = rig.select(wanted)
        rig = replace(own, cameras=tuple(replace(one, K=np.diag([*(1 / square), 1.0]) @ one.K) for one in own))
        uv = uv / square
        whole = np.full((len(rig), *uv.shape[1:]), np.nan)
        for own, n in zip(uv, numbers, strict=True):
            whole[wanted.index(f"cam{n}")] = own
        return OtherViews(rig, wanted.index(f"cam{camera}"), whole)
