"""Any file that Kinemark knows, converted."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..data import Detections, KinemarkError, Rig
from ..data.trial import UP
from ..io.detections_csv import NamedDetections
from ..io.files import check_new
from ..io.formats import FORMATS, UNKNOWN_RATE, Content, ReadOptions, endings, read_file, write_file
from ..io.notes import FileNote, read_notes
from ..io.tdf import Tdf
from ..io.trial import trial_in
from .describe import describe
from .session_name import FILE

__all__ = ["convert", "describe"]


def convert(
    source: Path,
    target: Path,
    *,
    what: Content | None = None,
    length_unit: str | None = None,
    rate_hz: float | None = None,
    partial: bool = False,
    up: str | None = None,
) -> tuple[FileNote, ...]:
    """Read one file and write its content in another format, the formats by the names' endings.

    Args:
        source: the file to read.
        target: the file to write.
        what: which part of it, where the ending of `target` leaves that open.
        length_unit: of a file that is silent or wrong about it.
        rate_hz: of a file that is silent or wrong about it.
        partial: read what there is of a damaged file.
        up: the axis of the world that goes up in the target, of trajectories; as in the source where None.

    Returns:
        What was odd in the source, and what the target could not hold.

    Raises:
        KinemarkError: the target exists, its format does not hold what the source has, or the source is damaged.
    """
    check_new(target)
    if rate_hz is not None and not 0 < rate_hz < np.inf:
        raise KinemarkError(f"--rate-hz is {rate_hz}, wanted a number above 0.")
    have, odd = _contents(source, ReadOptions(rate_hz, length_unit, partial, what))
    suffix = target.suffix.lower()
    fits = [content for content in have if suffix in endings(content) and what in (None, content)]
    if len(fits) != 1:
        held = FORMATS[suffix].write if suffix in FORMATS else ()
        others = dict.fromkeys(ending for content in have if what in (None, content) for ending in endings(content))
        another = f"Choose another ending: {', '.join(others) or 'none fits'}."
        raise KinemarkError(
            f"{source} has {', '.join(have) or 'nothing to convert'}; {suffix or 'a file without an ending'} can hold "
            f"{' or '.join(held) or 'none of it'}. "
            + ("Say which with --what." if len(fits) > 1 else another)
            + "".join(f" In the source: {note}." for note in odd)
        )
    content = have[fits[0]]
    turning: tuple[FileNote, ...] = ()
    if up is not None:
        if fits[0] != "trajectories":
            raise KinemarkError(f"--up turns trajectories, and {target} is to hold {fits[0]}. Leave it out.")
        from .vertical import with_axis_up  # brings the gait model, which other conversions do not need

        content, turning = with_axis_up(content, up)
    elif fits[0] == "trajectories" and suffix == ".c3d" and UP not in content.about and content.source is None:
        from .vertical import with_axis_said

        content, turning = with_axis_said(content)
    return (*read_notes(odd), *turning, *write_file(target, fits[0], content))


def _contents(source: Path, options: ReadOptions) -> tuple[dict[Content, Any], tuple[str, ...]]:
    """What of a file can be written elsewhere, and what was odd in it."""
    found = read_file(source.parent if source.name == FILE else source, options)
    if isinstance(found, np.ndarray):
        if options.length_unit is None:
            raise KinemarkError(f"{source} holds DLT parameters of an unknown unit. Say --length-unit m or mm.")
        from .calibration import rig_of_dlt  # takes long to import, and no other file needs it

        found = rig_of_dlt(source, (), options.length_unit)
    points = found.detections if isinstance(found, NamedDetections) else found
    if (
        isinstance(points, Detections)
        and points.rate == UNKNOWN_RATE
        and options.rate_hz is None
        and source.suffix.lower() == ".csv"
    ):
        raise KinemarkError(f"{source} does not say its frame rate. Say --rate-hz.")
    parts: dict[Content, Any] = {"trajectories": trial_in(source.stem, found)}
    if isinstance(found, Tdf):
        parts |= {"detections": found.detections, "rig": found.rig}
    elif isinstance(points, (Detections, Rig)):
        parts["detections" if isinstance(points, Detections) else "rig"] = found
    return {content: part for content, part in parts.items() if part is not None}, getattr(found, "notes", ())
