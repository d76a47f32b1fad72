"""`kinemark detect`: parameters that images propose, and masks."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from ...data import KinemarkError
from ..output import Json, print_result


def detect(source: Path, *, propose: bool = False, masks: Path | None = None, json: Json = False) -> None:
    """Propose parameters for [detect] from images, or learn the masks of a session.

    Args:
        source: a session, images or a video.
        propose: say what the images propose, and why.
        masks: a new TOML file for what the session's [masks] leave out, drawn and learned.
        json: print the proposed parameters for a machine.
    """
    from ...engine.detection_proposals import learn_session_masks, propose_detection
    from ...report.proposal_text import proposal_text
    from ...report.words import with_words

    if propose == (masks is not None):
        raise KinemarkError("Say what is wanted, --propose or --masks FILE; kinemark run detects markers in a session.")
    if masks is not None:
        n = learn_session_masks(source, masks)
        print_result(f'{masks} is written, {n} polygons. To use it: [masks] file = "{masks.name}"')
        return
    found = propose_detection(source)
    if json:
        print_result(
            {
                name: asdict(proposal.centroids)
                | {"findings": with_words([one.as_dict() for one in proposal.findings])}
                for name, proposal in found.items()
            }
        )
    else:
        print_result("\n".join(f"# {name}: {proposal_text(proposal)}" for name, proposal in found.items()))
