"""Images in which an operator points at markers, and UM²AS's files of digitised centroids."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...data import Detections, Finding, KinemarkError
from ...data.array_types import Floats, GreyLevels, Ints
from ...data.progress import tell
from ...data.typed import typed
from ...detect import Centroids
from ...digitise import identified
from ...io.um2as import files_of_set
from ..digitising.files import Digitising, answer_files, digitise_trial, read_digitised, read_figures, write_digitised
from ..keys import digest, file_key, rig_key
from ..recordings import masks_key, masks_of
from .excerpt import pictures_of, within
from .images import other_rates
from .recording import Recording, places_of
from .trial_source import OperatorIdentities, PlainSource


@dataclass(frozen=True, slots=True)
class DigitisedFiles(PlainSource):
    """A set of UM²AS's files of digitised centroids, one a camera, of which the entry names one."""

    of: Recording

    @property
    def path(self) -> Path:
        """The file that is named."""
        return self.of.root / str(self.of.entry.detections)

    def key(self) -> str:
        """Of all files of the set, the cameras' order, the rate, fixed marks and the cameras' times."""
        of, files = self.of, (self.path, *files_of_set(self.path, "da"))
        return digest(file_key(*files), of.rig.names, of.settings.rate_hz, of.corrections(), of.frames)

    def detections(self, threads: int | None = None) -> Detections:
        """Of all markers that the files have.

        Raises:
            KinemarkError: they have none.
        """
        of = self.of
        found = read_digitised(self.path, cameras=of.rig.names, rate=of.rate(None)).seen.detections
        if not len(found):
            raise KinemarkError(f"{self.path} has no 2D points. Check that it was written to the end.")
        return of.corrected(within(found, of)).detections

    def operated(self) -> OperatorIdentities:
        """The markers by the columns of the files, with the names of `[digitise]`, else their numbers."""
        of = self.of
        given = read_digitised(self.path, cameras=of.rig.names, rate=of.rate(None))
        return OperatorIdentities(self._names(given.n_markers), marker_within(given.seen, of), {})

    def _names(self, n: int) -> tuple[str, ...]:
        """The names of n digitised markers."""
        method = self.of.settings.digitise
        if method is None:
            return tuple(str(m + 1) for m in range(n))
        if len(method.markers) != n:
            raise KinemarkError(
                f"{self.path} has {n} markers, and [digitise] names {len(method.markers)}. Name them all."
            )
        return tuple(method.markers)


@dataclass(frozen=True, slots=True)
class OperatedImages(PlainSource):
    """Images in which an operator points at markers; the answers are read, and what they do not say is an error."""

    of: Recording

    def task(self) -> Digitising:
        """What an operator needs to digitise the trial.

        Raises:
            KinemarkError: images or answers cannot be used.
        """
        of = self.of
        method, marks = of.settings.digitise, of.settings.calibration.reference_marker
        assert method is not None and isinstance(of.settings.detect, Centroids)  # the settings see to it
        constants: Floats | None = None
        if marks is not None and method.reference is not None:
            constants = places_of(marks, of.rig.names)[:, 0]
        files = answer_files(of.root, str(of.entry.answers), of.rig.names)
        masks = masks_of(of.root, of.settings, of.rig.names)
        last = of.entry.frames[1] if of.entry.frames else None
        return Digitising(of.images(), files, of.rig, method, of.settings.detect, constants, masks, last)

    def key(self) -> str:
        """Of images and answers, the cameras, the rate, how markers are digitised, and masks."""
        of, task = self.of, self.task()
        files = [path for source in task.images.values() for path in source.paths]
        masks = masks_key(of.root, of.settings, of.rig.names)
        said = file_key(*files, *task.answers.values())
        taken = task.last, of.entry.every
        return digest(said, of.rig.names, self._rate(task), task.method, task.constants, rig_key(of.rig), masks, taken)

    def detections(self, threads: int | None = None) -> Detections:
        """What the operator's answers give; `.da` files and figures are written beside.

        Raises:
            KinemarkError: a question has no answer yet.
        """
        of, task = self.of, self.task()
        if of.frames != of.entry.frames:
            raise KinemarkError(
                f"Trial {of.entry.name!r} is digitised as a whole, and no stretch of it can be looked at before."
            )
        if of.own_times:
            raise KinemarkError(
                f"Trial {of.entry.name!r} is digitised, for which all cameras count as synchronous: leave out "
                "delays_ms and rates_hz."
            )
        try:
            uv, figures = digitise_trial(task, announce=lambda camera: tell(0, 1))
        except KinemarkError as error:
            command = f"kinemark digitise {typed(of.root)} {typed(of.entry.name)}"
            raise KinemarkError(f"{error} Answer it: {command}") from error
        write_digitised(of.results, uv, figures)
        return identified(uv, cameras=of.rig.names, rate=self._rate(task)).detections

    def contradictions(self) -> tuple[Finding, ...]:
        """Where the videos' own frame rates contradict the one that is used."""
        task = self.task()
        return other_rates(task.images, self._rate(task))

    def pictures(self, frames: Sequence[int]) -> list[GreyLevels]:
        """The frames."""
        return pictures_of(self.of, frames)

    def operated(self) -> OperatorIdentities:
        """The markers that the operator was asked for."""
        of, task = self.of, self.task()
        file = of.results / f"{of.entry.name}.da1"
        marker = read_digitised(file, cameras=of.rig.names, rate=self._rate(task)).seen.marker
        return OperatorIdentities(tuple(task.method.markers), marker, read_figures(of.results))

    def _rate(self, task: Digitising) -> float:
        return self.of.rate(next(iter(task.images.values())).rate)


def marker_within(seen: Any, of: Recording) -> Ints:
    """The markers of the detections in the stretch that is asked for, at the times of its frames."""
    marker, part = seen.marker, within(seen.detections, of)
    if of.frames is not None:
        first, stop = of.stretch(seen.detections.n_frames)
        frame = seen.detections.frame
        marker = marker[(frame >= first) & (frame < stop)]
    return np.asarray(marker[of.at_common_time(part).row])
