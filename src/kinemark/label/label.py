"""The names of a trial's tracks, each with a probability; nothing is named where the template does not fit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from ..data import KinemarkError, Tracks, Trajectories, make_finding
from ..data.finding import Finding
from ..data.track_trajectories import trajectories_of
from ..numerics.blas_threads import one_blas_thread
from .displaced import markers_beside
from .held import LEAST
from .labels import Labels, State
from .stage import LABEL
from .stated import with_stated
from .template import Template


@one_blas_thread()
def label(
    tracks: Tracks | Trajectories,
    template: Template,
    *,
    method: Any = None,
    stated: Mapping[str, str | None] = MappingProxyType({}),
) -> Labels:
    """Which marker each track is, as far as distances tell.

    Args:
        tracks: of a recording, whole or in pieces, with ghosts; names that they have are not looked at.
        template: what is known of the subject's markers.
        method: one of `LABEL`, with its parameters; `Distances()` where None.
        stated: track → marker that a person stated, None for no marker; facts by which the others are found.

    Raises:
        KinemarkError: there are no tracks.
        ValueError: the method is none that labels.
    """
    trajectories = trajectories_of(tracks) if isinstance(tracks, Tracks) else tracks
    if not len(trajectories) or not np.isfinite(trajectories.xyz).any():
        raise KinemarkError("There are no tracks with samples to be labelled. Track the recording first.")
    method = LABEL.make() if method is None else method
    found = LABEL.function(method)(trajectories, template, method=method, stated=stated)
    found = with_stated(found, trajectories, stated)
    return replace(found, displaced=markers_beside(trajectories, found, template, stated))


def refusal(fit: float, placed: float, holds: float, *, least_fit: float, least_placed: float) -> Finding | None:
    """The finding that a template does not fit a trial; None where it does. See `held` for `holds`."""
    if fit >= least_fit and placed >= least_placed and holds >= LEAST:
        return None
    return make_finding("labels_refused", fit_share=fit, placed_share=placed * min(1.0, holds))


def state_of(probability: float, sure: float) -> State:
    """In a word."""
    return "sure" if probability >= sure else "unsure" if probability > 0 else "unknown"
