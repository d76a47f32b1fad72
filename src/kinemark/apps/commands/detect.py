"""`kinemark detect` and `white-pixels`: proposed parameters, masks, pictures, recordings in black and white."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from ...data import KinemarkError
from ...io.files import check_new
from ..output import Json, Rate, print_result


def detect(
    source: Path,
    *,
    propose: bool = False,
    masks: Path | None = None,
    pictures: Path | None = None,
    trial: str | None = None,
    frames: str = "",
    json: Json = False,
) -> None:
    """Propose parameters for [detect] from images, learn the masks of a session, or show what is detected.

    Args:
        source: a session, images or a video.
        propose: say what the images propose, and why.
        masks: a new TOML file for what the session's [masks] leave out, drawn and learned.
        pictures: a new HTML page with the images of all cameras of a session's trial and what is detected in them,
            invalid spots with their reason.
        trial: of the pictures; the session's first with images where none is given.
        frames: of the pictures, as 10,40,80; five spread over the trial where none are given.
    """
    from ...engine.detection.proposals import learn_session_masks, propose_detection
    from ...report.terminal_summary import proposal_text
    from ...report.words import with_words

    if sum((propose, masks is not None, pictures is not None)) != 1:
        raise KinemarkError(
            "Say what is wanted, one of --propose, --masks FILE and --pictures FILE; kinemark run detects markers in a "
            "session."
        )
    if pictures is not None:
        _show(source, pictures, trial, frames, json=json)
        return
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
                | {"masks": [mask.tolist() for mask in proposal.masks]}
                for name, proposal in found.items()
            }
        )
    else:
        print_result("\n".join(f"# {name}: {proposal_text(proposal, name)}" for name, proposal in found.items()))


def _show(source: Path, page: Path, trial: str | None, frames: str, *, json: bool) -> None:
    """Write the page of `--pictures`, and say what is on it."""
    from ...engine.detection.frames import detected_frames
    from ...report.field_pictures import FieldPicture, write_fields_page

    check_new(page)
    found = detected_frames(source, trial, _numbers(frames))
    rows = [[FieldPicture(one.camera, f, one.image, one.blobs, one.tall) for one in row] for f, row in found.frames]
    write_fields_page(page, rows, heading=found.trial, below=f"What is detected · Session {found.session}")
    counts = [
        {"frame": one.frame, "camera": one.camera, "valid": one.valid, "invalid": one.invalid}
        for row in rows
        for one in row
    ]
    if json:
        print_result({"page": str(page), "pictures": counts})
        return
    total, invalid = sum(one.valid for row in rows for one in row), sum(one.invalid for row in rows for one in row)
    print_result(f"{page} is written: {len(counts)} images with {total} markers; invalid spots: {invalid}.")


def _numbers(frames: str) -> list[int]:
    """Frames as a list."""
    try:
        return [int(one) for one in frames.split(",")] if frames else []
    except ValueError:
        raise KinemarkError(f'--frames is "{frames}"; wanted: numbers of frames, as 10,40,80.') from None


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
