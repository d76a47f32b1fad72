"""Digitising recordings: one camera into a `.da` file, or all cameras of a session's trial.

In a session the operator's answers are input, `answers = "feeding/{camera}.csv"` in its trial, and everything else is
computed from them again when it is needed. Cameras are digitised in the session's order; each sees what those before it
say of a missing marker.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...data import KinemarkError, Rig
from ...data.array_types import Bools, Floats
from ...detect import Centroids, Masks
from ...digitise import (
    Answer,
    DigitisedImages,
    DigitisingState,
    Identified,
    ImageMarkers,
    Operator,
    OtherViews,
    PlaceProposal,
    Question,
    Replay,
    SemiAutomatic,
    drive,
    find_markers,
    given,
    identified,
    propose,
    result,
)
from ...io.answers_csv import append_answer, read_answers
from ...io.files import write_json
from ...io.images import ImageSource
from ...io.um2as import files_of_set, read_da_set, write_da

FIGURES = "digitising.json"
KEPT = 32  # images kept ready: as far as an operator goes back without waiting; chosen


class DigitisedFrames:
    """The frames of a camera, ready to be pointed at, decoded when they are asked for.

    Args:
        source: the camera's images.
        method: of detection.
        last: no frame after this one, counted from 1; None for all.
        mask: (H, W) where the search takes nothing.
    """

    def __init__(
        self,
        source: ImageSource,
        *,
        method: Centroids | None = None,
        last: int | None = None,
        mask: Bools | None = None,
    ) -> None:
        if last is not None and last < 1:
            raise KinemarkError(f"There is no frame up to frame {last}. Say 1 or more.")
        method = method or Centroids()
        fields = 0.5 if source.interlaced else 1.0
        self._method = replace(method, aspect=method.aspect or fields)
        self._source, self._mask = source, mask
        self.n_frames = min(source.n_frames, last or source.n_frames)
        self._ready: dict[int, ImageMarkers] = {}
        self._images, self._next = source.frames(), 0

    def __call__(self, f: int) -> ImageMarkers:
        """The f-th frame, counted from 0."""
        if f not in self._ready:
            if f < self._next:
                self._images, self._next = self._source.frames(), 0
            image = next(islice(self._images, f - self._next, None), None)
            self._next = f + 1
            if image is None:
                raise KinemarkError(f"{self._source.paths[0]} ends before frame {f + 1}. Copy the recording again.")
            offset = self._source.v_offset(f)
            self._ready[f] = find_markers(image, method=self._method, mask=self._mask, v_offset=offset)
            if len(self._ready) > KEPT:
                del self._ready[next(iter(self._ready))]
        return self._ready[f]


def digitise_camera(
    reel: DigitisedFrames,
    *,
    method: SemiAutomatic,
    answers: Path | None = None,
    operator: Operator | None = None,
    refuse: Callable[[Exception], None] | None = None,
    save_all: bool = False,
    constant: Floats | None = None,
    views: OtherViews | None = None,
) -> DigitisedImages:
    """One camera, with the answers of a file first and an operator's after; these are added to the file.

    Args:
        reel: the camera's frames.
        method: the markers and how they are followed.
        answers: the file; it need not exist.
        operator: who is asked what the file does not say; without one that is an error.
        refuse: called with why an answer cannot be used before the question is put again.
        save_all: accept frames of which all is settled without a word.
        constant: (2,) px the reference marker at the calibration.
        views: what was digitised in other cameras.

    Raises:
        KinemarkError: no frame was saved, or answers are missing or wrong, and nobody is there to ask.
    """
    replay, on_answer = _answering(answers, operator, save_all)
    try:
        state = drive(
            replay,
            reel,
            n_frames=reel.n_frames,
            method=method,
            constant=constant,
            proposer=proposer_of(views, method),
            refuse=refuse,
            on_answer=on_answer,
            reopened=replay.goes_on,
        )
    except KinemarkError as error:
        raise KinemarkError(f"{answers or 'Digitising'}: {error}") from error
    if replay.unused and operator is None:
        raise KinemarkError(
            f"{answers} has {replay.unused} answers to questions that were not put. Were the images, the threshold or "
            "the markers others when they were given? Remove the file, and digitise again."
        )
    return result(state, method=method)


def _answering(
    answers: Path | None, operator: Operator | None, save_all: bool
) -> tuple[Replay, Callable[[Question, Answer], None]]:
    """Who answers, and what keeps those answers in the file that are not there yet and could be used."""
    fresh: list[Question] = []

    def ask(question: Question, state: DigitisingState) -> Answer:
        assert operator is not None  # else nobody asks
        fresh[:] = [question]
        return operator(question, state)

    def on_answer(question: Question, answer: Answer) -> None:
        if answers and fresh:
            append_answer(answers, given(question, answer))
        fresh.clear()

    before = read_answers(answers) if answers else []
    return Replay(before, otherwise=ask if operator else None, save_all=save_all), on_answer


def proposer_of(views: OtherViews | None, method: SemiAutomatic) -> Any:
    """What asks the other cameras, if there are any."""
    if views is None:
        return None

    def proposer(
        frame: int, marker: int, shift: Floats, expected: Floats, image_markers: ImageMarkers, free: Bools
    ) -> PlaceProposal | None:
        if frame >= views.uv.shape[2]:
            return None
        return propose(
            views, frame, marker, shift=shift, expected=expected, image_markers=image_markers, free=free, method=method
        )

    return proposer


class Digitising(NamedTuple):
    """A trial to digitise: images and answers of its cameras, how, where the reference marker was (C, 2) px, masks.

    `last` is the last frame, counted from 1; all where None.
    """

    images: Mapping[str, ImageSource]
    answers: Mapping[str, Path]
    rig: Rig
    method: SemiAutomatic
    detect: Centroids
    constants: Floats | None = None
    masks: Masks | None = None
    last: int | None = None

    def mask(self, camera: str) -> Bools | None:
        """(H, W) of a camera, where it has one."""
        return self.masks.pixels(camera) if self.masks and camera in self.masks.cameras else None


def digitise_trial(
    task: Digitising,
    *,
    operator: Callable[[DigitisedFrames], Operator] | None = None,
    refuse: Callable[[Exception], None] | None = None,
    announce: Callable[[str], None] | None = None,
    stop_after: str | None = None,
) -> tuple[Floats, dict[str, Any]]:
    """(C, M, F, 2) px of all cameras, without shifts, and the figures for `quality.json`.

    Args:
        task: the trial.
        operator: who, given a camera's frames, is asked what the answers do not say; without one that is an error.
        refuse: called with why an answer cannot be used.
        announce: called with the camera whose turn it is.
        stop_after: the camera after which the others may wait; they are NaN then.

    Raises:
        KinemarkError: answers are missing, or cameras have different numbers of frames.
    """
    reels = reels_of(task)
    n = next(iter(reels.values())).n_frames
    uv = np.full((len(task.rig), len(task.method.markers), n, 2), np.nan)
    figures: dict[str, Any] = {}
    for c, (name, reel) in enumerate(reels.items()):
        if announce is not None:
            announce(name)
        done = digitise_camera(
            reel,
            method=task.method,
            answers=task.answers[name],
            operator=operator(reel) if operator else None,
            refuse=refuse,
            constant=None if task.constants is None else task.constants[c],
            views=OtherViews(task.rig, c, uv) if c else None,
        )
        if done.uv.shape[1] < n:
            raise KinemarkError(
                f"Of camera {name} {done.uv.shape[1]} of {n} frames are saved. Digitise the others too."
            )
        uv[c], figures[name] = done.uv, done.figures
        if name == stop_after:
            break
    return uv, {"questions": sum(f["questions"] for f in figures.values()), "cameras": figures}


def reels_of(task: Digitising) -> dict[str, DigitisedFrames]:
    """The frames of all cameras, as many of each."""
    reels = {
        name: DigitisedFrames(source, method=task.detect, last=task.last, mask=task.mask(name))
        for name, source in task.images.items()
    }
    if len({reel.n_frames for reel in reels.values()}) != 1:
        found = ", ".join(f"{name} {reel.n_frames}" for name, reel in reels.items())
        raise KinemarkError(f"The cameras have different numbers of frames: {found}. Cut them to those that all share.")
    return reels


# ---- What a session keeps of it ----


def write_digitised(folder: Path, uv: Floats, figures: Mapping[str, Any]) -> None:
    """`{trial}.da1` … and `digitising.json` in the trial's folder of results."""
    for c, own in enumerate(uv):
        write_da(folder / f"{folder.name}.da{c + 1}", own)
    write_json(folder / FIGURES, figures)


