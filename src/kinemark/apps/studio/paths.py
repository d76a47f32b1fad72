"""Trajectories as the bytes that the page draws from: columns one after the other, little-endian."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Sequence
from typing import Any, get_args

import numpy as np

from ...data import MarkerTrajectory, Origin, Trajectories
from ...data.array_types import Floats
from .desk import OpenDocument
from .edit_messages import PathsPart
from .messages import Column

DEFAULT: tuple[Column, ...] = ("xyz", "sd", "origin")
COLUMNS: tuple[Column, ...] = get_args(Column)


def encoded(document: OpenDocument, paths: Sequence[MarkerTrajectory], columns: Sequence[str]) -> bytes:
    """The columns of some trajectories, each of all of them before the next."""
    return b"".join(_blob(document, path, column) for column in columns for path in paths)


def part(names: Sequence[str], trajectories: Trajectories, first: int, stop: int) -> PathsPart:
    """Frames first … stop − 1, from 0, of some trajectories, in a message."""
    cut = [trajectories[name].frames(first, stop) for name in names]
    text = {name: base64.b64encode(b"".join(_column(one, name) for one in cut)).decode() for name in DEFAULT}
    number = first + trajectories.first_frame
    return PathsPart(names=list(names), first_frame=number, n_frames=stop - first, **text)


def whole_part(document: OpenDocument, shown: Trajectories) -> PathsPart:
    """All frames of all of some trajectories, in a message."""
    text = {name: base64.b64encode(encoded(document, shown.paths, [name])).decode() for name in DEFAULT}
    return PathsPart(names=list(shown.names), first_frame=shown.first_frame, n_frames=shown.n_frames, **text)


def differing(before: Trajectories, after: Trajectories) -> tuple[list[str], list[str]]:
    """Names of trajectories that are new or others than before, and of those that are gone; the same record is same."""
    old = {path.name: path for path in before}
    changed = [path.name for path in after if old.get(path.name) is not path]
    there = set(after.names)
    return changed, [name for name in old if name not in there]


def forget_others(document: OpenDocument, kept: Iterable[Trajectories]) -> None:
    """Drop encoded columns of trajectories that are shown no more."""
    alive = {id(path) for one in kept for path in one}
    for key in [key for key in document.blobs if key not in alive]:
        document.blobs.pop(key, None)


def _blob(document: OpenDocument, path: MarkerTrajectory, column: str) -> bytes:
    """A column, encoded once for each record."""
    known = document.blobs.setdefault(id(path), (path, {}))[1]  # the record is kept so that its id stays its own
    if column not in known:
        known[column] = _column(path, column)
    return bytes(known[column])


def _column(path: MarkerTrajectory, column: str) -> bytes:
    values: Any = path.xyz
    if column == "sd":
        values = largest_sd(path.cov)
    elif column == "origin":
        return path.origin.astype(np.uint8).tobytes()
    elif column == "cov":
        values = path.cov.reshape(-1, 9)[:, [0, 1, 2, 4, 5, 8]]
    elif column == "residual":
        values = path.residual
    elif column == "cameras":
        return np.bitwise_count(path.cameras).astype(np.uint8).tobytes()
    return values.astype("<f4").tobytes()


def largest_sd(cov: Floats) -> Floats:
    """(F) mm, the standard deviation along the longest axis of covariances (F, 3, 3), NaN where unknown.

    The largest root of the characteristic polynomial of a symmetric matrix in closed form (Smith 1961): with
    q = tr A / 3, B = A − q I, p² = tr B² / 6 and r = det(B / p) / 2 it is q + 2 p cos(arccos(r) / 3).
    """
    q = (cov[:, 0, 0] + cov[:, 1, 1] + cov[:, 2, 2]) / 3
    if np.isnan(q).any():  # as of files that say nothing of it
        known, found = ~np.isnan(q), np.full(len(q), np.nan)
        found[known] = largest_sd(cov[known]) if known.any() else np.nan
        return found
    xx, yy, zz = (cov[:, k, k] - q for k in range(3))
    xy, xz, yz = cov[:, 0, 1], cov[:, 0, 2], cov[:, 1, 2]
    p = np.sqrt((xx**2 + yy**2 + zz**2 + 2 * (xy**2 + xz**2 + yz**2)) / 6)
    det = xx * (yy * zz - yz**2) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    with np.errstate(invalid="ignore", divide="ignore"):
        r = np.where(p > 0, det / (2 * p**3), 0.0)
    largest = q + 2 * p * np.cos(np.arccos(np.clip(r, -1, 1)) / 3)
    return np.sqrt(np.maximum(largest, 0))


def samples(path: MarkerTrajectory) -> tuple[int, int, int]:
    """First and last frame with a sample, from 0, and how many there are; −1, −1, 0 where there are none."""
    seen = np.flatnonzero(path.origin != Origin.MISSING)
    return (int(seen[0]), int(seen[-1]), len(seen)) if len(seen) else (-1, -1, 0)
