"""Where markers lie in a static trial: their mean places, and how much they move about them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data.array_types import Floats
from .known_samples import KnownSamples
from .marker_array import MarkerArray


class StaticShape(NamedTuple):
    """Mean places of the markers seen in a static trial.

    Attributes:
        names: (M).
        xyz: (M, 3) mm.
        sd: (M) mm, RMS distance from the mean place, of sway and noise.
    """

    names: tuple[str, ...]
    xyz: Floats
    sd: Floats

    @classmethod
    def of(cls, static: MarkerArray) -> StaticShape:
        """The median place of every marker that the static trial shows; markers it does not show are left out."""
        known = KnownSamples.of(static)
        rows = np.flatnonzero(known.seen.any(1))
        places = [np.median(known.x[k, known.seen[k]], axis=0) for k in rows]
        residual = [
            ((known.x[k, known.seen[k]] - p) ** 2).sum(1).mean() ** 0.5 for k, p in zip(rows, places, strict=True)
        ]
        return cls(
            tuple(known.names[k] for k in rows),
            np.array(places).reshape(-1, 3),
            np.array(residual, np.float64).reshape(-1),
        )
