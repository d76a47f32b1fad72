"""`kinemark detect` and `white-pixels`: parameters that images propose, masks, and recordings in black and white."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from ...data import KinemarkError
from ..output import Json, Rate, print_result


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


def white_pixels(
    source: Path,
    target: Path,
    *,
    threshold: float = 60.0,
    inverted: bool = False,
    rate_hz: Rate = None,
    json: Json = False,
) -> None:
    """Keep the white pixels of a camera's recording alone, as a video without loss that every command reads.

    Args:
        source: a video, or images as 'cam1/%04d.png'.
        target: the video, ending in .mkv; an existing one is not replaced.
        threshold: grey level of 8 bits above which a pixel is white.
        inverted: the markers are dark on bright ground.
        json: print the figures for a machine.
    """
    from ...engine.white_pixels import write_white_pixels

    found = write_white_pixels(source, target, threshold=threshold, inverted=inverted, rate_hz=rate_hz)
    if json:
        print_result(found._asdict())
        return
    print_result(
        f"{target} is written: {found.n_frames} frames at {found.rate:g} Hz, {found.mean_white:.0f} white pixels in "
        'one on average. For its means of white pixels: [detect] centroid = "white"'
    )
