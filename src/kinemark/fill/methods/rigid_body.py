"""A rigid body of three or more reference markers carries the marker.

The reference markers' mean shape s (N, 3) and the marker's place p in it are learnt in frames t where all are seen:
every frame is laid on the middle one, and averaged,

    s, p = mean of R(t)ᵀ (x(t) − c(t)),     R, c = the rigid motion that lays s on the reference markers            (1)

and in the gap the marker is at x̂(t) = R(t) p + c(t) (2). What (2) leaves over beside the gap is carried into it, and
gives the covariance C (`bridge`). The body is the less rigid the more its reference markers change their shape, by
d(t) = mean over them of |R(t) sₙ + c(t) − xₙ(t)|², which is seen in the gap too:

    C(t) (1 + d(t) / d̄) / 2,     d̄ = mean of d where the marker is seen                                         (3)

as soft parts move by as much as they did in frames of such a shape, and the marker by itself as ever.

Reference markers are the markers that keep their distance from the marker best; of the three, four, … most rigid that
do not lie on a line, the set is taken with the least mean square error of (2) where the marker is seen. Where the trial
never shows the marker together with three reference markers, a static trial can give s and p (`static`).

Source: Söderkvist & Wedin (1993) for R; the use is common to all systems.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...data.array_types import Bools, Floats, Ints
from ...data.method import ONE, parameter
from ...geometry import nearest_rotations, rigid_poses
from ..known_samples import KnownSamples, Span, sections
from ..marker_array import Gap, MarkerArray, Prediction
from ..reference_markers import Distances, distances, nearest
from ..residual_bridge import Leftover, bridge
from ..static_shape import StaticShape
from .stage import FILL, FillMethod

LEARN = 160
"""Frames from which a body is learnt; chosen (see benchmarks/gaps.py)."""
JUDGE = 40
"""Frames in which sets of reference markers are compared; chosen (see benchmarks/gaps.py)."""
RIGID = 1e-6
"""mm², d̄ of (3) at least: a thousandth of a millimetre, squared; chosen: below what any system tells."""


@dataclass(frozen=True, slots=True)
class RigidBody(FillMethod):
    """The place on a rigid body of three or more reference markers."""

    reference_markers: tuple[str, ...] = parameter(
        (),
        meaning="reference markers: at least three markers on the same body; empty: chosen by measured skill",
    )
    most_markers: int = parameter(5, unit="markers", low=3, meaning="most reference markers, when they are chosen")
    min_breadth: float = parameter(
        0.1, unit=ONE, low=0, below=1,
        meaning="least ratio of breadth to length of a set of reference markers; below it they lie on a line",
    )  # fmt: skip
    static: StaticShape | None = parameter(
        None, meaning="shape of the body in a static trial, used where the trial itself does not show it"
    )

    def check_together(self) -> None:
        """Refuse fewer than three reference markers."""
        if self.reference_markers and len(set(self.reference_markers)) < 3:
            raise ValueError(
                f"reference_markers are {list(self.reference_markers)}, wanted at least three different ones, or none"
            )


class BodyShape(NamedTuple):
    """Reference markers, their shape, the marker in it, and what the body leaves over.

    Attributes:
        references: (N).
        shape: (N, 3) mm, about its mean.
        place: (3) mm, of the marker in it.
        left: residuals where the marker is seen; None where it never is together with the reference markers.
        change: mm², d̄ of (3).
    """

    references: Ints
    shape: Floats
    place: Floats
    left: Leftover | None
    change: float = np.nan

    def carry(self, points: Floats) -> tuple[Floats, Floats]:
        """(2): the marker (F, 3) mm from the reference markers (N, F, 3), and d (F) mm² of (3); NaN where one is."""
        out, d = np.full((points.shape[1], 3), np.nan), np.full(points.shape[1], np.nan)
        there = ~np.isnan(points[..., 0]).any(0)
        x = points[:, there].swapaxes(0, 1)
        R, c = rigid_poses(self.shape, x)
        out[there], d[there] = R @ self.place + c, change_of_shape(self.shape, R, x - c[:, None])
        return out, d


class _LearntBody(NamedTuple):
    """What gaps of a call share.

    Attributes:
        allowed: (M) which may be reference markers.
        distances: of all markers from one.
        bodies: by marker and the pool of reference markers to choose from.
        of_set: by marker, reference markers and number of frames, what `learn` made of them: pools share sets.
    """

    allowed: Bools
    distances: Distances
    bodies: dict[tuple[int, bytes], BodyShape | str]
    of_set: dict[tuple[int, bytes, int], BodyShape | None]


@FILL.method("rigid_body", RigidBody, rank=5, source="Söderkvist and Wedin 1993")
def fill_rigid_body(motion: MarkerArray, gaps: list[Gap], *, method: RigidBody = RigidBody()) -> list[Prediction]:
    """Each gap from its own reference markers, or section by section where reference markers come and go.

    Raises:
        ValueError: a reference marker named is not in the trial.
    """
    known = KnownSamples.of(motion)
    allowed = known.among(method.reference_markers)
    learnt = _LearntBody(allowed, distances(known), {}, {})
    return [_carried(known, known.span(gap), learnt, method) for gap in gaps]


def _carried(known: KnownSamples, span: Span, learnt: _LearntBody, method: RigidBody) -> Prediction:
    out, reasons, references = Prediction.none(span.length, ""), list[str](), set[int]()
    for start, stop in sections(known, span, least=3):
        body = _body(known, span, known.throughout(start, stop, but=span.marker), learnt, method)
        if isinstance(body, str):
            reasons.append(f"frames {start + 1} to {stop}: {body}")
            continue
        part = slice(start - span.start, stop - span.start)
        out.xyz[part], out.cov[part] = _carry(known, span, body, np.arange(start, stop))
        references |= {int(d) for d in body.references}
    return out._replace(references=tuple(sorted(references)), reason="; ".join(reasons))


def _carry(known: KnownSamples, span: Span, body: BodyShape, frames: Ints) -> tuple[Floats, Floats]:
    at = span.with_edges(frames)
    xyz, d = body.carry(known.at(body.references[:, None], at))
    beside = known.x[span.marker, at[-2:]] - xyz[-2:]
    beside[[span.before < 0, span.after < 0]] = np.nan
    xyz = xyz[:-2]
    if body.left is None:
        return xyz, np.full((len(frames), 3, 3), np.nan)
    correction, cov = bridge(body.left, span, frames.astype(np.float64), beside)
    return xyz + correction, cov * (1 + d[:-2, None, None] / body.change) / 2  # (3)


def _body(known: KnownSamples, span: Span, there: Bools, learnt: _LearntBody, method: RigidBody) -> BodyShape | str:
    """The body of a marker with these others at hand, or why there is none."""
    there = there & learnt.allowed
    if there.sum() < 3:
        return f"needs three reference markers seen in the gap, found {known.called(np.flatnonzero(there)) or 'none'}"
    most = len(there) if method.reference_markers else method.most_markers
    pool = nearest(learnt.distances(span.marker).sd, there, most)
    if len(pool) < 3:  # hardly seen together: whatever a static trial knows
        pool = np.flatnonzero(there)
    key = (span.marker, pool.tobytes())
    if key not in learnt.bodies:
        learnt.bodies[key] = _best(known, span.marker, pool, learnt, method)
    return learnt.bodies[key]


def _best(known: KnownSamples, marker: int, pool: Ints, learnt: _LearntBody, method: RigidBody) -> BodyShape | str:
    """The body of the best set from a pool, most rigid first."""

    def of(references: Ints, frames: int) -> BodyShape | None:
        key = (marker, references.tobytes(), frames)
        if key not in learnt.of_set:
            learnt.of_set[key] = learn(known, marker, references, known.thin(frames), method.min_breadth)
        return learnt.of_set[key]

    sets = [pool] if method.reference_markers else [pool[:n] for n in range(3, min(method.most_markers, len(pool)) + 1)]
    judged = _judged(known, marker, sets, method.min_breadth) if len(sets) > 1 else None
    if judged is not None and (body := of(judged, LEARN)):
        return body
    found = [(s, body) for s in sets if (body := of(s, JUDGE))]
    if not found:
        found = [(s, body) for s in sets if (body := of(s, LEARN))]
    if not found:
        return _from_static(known, marker, pool, method)
    best = min(found, key=lambda pair: float(np.trace(pair[1].left.cov)) if pair[1].left else np.inf)
    return of(best[0], LEARN) or best[1]


def _judged(known: KnownSamples, marker: int, sets: list[Ints], flat: float) -> Ints | None:
    """The best of nested sets, compared in the same frames; None where too few show all."""
    who = np.append(sets[-1], marker)
    x = known.at(who, known.thin(JUDGE)[:, None])
    x = x[~np.isnan(x[..., 0]).any(1)]
    if len(x) < JUDGE // 2:
        return None
    use = np.arange(len(who) - 1) < np.array([[len(s)] for s in sets])
    share = use / use.sum(1, keepdims=True)
    body = x - (share @ x[:, :-1].reshape(len(x), len(who) - 1, 3)).swapaxes(0, 1)[:, :, None]  # (S, F, N + 1, 3)
    references, half = body[:, :, :-1] * use[:, None, :, None], len(x) // 2
    size = np.linalg.svd(references[:, half], compute_uv=False)
    line = ~(size[:, 1] > np.maximum(flat * size[:, 0], 1e-6))
    if line.all():
        return None
    s = (body @ nearest_rotations(references.mT @ references[:, half, None])).mean(1)  # (1)
    R = nearest_rotations(references.mT @ (s[:, None, :-1] * use[:, None, :, None]))
    residual = body[:, :, -1] - (R @ s[:, None, -1, :, None])[..., 0]
    error = np.where(line, np.inf, np.nan_to_num((residual**2).sum((1, 2)), nan=np.inf))
    return sets[int(np.argmin(error))]


def learn(known: KnownSamples, marker: int, references: Ints, frames: Ints, flat: float) -> BodyShape | None:
    """(1) from those of the frames, evenly spaced, where all are seen; None where there is none, or a line."""
    points = known.at(np.append(references, marker), frames[:, None])
    there = ~np.isnan(points[..., 0]).any(1)
    if not there.any():
        return None
    x = points[there]
    body = x - x[:, :-1].mean(1, keepdims=True)
    if on_line(body[len(x) // 2, :-1], flat):
        return None
    R, _ = rigid_poses(body[len(x) // 2, :-1], x[:, :-1])
    s = (body @ R).mean(0)  # (1)
    R, _ = rigid_poses(s[:-1], x[:, :-1])
    residual = np.full((len(frames), 3), np.nan)
    residual[there] = body[:, -1] - R @ s[-1]
    left = Leftover.of(residual, int(frames[1] - frames[0]) if len(frames) > 1 else 1)
    d = change_of_shape(s[:-1], R, body[:, :-1])
    return BodyShape(references, s[:-1], s[-1], left, max(float(d.mean()), RIGID))


def change_of_shape(shape: Floats, R: Floats, body: Floats) -> Floats:
    """d (F) mm² of (3): a shape (N, 3), as R (F, 3, 3) turns it, and what is seen about its mean (F, N, 3)."""
    return np.asarray(((shape @ R.mT - body) ** 2).sum(-1).mean(-1))


def on_line(shape: Floats, flat: float) -> bool:
    """Whether points (N, 3) lie on a line, or in one place."""
    size = np.linalg.svd(shape - shape.mean(0), compute_uv=False)
    return not size[1] > max(flat * size[0], 1e-6)


def _from_static(known: KnownSamples, marker: int, pool: Ints, method: RigidBody) -> BodyShape | str:
    """The body as it lies in the static trial."""
    name = known.names[marker]
    if method.static is None:
        return f"{name} is never seen together with three reference markers that do not lie on a line"
    at = {own: k for k, own in enumerate(method.static.names)}
    usable = [int(k) for k in pool if known.names[k] in at]
    if name not in at or len(usable) < 3:
        return f"{name} and three reference markers are seen together neither in this trial nor in the static one"
    shape = method.static.xyz[[at[known.names[k]] for k in usable]]
    if on_line(shape, method.min_breadth):
        return f"the reference markers {known.called(usable)} lie on a line in the static trial"
    return BodyShape(np.array(usable), shape - shape.mean(0), method.static.xyz[at[name]] - shape.mean(0), None)
