"""What a template scores on its own data: a trial that scores far less is of something else.

The trials of a template, or thirds of a single one, are left out one after the other. The part that is left out is
scored by the mean distances and spreads of the rest, as a share of what these expect of it (`evidence.frame_fit`). A
template of steady gait then scores about 1; one of a single movement that never comes back scores less, and must not
ask more of the trial that it labels.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..data.array_types import Floats
from ..numerics.vectors import lengths
from .evidence import PairScore, frame_fit

if TYPE_CHECKING:
    from .template import Template

THIRDS = 3
"""Parts of a single trial; chosen: what is left shows most of its postures."""
LEAST_FRAMES = 6
"""Below which no part is left out; chosen, two frames a part."""
LEAST, MOST = 0.7, 1.0
"""Between which the share is; chosen: wrong templates reach 0.3 of it and must stay below, and chance is no measure."""


def own_fit(parts: Sequence[Floats], template: Template) -> float:
    """The least share that a part scores by the others, within 0.7 to 1; parts (L, K, 3) mm of each trial."""
    pieces = list(parts)
    if len(pieces) == 1:
        pieces = np.array_split(pieces[0], THIRDS, axis=1)
    if sum(piece.shape[1] for piece in pieces) < LEAST_FRAMES:
        return MOST
    found = [_left_out(k, pieces, template) for k in range(len(pieces))]
    return float(np.clip(np.nanmin([*found, MOST]), LEAST, MOST))


def _left_out(k: int, pieces: Sequence[Floats], template: Template) -> float:
    """The share of part k; NaN where it shows no two markers that the rest knows."""
    rest = np.concatenate([_distances(piece) for i, piece in enumerate(pieces) if i != k], axis=2)
    if not (rest > 0).any():
        return np.nan
    n = np.isfinite(rest).sum(2)
    mean = np.where(n > 0, np.nansum(rest, 2) / np.maximum(n, 1), np.nan)
    spread = np.sqrt(np.nansum((rest - mean[..., None]) ** 2, 2) / np.maximum(n, 1))
    wider = np.sqrt(np.maximum(template.spread**2 - _spread_of(template, pieces) ** 2, 0.0))
    pairs = PairScore.of_template(replace(template, distance=mean, spread=np.hypot(spread, wider)))
    fit = frame_fit(np.moveaxis(pieces[k], 1, 0).astype(np.float32), pairs)
    return float(fit[fit != 0].mean()) if (fit != 0).any() else np.nan


def _spread_of(template: Template, pieces: Sequence[Floats]) -> Floats:
    """(L, L) of all frames: what the template has beyond it was added, as for a static trial."""
    d = np.concatenate([_distances(piece) for piece in pieces], axis=2)
    n = np.maximum(np.isfinite(d).sum(2), 1)
    return np.asarray(np.sqrt(np.nansum((d - np.nan_to_num(template.distance)[..., None]) ** 2, 2) / n))


def _distances(xyz: Floats) -> Floats:
    """(L, L, K) of each pair in each frame."""
    return lengths(xyz[:, None] - xyz[None])
