"""Digitising with an operator: the machine follows markers and asks where it cannot (UM²AS 3.5). No screen is attached.

`find_markers` turns an image into what can be pointed at; `begin` and `advance` are the state machine, whose states are
values; `question_of` says what a state asks, `drive` answers with whoever is there: a terminal, a file, a test.
"""

from ..data.answers import (
    Absent,
    Accept,
    Answer,
    ByHand,
    Given,
    No,
    Point,
    Revisit,
    Undo,
    Verify,
    Yes,
    answer_text,
    parse_answer,
)
from .drive import DigitisedImages, DigitisingStopped, Operator, drive, result
from .identified_markers import Identified, called, identified, identified_matches, identified_tracks
from .image_markers import ImageMarkers, clicked, find_markers, nearest_free, threshold_of
from .machine import advance, begin, question_of
from .other_views import OtherViews, propose
from .replay import Replay, given
from .semi_automatic import DIGITISE, SemiAutomatic
from .state import (
    AskedQuestion,
    DigitisedFrame,
    DigitisingPhase,
    DigitisingState,
    MarkerStatus,
    PlaceProposal,
    Question,
    words,
)

__all__ = [
    "DIGITISE",
    "Absent",
    "Accept",
    "Answer",
    "AskedQuestion",
    "ByHand",
    "DigitisedFrame",
    "DigitisedImages",
    "DigitisingPhase",
    "DigitisingState",
    "DigitisingStopped",
    "Given",
    "Identified",
    "ImageMarkers",
    "MarkerStatus",
    "No",
    "Operator",
    "OtherViews",
    "PlaceProposal",
    "Point",
    "Question",
    "Replay",
    "Revisit",
    "SemiAutomatic",
    "Undo",
    "Verify",
    "Yes",
    "advance",
    "answer_text",
    "begin",
    "called",
    "clicked",
    "drive",
    "find_markers",
    "given",
    "identified",
    "identified_matches",
    "identified_tracks",
    "nearest_free",
    "parse_answer",
    "propose",
    "question_of",
    "result",
    "threshold_of",
    "words",
]
