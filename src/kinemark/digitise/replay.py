"""Answers that were given before: digitising goes through them again and asks only what they do not say.

An answer belongs to a frame and a marker; of several to the same question, as after one was taken back or a frame was
looked at again, the first that is left is the next (1). As the machine does the same with the same images, answers and
parameters, this is where the operator was.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Sequence

from ..data import KinemarkError
from ..data.answers import Accept, Answer, Given
from .drive import Operator
from .state import DigitisingPhase, DigitisingState, Question, words


class Replay:
    """An operator who says what was said before, and leaves the rest to another.

    Args:
        given: the answers.
        otherwise: who is asked what they do not say; without one, that is an error.
        save_all: whether frames of which all is settled are accepted without a word.
    """

    def __init__(self, given: Sequence[Given], *, otherwise: Operator | None = None, save_all: bool = False) -> None:
        self._left: dict[tuple[int, str], deque[Answer]] = defaultdict(deque)
        for frame, marker, answer in given:
            self._left[frame, marker].append(answer)
        self._otherwise, self._save_all = otherwise, save_all

    @property
    def unused(self) -> int:
        """Answers that no question was put for."""
        return sum(map(len, self._left.values()))

    def goes_on(self, question: Question) -> bool:
        """Whether an answer to this question is left, as it is where a frame was looked at again after the last."""
        return bool(self._left.get((question.frame, question.name)))

    def __call__(self, question: Question, state: DigitisingState) -> Answer:
        """The answer to a question.

        Raises:
            KinemarkError: there is none, and nobody else to ask.
        """
        known = self._left.get((question.frame, question.name))
        if known:
            return known.popleft()  # (1)
        if self._save_all and question.phase is DigitisingPhase.REVIEW:
            return Accept()
        if self._otherwise is None:
            raise KinemarkError(f"There is no answer to this: {words(question)}")
        return self._otherwise(question, state)


def given(question: Question, answer: Answer) -> Given:
    """An answer as it is kept."""
    return Given(question.frame, question.name, answer)
