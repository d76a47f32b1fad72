"""A cloud with its frames in the reverse order, so that what follows points forwards follows them backwards."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...data import Cloud
from ...data.array_types import Ints


def reversed_rows(cloud: Cloud) -> Ints:
    """(P) the rows, the last frame's first, those of a frame in their order; its own inverse for the reversed cloud."""
    return np.lexsort((np.arange(len(cloud)), -cloud.frame))


def reversed_cloud(cloud: Cloud) -> Cloud:
    """Frame F − 1 − f where f was."""
    rows = reversed_rows(cloud)
    start = np.concatenate([[0], np.cumsum(np.diff(cloud.start)[::-1])])
    columns = {name: getattr(cloud, name)[rows] for name in ("xyz", "cov", "residual", "detection")}
    return replace(cloud, start=start, **columns)


def numbered_as_they_begin(identity: Ints) -> tuple[Ints, Ints]:
    """Identities (P) numbered in the order in which they first occur, and the new number of each old one."""
    known, first = np.unique(identity[identity >= 0], return_index=True)
    order = np.argsort(first, kind="stable")
    new = np.full(int(known.max(initial=-1)) + 1, -1)
    new[known[order]] = np.arange(len(known))
    return np.where(identity >= 0, new[identity], -1), new
