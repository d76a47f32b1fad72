"""`kinemark init`: the first session.toml of a folder of recordings."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from ...data.errors import users_mistake
from ...data.typed import typed
from ...engine.session_name import FILE
from ..output import Json, print_result

if TYPE_CHECKING:  # takes long to import, and --help does without
    from ...engine.first_session import SessionProposal


def init(
    folder: Path,
    *,
    answer: Annotated[list[str] | None, Parameter(name="--answer", negative="")] = None,
    role: Annotated[list[str] | None, Parameter(name="--role", negative="")] = None,
    yes: Annotated[bool, Parameter(negative="")] = False,
    dry_run: Annotated[bool, Parameter(negative="")] = False,
    json: Json = False,
) -> None:
    """Look at a folder of recordings and write its first session.toml; what no file tells is asked in the terminal.

    Args:
        folder: that holds the recordings; an existing session.toml is never overwritten.
        answer: KEY=VALUE of what would be asked, as calibration.wand.lengths_mm=500; may be repeated.
        role: RECORDING=ROLE where the program guesses wrong, as "dance/{camera}.avi=wand"; may be repeated.
        yes: ask nothing; what is not known is written as comments that say what is wanted.
        dry_run: print the file instead of writing it.
    """
    from ...engine.first_session import answered, propose_session, session_text, write_first_session
    from ...engine.first_session.session_text import existing
    from ...report.words.first_session import question_text

    if (folder / FILE).exists() and not dry_run:
        raise existing(folder / FILE)
    proposal = propose_session(folder)
    for text in role or ():
        proposal = _changed(text, proposal, _with_role)
    for text in answer or ():
        proposal = _changed(text, proposal, answered)
    if not (yes or json) and sys.stdin.isatty():
        proposal = asked(confirmed(proposal))
    if dry_run:
        print_result(session_text(proposal).rstrip("\n"))
        return
    path = write_first_session(proposal)
    left = [{"key": one.key, "question": question_text(one)} for one in proposal.open]
    if json:
        print_result({"written": str(path), "open": left, **proposal.figures()})
    else:
        print_result(_written(proposal, path))


def confirmed(proposal: SessionProposal) -> SessionProposal:
    """The same with the roles that a person at the terminal corrects; an empty line takes them as they are."""
    from ...engine.first_session import Role
    from ...report.words.first_session import reason_text

    while True:
        rows = [
            f"{k:3d}  {one.role:14s} {one.path}  ({reason_text(one.why)})"
            for k, one in enumerate(proposal.recordings, 1)
        ]
        print_result("\n".join(rows))
        print_result(f"Is one of them something else? As: 2 wand; there are {', '.join(Role)}  (Enter: all is right)")
        words = sys.stdin.readline().split()
        if not words:
            return proposal
        try:
            place = int(words[0]) - 1 if words[0].isdecimal() else -1
            if not (0 <= place < len(rows) and len(words) == 2):
                raise ValueError(f"wanted are a number from 1 to {len(rows)} and a role")
            proposal = _with_role(proposal, proposal.recordings[place].path, words[1])
        except ValueError as error:
            print_result(f"  {error}")


def asked(proposal: SessionProposal) -> SessionProposal:
    """The same with what a person at the terminal answers; an empty line leaves a question open."""
    from ...engine.first_session import answered
    from ...report.words.first_session import question_text

    skipped: set[str] = set()
    while question := next((one for one in proposal.open if one.key + one.about not in skipped), None):
        print_result(f"{question_text(question)}  (Enter: later)")
        text = sys.stdin.readline()
        if not text.strip():
            skipped.add(question.key + question.about)
            continue
        try:
            proposal = answered(proposal, question.key, text)
        except ValueError as error:
            print_result(f"  {error}")
    return proposal


def _changed(
    text: str, proposal: SessionProposal, change: Callable[[SessionProposal, str, str], SessionProposal]
) -> SessionProposal:
    """With what one KEY=VALUE says."""
    key, equals, value = text.rpartition("=") if "{" in text else text.partition("=")
    with users_mistake():
        if not equals:
            raise ValueError(f"{text!r} is not of the form KEY=VALUE")
        return change(proposal, key.strip(), value)


def _with_role(proposal: SessionProposal, path: str, role: str) -> SessionProposal:
    from ...engine.first_session import Role, with_role

    if role.strip() not in list(Role):
        raise ValueError(f"{role.strip()!r} is no role; there are {', '.join(Role)}")
    return with_role(proposal, path, Role(role.strip()))


def _written(proposal: SessionProposal, path: Path) -> str:
    """What was found, and what comes next."""
    from ...report.words.first_session import question_text

    way = f"{proposal.way.role} ({proposal.way.path})" if proposal.way else "none found"
    lines = [
        f"cameras:     {', '.join(proposal.cameras) or 'not known'}",
        f"calibration: {way}",
        f"trials:      {', '.join(one.name for one in proposal.trials) or 'none found'}",
        *(f"to answer:   {one.key}: {question_text(one)}" for one in proposal.open),
        f"{path} is written. {'Complete it' if proposal.open or not proposal.way else 'Look at it'}, "
        f"then: kinemark calibrate {typed(path.parent)}",
    ]
    return "\n".join(lines)
