"""The log-likelihood ratio (2) of `drifting_pairs`, of two markers to one, of runs of pairs of images."""

from __future__ import annotations

import numpy as np

from ....data.array_types import Floats, Ints
from ..detection_index import Images
from .drifting_pairs import UsualResiduals, blocks, residual, scores


def scores_of_runs(
    pair: Ints, frame: Ints, of: Ints, n: int, images: Images, usual: UsualResiduals, gate: float
) -> Floats:
    """(n) the sum of the scores of each of n runs, 0 of cameras that are not judged.

    Args:
        pair: (2, R) images of two cameras in frame (R) of the runs `of` (R), by run and frame.
    """
    out, camera = np.zeros(n), images.camera[pair]
    both = np.where(camera[0] < camera[1], pair, pair[::-1])
    for cameras in usual.of:
        some = (np.sort(camera, axis=0) == np.array(cameras)[:, None]).all(0)
        total = scores_of_pair(frame[some], of[some], both[:, some], images, usual, cameras, gate)
        out[: len(total)] += total
    return out


def scores_of_pair(
    frame: Ints, of: Ints, both: Ints, images: Images, usual: UsualResiduals, cameras: tuple[int, int], gate: float
) -> Floats:
    """(K) the same of the runs `of` (R), of detections (2, R) of two cameras that are judged."""
    one, out = usual.of[cameras], np.zeros(int(of.max(initial=-1)) + 1)
    e, squared = residual(images, usual.F[cameras], *both)
    for block in blocks(frame, of):
        np.add.at(out, of[block[:, 0]], scores(e[block] - one.median, squared[block].mean(1) * gate**2, one))
    return out
