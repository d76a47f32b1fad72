"""Clusters of markers as a command line states them."""

from __future__ import annotations

from collections.abc import Sequence

from ..data import KinemarkError
from ..gait.clusters import SEGMENTS, segment_name


def clusters_of(texts: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Markers by segment, of texts such as "left thigh=A,B,C".

    Raises:
        KinemarkError: one is no such text, or of no segment that carries a cluster, or says a thing twice.
    """
    parts = [text.partition("=") for text in texts]
    said = [(segment_name(segment), tuple(name.strip() for name in names.split(","))) for segment, _, names in parts]
    if wrong := [text for text, (segment, own) in zip(texts, said, strict=True) if not segment or not all(own)]:
        raise KinemarkError(
            f"--cluster {wrong[0]!r} is not understood. Write the segment, then its markers: 'left thigh=A,B,C'."
        )
    if unknown := [part[0].strip() for part in parts if segment_name(part[0]) not in SEGMENTS]:
        raise KinemarkError(f"--cluster is on {unknown[0]!r}, which is none of {', '.join(SEGMENTS)}.")
    for what in ([segment for segment, _ in said], [name for _, own in said for name in own]):
        if twice := [one for one in what if what.count(one) > 1]:
            raise KinemarkError(
                f"--cluster says {twice[0]} twice. A segment has one cluster, and a marker one segment."
            )
    return dict(said)
