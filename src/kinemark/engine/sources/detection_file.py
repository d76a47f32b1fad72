"""Detections that were made before, by Kinemark or by another system; a file may name the marker of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from ...data import Detections, KinemarkError, Trajectories, Trial
from ...detect.masks import masked_centroids
from ...io.detections_csv import NamedDetections, read_detections_csv
from ...io.named_points_csv import layout_of, read_camera_files, read_named_detections
from ...io.records import load
from ...io.tdf import read_tdf
from ..keys import digest, file_key
from ..recordings import masks_key, masks_of, of_cameras
from .excerpt import cut, within
from .operated import marker_within
from .recording import Recording
from .trial_source import OperatorIdentities, PlainSource


@dataclass(frozen=True, slots=True)
class DetectionFile(PlainSource):
    """Detections that were made before, by Kinemark or by another system: TDF, CSV or HDF5."""

    of: Recording
    others: ClassVar[tuple[Path, ...]] = ()

    @property
    def path(self) -> Path:
        """The file."""
        return self.of.root / str(self.of.entry.detections)

    def key(self) -> str:
        """Of the file, the cameras' order, the rate, fixed marks, the cameras' times, and masks."""
        of = self.of
        if not self.path.is_file():
            raise KinemarkError(f"{self.path} is not a file. Check detections of trial {of.entry.name!r}.")
        rate = of.rate(None) if self.path.suffix.lower() == ".csv" else of.settings.rate_hz
        masks = masks_key(of.root, of.settings, of.rig.names)
        return digest(file_key(self.path), of.rig.names, rate, of.corrections(), masks, of.frames)

    def detections(self, threads: int | None = None) -> Detections:
        """Those of the calibrated cameras, without what the session's `[masks]` cover.

        Raises:
            KinemarkError: the file holds none, contradicts the rate, or lacks a camera.
        """
        found = self._read()
        rate = self.of.rate(found.rate)
        if abs(rate - found.rate) > 0.01 * rate:
            raise KinemarkError(
                f"{self.path} says {found.rate:g} Hz and session.toml rate_hz = {rate:g}. Correct or remove rate_hz."
            )
        if not len(found):
            raise KinemarkError(f"{self.path} has no 2D points. Check that it was written to the end.")
        of, found = self.of, self._of_all(found)
        masks = masks_of(of.root, of.settings, of.rig.names)
        return of.corrected(within(masked_centroids(found, masks) if masks else found, of)).detections

    def _of_all(self, found: Detections) -> Detections:
        """Those of the calibrated cameras, in their order; a table names no camera that saw nothing.

        Raises:
            KinemarkError: the file lacks a camera.
        """
        names = self.of.rig.names
        if (whole := of_cameras(found, names, self.path)) is not None:
            return whole
        missing = sorted(set(names) - set(found.cameras))
        raise KinemarkError(
            f"{self.path} has cameras {', '.join(found.cameras)}, and the calibration also {', '.join(missing)}. "
            "Give them the same names in both, and name in [cameras] those to be used."
        )

    def _read(self) -> Detections:
        """All that the file holds."""
        path, suffix = self.path, self.path.suffix.lower()
        if suffix == ".csv":
            return read_detections_csv(path, rate=self.of.rate(None))
        found = read_tdf(path, parts=("detections",)).detections if suffix == ".tdf" else load(path)
        if found is None:
            raise KinemarkError(f"{path} has no 2D points. Export the trial with its 2D data.")
        if not isinstance(found, Detections):
            raise KinemarkError(f"{path} holds {type(found).__name__}, wanted Detections. Name another file.")
        return found

    def beside(self) -> Trial | None:
        """What a TDF holds besides its 2D points, within the stretch."""
        if self.path.suffix.lower() != ".tdf":
            return None
        tdf = read_tdf(self.path)
        if tdf.detections is None:
            return None
        rate = tdf.detections.rate
        whole = Trial(
            self.of.entry.name,
            Trajectories((), rate),
            tdf.analog,
            tdf.plates,
            tdf.events,
            about=tdf.about,
            notes=tdf.notes,
        )
        return whole if self.of.frames is None else cut(whole, self.of.frames, rate)


HOLE = "{camera}"


def names_markers(of: Recording) -> bool:
    """Whether a trial's file of 2D points is a CSV that says which marker each one is."""
    text = str(of.entry.detections)
    if not text.lower().endswith(".csv"):
        return False
    first = of.root / text.replace(HOLE, of.rig.names[0])
    return HOLE in text or (first.is_file() and layout_of(first) is not None)


@dataclass(frozen=True, slots=True)
class NamedDetectionFile(PlainSource):
    """A CSV file of 2D points with names, or one a camera."""

    of: Recording

    @property
    def paths(self) -> dict[str, Path]:
        """The file of each camera; the same for all where there is one."""
        text = str(self.of.entry.detections)
        return {name: self.of.root / text.replace(HOLE, name) for name in self.of.rig.names}

    def key(self) -> str:
        """Of the files, the cameras' order, the rate, fixed marks and the cameras' times."""
        of, files = self.of, tuple(dict.fromkeys(self.paths.values()))
        if missing := [path for path in files if not path.is_file()]:
            raise KinemarkError(f"{missing[0]} is not a file. Check detections of trial {of.entry.name!r}.")
        return digest(file_key(*files), of.rig.names, of.rate(None), of.corrections(), of.frames)

    def detections(self, threads: int | None = None) -> Detections:
        """Those of the calibrated cameras.

        Raises:
            KinemarkError: a file cannot be read, holds none, or lacks a camera.
        """
        found = self._read().detections
        if not len(found):
            raise KinemarkError(f"{self.of.root / str(self.of.entry.detections)} has no 2D points. Export it again.")
        return self.of.corrected(within(found, self.of)).detections

    def _read(self) -> NamedDetections:
        """All that is there of the calibrated cameras, in their order."""
        of, paths = self.of, self.paths
        rate = of.rate(None)
        if HOLE in str(of.entry.detections):
            return read_camera_files(paths, rate=rate)
        path = next(iter(paths.values()))
        if layout_of(path) == "deeplabcut":
            raise KinemarkError(
                f"{path} is of one camera, and the calibration has {', '.join(of.rig.names)}. Name the files of all, "
                'with {camera} where a camera\'s name stands: detections = "walk01_{camera}.csv".'
            )
        return selected(path, read_named_detections(path, rate=rate, cameras=of.rig.names), of.rig.names)

    def operated(self) -> OperatorIdentities:
        """The markers as the file names them."""
        found = self._read()
        return OperatorIdentities(found.names, marker_within(found, self.of), {})


def selected(path: Path, found: NamedDetections, names: Sequence[str]) -> NamedDetections:
    """Only these cameras, in this order.

    Raises:
        KinemarkError: the file lacks one.
    """
    have = found.detections.cameras
    if missing := sorted(set(names) - set(have)):
        raise KinemarkError(
            f"{path} has cameras {', '.join(have)}, and the calibration also {', '.join(missing)}. "
            "Call them alike in both, and name in [cameras] those to be used."
        )
    camera = found.detections.camera
    rows = np.concatenate([np.flatnonzero(camera == have.index(name)) for name in names])
    return NamedDetections(found.detections.select(names), found.marker[rows], found.names)
