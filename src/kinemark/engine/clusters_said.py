"""Clusters of markers as a command line states them."""

from __future__ import annotations

from collections.abc import Sequence

from ..data import KinemarkError
from ..gait.clusters import SEGMENTS, segment_name


def clusters_of(texts: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Markers by segment, of texts such as "left thigh=A,B,C".

    Raises:
        KinemarkError: one is no such text, or of no segment that carries a cluster.
    """
    parts = [text.partition("=") for text in texts]
    if wrong := ["".join(part) for part in parts if not (part[0].strip() and part[2].strip())]:
        raise KinemarkError(
            f"--cluster {wrong[0]!r} is not understood. Write the segment, then its markers: 'left thigh=A,B,C'."
        )
    if unknown := [part[0].strip() for part in parts if segment_name(part[0]) not in SEGMENTS]:
        raise KinemarkError(f"--cluster is on {unknown[0]!r}, which is none of {', '.join(SEGMENTS)}.")
    return {segment_name(part[0]): tuple(name.strip() for name in part[2].split(",")) for part in parts}
