"""What the cameras saw: 2D points of all cameras and frames, ragged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .array_types import Bools, Floats, Ints
from .arrays import check_offsets, column, set_columns
from .short_repr import ShortRepr


class Validity(IntEnum):
    """Whether a detection goes on to matching, and why not (KISS 2.2, 2.3.4)."""

    VALID = 0
    TOO_SMALL = 1
    TOO_LARGE = 2
    NOT_ROUND = 3
    AT_EDGE = 4
    MASKED = 5


NOT_ROWS = ("cameras", "rate", "start", "ground_subtracted")
"""Fields of `Detections` that are not one value a row."""
LEAN = ("cov", "area", "width", "height", "peak")
"""Those that are in memory once where all rows are alike: files often state nothing but places."""


def alike_in_all(values: Floats) -> bool:
    """Whether a column of `Detections` is one value that stands for all rows."""
    return len(values) > 1 and values.strides[0] == 0


def _lean(values: Floats) -> Floats:
    """The column, or one value in place of as many that are alike."""
    if len(values) < 2 or alike_in_all(values) or not _equal(values[-1], values[0]) or not _equal(values, values[0]):
        return values
    return np.broadcast_to(values[0].copy(), values.shape)


def _equal(values: Floats, other: Floats) -> bool:
    """Whether values are another, NaN being NaN."""
    return bool(((values == other) | (np.isnan(values) & np.isnan(other))).all())


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Detections(ShortRepr):
    """Marker images of C cameras over F frames, D in all, sorted by camera, then frame.

    Of `cov`, `area`, `width`, `height` and `peak` what is alike in all rows is in memory once.

    Attributes:
        cameras: (C) names.
        rate: frames a second, Hz.
        start: (C, F+1) rows start[c, f]:start[c, f+1] are camera c in frame f.
        uv: (D, 2) centroids as the lens drew them (distorted), px.
        cov: (D, 2, 2) their covariance, px²; NaN where the source does not say.
        area: (D) px²; width, height: (D) px; peak: (D) grey level; NaN where the source does not say.
        validity: (D) a `Validity` each.
        merged: (D) whether markers lie on each other in this image: it was separated from another by a fit, or it may
            be more markers than one.
        ground_subtracted: names of the cameras from whose images a static ground was subtracted.
    """

    cameras: tuple[str, ...]
    rate: float
    start: Ints
    uv: Floats
    cov: Floats
    area: Floats
    width: Floats
    height: Floats
    peak: Floats
    validity: NDArray[np.uint8]
    merged: Bools
    ground_subtracted: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n = len(self.uv)
        set_columns(
            self,
            cameras=tuple(self.cameras),
            ground_subtracted=tuple(self.ground_subtracted),
            start=column("start", self.start, np.int64, len(self.cameras), None),
            uv=column("uv", self.uv, np.float64, n, 2),
            cov=_lean(column("cov", self.cov, np.float64, n, 2, 2)),
            area=_lean(column("area", self.area, np.float64, n)),
            width=_lean(column("width", self.width, np.float64, n)),
            height=_lean(column("height", self.height, np.float64, n)),
            peak=_lean(column("peak", self.peak, np.float64, n)),
            validity=column("validity", self.validity, np.uint8, n),
            merged=column("merged", self.merged, np.bool_, n),
        )
        check_offsets(self.start, n)

    @classmethod
    def build(
        cls,
        cameras: tuple[str, ...],
        rate: float,
        counts: ArrayLike,
        uv: ArrayLike,
        cov: ArrayLike | None = None,
        **shape: ArrayLike,
    ) -> Detections:
        """From counts (C, F) and rows in order of camera, then frame; not given: NaN, valid, not merged."""
        counts = np.asarray(counts, np.int64)
        uv = np.asarray(uv, np.float64).reshape(-1, 2)
        unknown = np.broadcast_to(np.nan, len(uv))
        ends = np.cumsum(counts.reshape(-1)).reshape(counts.shape)
        return cls(
            cameras=cameras,
            rate=rate,
            start=np.column_stack([ends[:, -1:] - counts.sum(1, keepdims=True), ends])
            if counts.shape[1]
            else np.zeros((len(counts), 1), np.int64),
            uv=uv,
            cov=np.broadcast_to(np.nan, (len(uv), 2, 2)) if cov is None else np.asarray(cov, np.float64),
            area=np.asarray(shape.get("area", unknown), np.float64),
            width=np.asarray(shape.get("width", unknown), np.float64),
            height=np.asarray(shape.get("height", unknown), np.float64),
            peak=np.asarray(shape.get("peak", unknown), np.float64),
            validity=np.asarray(shape.get("validity", np.zeros(len(uv))), np.uint8),
            merged=np.asarray(shape.get("merged", np.zeros(len(uv))), np.bool_),
        )

    def __reduce__(self) -> tuple[Any, ...]:
        columns = {f.name: getattr(self, f.name) for f in fields(self)}
        once = {name for name in LEAN if alike_in_all(columns[name])}
        columns |= {name: columns[name][:1].copy() for name in once}
        return _restored, (columns, once)

    def __len__(self) -> int:
        return len(self.uv)

    def __getitem__(self, camera_frame: tuple[int, int]) -> Floats:
        """A view of uv: what camera c saw in frame f, (n, 2) px."""
        return self.uv[self.rows(*camera_frame)]

    def rows(self, c: int, f: int) -> slice:
        """The rows of camera c in frame f."""
        return slice(int(self.start[c, f]), int(self.start[c, f + 1]))

    @property
    def n_frames(self) -> int:
        """F."""
        return self.start.shape[1] - 1

    @property
    def counts(self) -> Ints:
        """(C, F) detections a camera and frame."""
        return np.diff(self.start, axis=1)

    @property
    def camera(self) -> Ints:
        """(D) the camera of each row."""
        return np.repeat(np.arange(len(self.cameras)), self.counts.sum(1))

    @property
    def frame(self) -> Ints:
        """(D) the frame of each row."""
        return np.repeat(np.tile(np.arange(self.n_frames), len(self.cameras)), self.counts.reshape(-1))

    @property
    def valid(self) -> Bools:
        """(D) whether the row goes on to matching."""
        return self.validity == Validity.VALID

    def select(self, names: Sequence[str]) -> Detections:
        """Only the cameras of these names, in this order.

        Raises:
            ValueError: a name is not among the cameras.
        """
        if missing := [name for name in names if name not in self.cameras]:
            raise ValueError(f"cameras {missing} are not among {list(self.cameras)}")
        chosen = [self.cameras.index(name) for name in names]
        rows = np.concatenate([np.arange(self.start[c, 0], self.start[c, -1]) for c in chosen] or [np.zeros(0, int)])
        columns = {f.name: getattr(self, f.name)[rows] for f in fields(self) if f.name not in NOT_ROWS}
        found = Detections.build(tuple(names), self.rate, self.counts[chosen], **columns)
        return replace(found, ground_subtracted=tuple(name for name in names if name in self.ground_subtracted))

    def keep(self, mask: Bools) -> Detections:
        """Only the rows where `mask` (D) is true."""
        before = np.concatenate([[0], np.cumsum(mask)])
        columns = {f.name: getattr(self, f.name)[mask] for f in fields(self) if f.name not in NOT_ROWS}
        return replace(self, start=before[self.start], **columns)

    def frames(self, first: int, stop: int) -> Detections:
        """Frames first … stop − 1, counted from 0."""
        first, stop, _ = slice(first, stop).indices(self.n_frames)
        frame = self.frame
        part = self.keep((frame >= first) & (frame < stop))
        return replace(part, start=part.start[:, first : max(first, stop) + 1])


def _restored(columns: dict[str, Any], once: set[str]) -> Detections:
    """The record that `pickle` kept, with the columns in which all rows are alike once."""
    n = len(columns["uv"])
    return Detections(
        **columns | {name: np.broadcast_to(columns[name], (n, *columns[name].shape[1:])) for name in once}
    )