def read_figures(folder: Path) -> dict[str, Any]:
    """The figures that `write_digitised` left.

    Raises:
        KinemarkError: they are not there.
    """
    try:
        return dict(json.loads((folder / FIGURES).read_text("utf-8")))
    except (OSError, ValueError) as error:
        raise KinemarkError(f"{folder / FIGURES} is damaged: {error}. Delete {folder}, and run again.") from error


class DigitisedSet(NamedTuple):
    """Detections with their markers, and how many markers there are."""

    seen: Identified
    n_markers: int


def read_digitised(file: Path, *, cameras: Sequence[str], rate: float) -> DigitisedSet:
    """The `.da` files of a set, of which one is named, as detections of these cameras, in the order of the numbers.

    Raises:
        KinemarkError: there are not as many files as cameras, or a file is wrong.
    """
    uv, numbers = read_da_set(files_of_set(file, "da"))
    if len(numbers) != len(cameras):
        raise KinemarkError(
            f"{file} belongs to a set of {len(numbers)} cameras, and the calibration has {', '.join(cameras)}. "
            "Name in [cameras] those that were digitised."
        )
    return DigitisedSet(identified(uv, cameras=cameras, rate=rate), uv.shape[1])


def answer_files(root: Path, pattern: str, cameras: Sequence[str]) -> dict[str, Path]:
    """Each camera's file of answers.

    Raises:
        KinemarkError: the pattern means one file for all.
    """
    if "{camera}" not in pattern and len(cameras) > 1:
        raise KinemarkError(f"answers = {pattern!r} has no {{camera}} in it: all cameras would be one. Put it in.")
    return {name: root / pattern.replace("{camera}", name) for name in cameras}
