"""Detections that were made before, by Kinemark or by another system."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from ...data import Detections, KinemarkError, Trajectories, Trial
from ...detect.masks import masked_centroids
from ...io.detections_csv import read_detections_csv
from ...io.records import load
from ...io.tdf import read_tdf
from ..keys import digest, file_key
from ..recordings import masks_key, masks_of, of_cameras
from .excerpt import cut, within
from .recording import Recording
from .trial_source import PlainSource


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
