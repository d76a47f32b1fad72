"""What to write under `[detect]` and `[masks]` of a session, proposed by its own images."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...data import KinemarkError
from ...detect.proposal import DetectionProposal, propose
from ...io.files import check_new
from ...io.images import ImageSource, open_images
from ...io.masks_toml import write_masks
from ...numerics.evenly import evenly
from ..recordings import masks_of, open_cameras
from ..session import Session

FRAMES = 12
"""Looked at, of all cameras together at least two each; chosen."""


def propose_detection(source: Path) -> dict[str, DetectionProposal]:
    """Proposals by camera, and of all cameras together under "all" where their images are of one size.

    Args:
        source: a session, whose first trial with images is looked at, or images or a video.

    Raises:
        KinemarkError: there are no images, or they cannot be read.
    """
    if not (source.is_dir() and (source / "session.toml").is_file()) and source.suffix.lower() != ".toml":
        return {source.name: propose(open_images(source))}
    session = Session.open(source)
    pattern = next((trial.images for trial in session.settings.trials if trial.images), None)
    if pattern is None:
        raise KinemarkError(f"{source} has no trial with images. Name images or a video.")
    sources = open_cameras(session.root, session.settings, pattern, session.camera_names)
    said = getattr(session.settings.detect, "inverted", False) or None  # what the session does not say, images do
    found = {name: propose(images, inverted=said) for name, images in sources.items()}
    return _together(sources, said) | found


def _together(sources: dict[str, ImageSource], inverted: bool | None) -> dict[str, DetectionProposal]:
    """What the images of all cameras propose, for `[detect]` is one for all."""
    if len({source.size for source in sources.values()}) > 1 or len(sources) < 2:
        return {}
    each = max(2, -(-FRAMES // len(sources)))
    stacks = [_first_of_stretches(source, each) for source in sources.values()]
    stack = np.concatenate(stacks)
    return {"all": propose(stack, frames=len(stack), inverted=inverted)}


def _first_of_stretches(source: ImageSource, n: int) -> np.ndarray:
    """So many frames of a recording, spread evenly."""
    wanted = set(evenly(source.n_frames, n).tolist())
    return np.concatenate([batch for f, batch in enumerate(source.batches(1)) if f in wanted])


def learn_session_masks(source: Path, target: Path) -> int:
    """Write the masks of a session, drawn and learned together, to a TOML file; how many polygons they have.

    Raises:
        KinemarkError: the session has no `[masks]`, or the target exists.
    """
    check_new(target)
    session = Session.open(source)
    masks = masks_of(session.root, session.settings, session.camera_names)
    if masks is None:
        raise KinemarkError(
            'The session has no [masks]. Name a recording of the empty volume: empty = "empty/{camera}.mkv".'
        )
    write_masks(target, masks)
    return sum(len(polygons) for polygons in masks.polygons)
