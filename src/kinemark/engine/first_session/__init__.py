"""A first `session.toml` from a folder of recordings: looked at, guessed with reasons, asked, written."""

from .calibration_way import answered, with_facts, with_role
from .proposal import FoundRecording, Question, Reason, Role, SessionProposal
from .propose import propose_session
from .session_text import calibration_table, session_text, write_first_session

__all__ = [
    "FoundRecording",
    "Question",
    "Reason",
    "Role",
    "SessionProposal",
    "answered",
    "calibration_table",
    "propose_session",
    "session_text",
    "with_facts",
    "with_role",
    "write_first_session",
]
