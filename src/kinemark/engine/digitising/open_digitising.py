"""Digitising a trial answer by answer, for a face that comes and goes.

What the answers' files hold is where the operator is: opening goes through them again, and every answer is appended
before it counts (1). Cameras are digitised in the session's order, so that the files that `kinemark run` then writes
are those of the same answers given at a terminal. A camera whose frames are all saved can still be gone on with as
long as nothing was said of the next, which is digitised by it (2).
"""

from __future__ import annotations

import threading

import numpy as np

from ...data import KinemarkError
from ...data.answers import Undo
from ...data.array_types import Bools, Floats
from ...digitise import (
    Answer,
    DigitisingPhase,
    DigitisingState,
    DigitisingStopped,
    OtherViews,
    Question,
    Replay,
    advance,
    drive,
    given,
    question_of,
    result,
)
from ...geometry import project, undistort
from ...io.answers_csv import append_answer, read_answers
from .files import Digitising, proposer_of, reels_of

LINE_POINTS = 48
"""Of an epipolar line; chosen: lenses bend it smoothly."""
NEAR_MM, FAR_MM = 300.0, 15000.0
"""Depths that an epipolar line goes over; chosen: a room."""


class OpenDigitising:
    """A trial that is being digitised; for one thread at a time, which `lock` is for.

    Attributes:
        task: what is digitised.
        cameras: those that were begun, each with its state; the last one asks.
        uv: (C, M, F, 2) px without shifts, of the cameras that are finished; NaN of the others.
        kept: answers of each camera that are in its file.
    """

    def __init__(self, task: Digitising) -> None:
        """Go through all answers that were given.

        Raises:
            KinemarkError: images cannot be used, or answers do not fit them.
        """
        self.task, self.lock = task, threading.RLock()
        self._reels = reels_of(task)
        self.names = tuple(self._reels)
        self.cameras: dict[str, DigitisingState] = {}
        self.kept = dict.fromkeys(self.names, 0)
        self.uv = np.full((len(task.rig), len(task.method.markers), self.n_frames, 2), np.nan)
        for name in self.names:
            self._replayed(name)
            if not self.finished(name):
                break
        self._stamp = self._stamps()

    @property
    def n_frames(self) -> int:
        """Of every camera."""
        return next(iter(self._reels.values())).n_frames

    @property
    def camera(self) -> str:
        """Whose turn it is; the last one when all are finished."""
        return next(reversed(self.cameras))

    @property
    def state(self) -> DigitisingState:
        """Of the camera whose turn it is."""
        return self.cameras[self.camera]

    @property
    def question(self) -> Question:
        """What is asked now."""
        return question_of(self.state, method=self.task.method)

    @property
    def outdated(self) -> bool:
        """Whether somebody else has written to the answers' files since."""
        return self._stamps() != self._stamp

    @property
    def can_undo(self) -> bool:
        """Whether there is an answer to take back."""
        first = self.camera == self.names[0]
        return self.state.before is not None or not (first or self.kept[self.camera])

    def finished(self, camera: str) -> bool:
        """Whether all frames of a camera are saved, and no one is being looked at again."""
        state = self.cameras.get(camera)
        return state is not None and state.phase is DigitisingPhase.DONE

    def saved(self, camera: str) -> int:
        """How many frames of a camera are saved."""
        state = self.cameras.get(camera)
        return 0 if state is None else sum(frame is not None for frame in state.saved)

    def lines(self) -> dict[str, Floats]:
        """For each other camera that saw the marker asked for, (n, 2) px on its epipolar line in this image."""
        question, here = self.question, self.task.rig.names.index(self.camera)
        if question.marker < 0 or question.marker == self.task.method.fixed:
            return {}
        seen = self.uv[:, question.marker, question.frame]
        others = [c for c in range(len(seen)) if c != here and np.isfinite(seen[c]).all()]
        found = {self.task.rig.names[c]: self._line(c, here, seen[c]) for c in others}
        return {name: line for name, line in found.items() if len(line) > 1}

    def spots(self) -> Floats:
        """(n, 2) px what can be pointed at where a place is asked for, nearest to the one expected first; what is
        another marker's already comes last."""
        question = self.question
        if question.phase not in (DigitisingPhase.POINT, DigitisingPhase.CORRECT):
            return np.zeros((0, 2))
        spots, at = self._reels[self.camera](question.frame).uv, question.uv
        if question.proposal is not None and np.isfinite(question.proposal.uv).all():
            at = question.proposal.uv
        near = np.hypot(*(spots - at).T) if np.isfinite(at).all() else spots[:, 1]  # else from the top down
        return np.asarray(spots[np.lexsort((near, self._taken(spots)))])

    def _taken(self, spots: Floats) -> Bools:
        """(n) whether a spot is the nearest to a place that another marker has in this frame."""
        others = np.delete(self.state.draft.uv, self.question.marker, axis=0)
        apart = np.linalg.norm(spots - others[np.isfinite(others).all(1), None], axis=2)
        return np.isin(np.arange(len(spots)), apart.argmin(1)) if len(spots) else np.zeros(0, bool)

    def answer(self, answer: Answer) -> None:
        """Take an answer to the question; what cannot be used changes nothing.

        Raises:
            ValueError, KinemarkError: as `digitise.advance`; or the file cannot be written.
        """
        camera = self._back() if isinstance(answer, Undo) and self.state.before is None else self.camera
        question = question_of(self.cameras[camera], method=self.task.method)
        after = advance(
            self.cameras[camera], answer, self._reels[camera],
            method=self.task.method, proposer=proposer_of(self._views(camera), self.task.method),
        )  # fmt: skip
        append_answer(self.task.answers[camera], given(question, answer))  # (1)
        if camera != self.camera:
            del self.cameras[self.camera]
        self.kept[camera] += 1
        self.cameras[camera] = after
        self._stamp = self._stamps()
        self._settle(camera)

    def _settle(self, camera: str) -> None:
        """What a camera says to those after it; where it is finished, the next one's turn comes."""
        c, k = self.task.rig.names.index(camera), self.names.index(camera)
        self.uv[c] = np.nan
        if not self.finished(camera):
            return
        self.uv[c] = result(self.cameras[camera], method=self.task.method).uv
        if k + 1 < len(self.names):
            self._replayed(self.names[k + 1])

    def _back(self) -> str:
        """The camera before, which nothing was built upon yet; (2).

        Raises:
            ValueError: there is none.
        """
        k = self.names.index(self.camera)
        if k == 0 or self.kept[self.camera]:
            raise ValueError("there is no answer to take back")
        return self.names[k - 1]

    def _replayed(self, name: str) -> None:
        """A camera as far as its answers go."""
        answers, method = read_answers(self.task.answers[name]), self.task.method
        replay = Replay(answers, otherwise=_stopped)
        try:
            state = drive(
                replay, self._reels[name], n_frames=self.n_frames, method=method, constant=self._constant(name),
                proposer=proposer_of(self._views(name), method), reopened=replay.goes_on,
            )  # fmt: skip
        except KinemarkError as error:
            raise KinemarkError(f"{self.task.answers[name]}: {error}") from error
        if replay.unused:
            raise KinemarkError(
                f"{self.task.answers[name]} has {replay.unused} answers to questions that were not put. Were the "
                "images, the threshold or the markers others when they were given? Remove the file, and digitise again."
            )
        self.cameras[name], self.kept[name] = state, len(answers)
        if self.finished(name):
            self.uv[self.task.rig.names.index(name)] = result(state, method=method).uv

    def _constant(self, name: str) -> Floats | None:
        if self.task.constants is None:
            return None
        return np.asarray(self.task.constants[list(self.task.images).index(name)])

    def _views(self, name: str) -> OtherViews | None:
        """What the cameras before this one say."""
        c = self.task.rig.names.index(name)
        return OtherViews(self.task.rig, c, self.uv) if c else None

    def _line(self, other: int, here: int, uv: Floats) -> Floats:
        """(n, 2) px in the image of one camera, of what another sees at (2,) px."""
        there, own = self.task.rig[other], self.task.rig[here]
        way = np.linalg.solve(there.K, np.append(undistort(there, uv[None])[0], 1.0))
        xyz = (np.geomspace(NEAR_MM, FAR_MM, LINE_POINTS)[:, None] * way - there.t) @ there.R
        place = project(own, xyz[(xyz @ own.R.T + own.t)[:, 2] > 0]) + self.state.draft.shift
        width, height = own.size if own.size.any() else self._reels[own.name](self.question.frame).size
        inside = ((place > -0.5 * np.array([width, height])) & (place < 1.5 * np.array([width, height]))).all(1)
        return np.asarray(place[inside])

    def _stamps(self) -> tuple[tuple[int, ...], ...]:
        """Change when a file of answers does."""
        found = []
        for path in self.task.answers.values():
            stat = path.stat() if path.exists() else None
            found.append((stat.st_size, stat.st_mtime_ns, stat.st_ino) if stat else ())
        return tuple(found)


def _stopped(question: Question, state: DigitisingState) -> Answer:
    """Nobody is asked while the answers that were given are gone through."""
    raise DigitisingStopped
