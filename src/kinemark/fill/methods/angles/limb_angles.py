"""The limb length and angle model as filler, on any cyclic trajectories.

A model of segments (`learn`), made of the trial itself, of another trial or read from a file, and the phase of each
frame, found from what is visible (`signal.phase`), place a missing marker from every neighbour that is seen
(`place`). The thesis takes that place as it is. Here the error r of the placing is carried over from the edges of the
gap. With r as a process of known covariance (`place`, 5), seen at frames e on both sides with values r_e and noise ν,
the expected r in the gap and its covariance are

    r̂(t) = r̄ + c(t, e) [c(e, e) + (ν² / s²) I]⁻¹ (r_e − r̄),    s² = tr S / 3                       (1)
    C(t) = S (1 − c(t, e) [c(e, e) + (ν² / s²) I]⁻¹ c(e, t)) + ν² I                                (2)

(a Gaussian process). Near the edges the curve joins the samples; deep in a long gap it is the model's. Where nothing
near the marker tells the phase, its variance adds var φ · x' x'ᵀ, x' the slope of (1) of `place` (3). Several
neighbours are averaged with weights 1 / tr C; their errors are much alike, so the covariance is the average too and
not less (4).

Markers that have no seen neighbour in a frame are placed from filled ones, one step away a round, with the covariance
of these added (5): one seen marker suffices for all that hang together with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ....data import AngleModel, KinemarkError
from ....data.array_types import Bools, Floats, Ints
from ....data.method import parameter
from ....signal.learn_angle_model import Learned, learn_model, template_of
from ....signal.phase import CyclePhase, find_phase
from ....signal.segment_directions import directions
from ...marker_array import Gap, MarkerArray, Prediction
from ..stage import FILL, FillMethod
from .connect import connect
from .place import Placer, Placings, correlation

STRANGE = 25.0
"""Mean squared deviation from another trial's model, in its own spreads (at least 0.1), above which the motion is
another; chosen (see studies/missing_markers.py)."""
OTHER_TRIAL = 0.1
"""Least spread of the directions of another trial's model; chosen (see studies/missing_markers.py)."""
HEADINGS = 12
"""Turns about the vertical that are tried with another trial's model; chosen (see studies/missing_markers.py)."""


@dataclass(frozen=True, slots=True)
class LimbAngles(FillMethod):
    """Markers placed along segments whose directions follow a model over the cycle of the motion."""

    together: ClassVar[bool] = True
    slow: ClassVar[bool] = True

    model: AngleModel | None = parameter(
        None, meaning="of another trial or from a file; None: made of the trial itself"
    )
    links: tuple[tuple[str, str], ...] = parameter(
        (), meaning="pairs of markers that are segments (CONNECT); where banks are empty too: found"
    )
    banks: tuple[tuple[str, ...], ...] = parameter(
        (), meaning="groups of markers on one rigid body; where links are empty too: found"
    )
    period: float | None = parameter(None, unit="s", above=0, meaning="of a cycle; None: found")
    shortest_period: float = parameter(0.3, unit="s", above=0, meaning="shortest cycle that is looked for")
    longest_period: float = parameter(6.0, unit="s", above=0, meaning="longest cycle that is looked for")
    edge_samples: int = parameter(
        5, unit="samples", low=0,
        meaning="on each side of a gap from which the error is carried over; 0: the bare model, as in the thesis",
    )  # fmt: skip
    rotate_model: bool = parameter(
        True,
        meaning="another trial's model may be rotated about the vertical to fit, as for a subject who walks back",
    )
    learned: Learned | None = parameter(
        None, meaning="of this trial, to be used in several fills of it; None: made of the trial in each"
    )

    def check_together(self) -> None:
        """Refuse a shortest cycle that is not below the longest."""
        if self.shortest_period >= self.longest_period:
            raise ValueError(
                f"shortest_period is {self.shortest_period} and longest_period {self.longest_period}, "
                "wanted the first below the second"
            )

    def for_many_gaps(self, gaps: Sequence[Gap], source: MarkerArray | None) -> LimbAngles:
        """The same with what it learns from the source."""
        if source is None or self.model or self.learned:
            return self
        return replace(self, learned=learned_of(source, method=self))


@FILL.method("limb_angles", LimbAngles, rank=8, source="Swamidas 1997, 3.5")
def fill_limb_angles(
    motion: MarkerArray, gaps: Sequence[Gap], *, method: LimbAngles = LimbAngles()
) -> list[Prediction]:
    """What the model says of each gap; where the motion has no cycle, or a marker no segment, the reason."""
    if not gaps:
        return []
    try:
        placer = fit_model(motion, method=method)
    except KinemarkError as error:
        return [Prediction.none(gap.length, str(error)) for gap in gaps]
    return _Filling(motion, gaps, placer, method).done()


def fit_model(motion: MarkerArray, *, method: LimbAngles = LimbAngles()) -> Placer:
    """A model, the method's own or made of the trial, with the phase of the trial's frames.

    Raises:
        KinemarkError: no segment, no cycle, or a motion that is not the model's.
        ValueError: links or banks name markers that are not there.
    """
    if method.model is not None:
        model, phase = _of_other_trial(motion, method.model, method.rotate_model)
        return Placer(motion.xyz, model, phase, cycle=_cycle(phase, model.period * motion.rate), own=False)
    learned = method.learned or _learn(motion, method)
    return Placer(motion.xyz, learned.model, learned.phase, cycle=learned.model.period * motion.rate, own=True)


def learned_of(motion: MarkerArray, *, method: LimbAngles) -> Learned | None:
    """The model made of a trial and the phase of its frames; None where none can be made."""
    try:
        return _learn(motion, method)
    except KinemarkError:
        return None


def _learn(motion: MarkerArray, method: LimbAngles) -> Learned:
    segments = connect(motion.xyz, names=motion.names, links=method.links, banks=method.banks)
    return learn_model(
        motion.xyz, rate=motion.rate, names=motion.names, segments=segments,
        period=method.period, shortest=method.shortest_period, longest=method.longest_period,
    )  # fmt: skip


def _cycle(phase: CyclePhase, otherwise: float) -> float:
    """Frames of a cycle of the trial's own."""
    speed = float(phase.cycles[-1] - phase.cycles[0]) / max(len(phase.cycles) - 1, 1)
    return 1 / speed if speed > 0 else otherwise


def _of_other_trial(motion: MarkerArray, model: AngleModel, turn: bool) -> tuple[AngleModel, CyclePhase]:
    """Another trial's model with the markers and lengths of this one, and the phase."""
    place = {name: m for m, name in enumerate(motion.names)}
    use = np.array([all(model.names[m] in place for m in link) for link in model.links])
    if not use.any():
        raise KinemarkError("No segment of the model has both its markers in the trial. Check the names.")
    links = np.array([[place[model.names[m]] for m in link] for link in model.links[use]])
    way = np.linalg.norm(motion.xyz[links[:, 1]] - motion.xyz[links[:, 0]], axis=-1)
    there = ~np.isnan(way)
    length = np.where(there.any(1), np.where(there, way, 0.0).sum(1) / np.maximum(there.sum(1), 1), model.length[use])
    own = AngleModel(
        motion.names, links, model.bank[use], np.maximum(length, 1e-3), model.spread[use],
        model.direction[use], model.cov[use], model.cycles[use], model.period,
    )  # fmt: skip
    y = directions(motion.xyz, links).transpose(1, 0, 2).reshape(motion.xyz.shape[1], -1)
    if len(y) < 2 or np.isnan(y).all():
        raise KinemarkError("No segment of the model is seen in the trial.")
    best: tuple[AngleModel, CyclePhase] | None = None
    for angle in np.arange(HEADINGS) * 360 / HEADINGS if turn else (0.0,):
        turned = own.turned(float(angle))
        phase = _phase(y, turned, motion.rate)
        best = (turned, phase) if best is None or phase.cost < best[1].cost else best
    assert best is not None
    return _checked(*(_upright(y, *best, motion.rate) if turn else best))


def _phase(y: Floats, model: AngleModel, rate: float) -> CyclePhase:
    template, spread = template_of(model)
    return find_phase(y, template, np.maximum(spread, OTHER_TRIAL), cycle=model.period * rate)


def _upright(y: Floats, model: AngleModel, phase: CyclePhase, rate: float) -> tuple[AngleModel, CyclePhase]:
    """The model turned about the vertical by the mean angle that the trial still has to it."""
    template, _ = template_of(model)
    d, u = (a.reshape(len(y), -1, 3) for a in (template(phase.cycles), y))
    cross, dot = d[..., 0] * u[..., 1] - d[..., 1] * u[..., 0], d[..., 0] * u[..., 0] + d[..., 1] * u[..., 1]
    better = model.turned(float(np.degrees(np.arctan2(np.nansum(cross), np.nansum(dot)))))
    again = _phase(y, better, rate)
    return (better, again) if again.cost < phase.cost else (model, phase)


def _checked(model: AngleModel, phase: CyclePhase) -> tuple[AngleModel, CyclePhase]:
    if phase.cost > STRANGE:
        raise KinemarkError(
            f"The motion is not that of the model: its segments are {np.sqrt(phase.cost):.1f} spreads off in the mean."
        )
    return model, phase


class _Filling:
    """Rounds over the gaps: those that have seen neighbours first, then from these."""

    def __init__(self, motion: MarkerArray, gaps: Sequence[Gap], placer: Placer, method: LimbAngles) -> None:
        self._motion, self._gaps, self._placer, self._edges = motion, gaps, placer, method.edge_samples
        self._reach = max(round(placer.cycle / 4), 1)
        self._filled = motion.xyz.copy()
        self._cov: dict[int, list[tuple[Gap, Floats]]] = {}
        self._found = [Prediction.none(gap.length, "") for gap in gaps]
        self._near: dict[int, Placings | None] = {}

    def _placings(self, marker: int) -> Placings | None:
        """Of a marker, in all its gaps and as far beside them as errors are carried over from."""
        if marker not in self._near:
            wanted = np.zeros(self._motion.xyz.shape[1], np.bool_)
            for gap in self._gaps:
                if gap.marker == marker:
                    wanted[max(gap.start - self._reach, 0) : gap.stop + self._reach] = True
            self._near[marker] = self._placer(marker, np.flatnonzero(wanted))
        return self._near[marker]

    def done(self) -> list[Prediction]:
        left = list(range(len(self._gaps)))
        while left:
            made = {g: self._one(self._gaps[g]) for g in left}
            going = [g for g in left if np.isfinite(made[g][0]).sum() > np.isfinite(self._found[g].xyz).sum()]
            if not going:
                break
            for g in going:
                gap, (xyz, cov) = self._gaps[g], made[g]
                self._found[g] = Prediction(xyz, cov)
                self._filled[gap.marker, gap.start : gap.stop] = xyz
                self._cov.setdefault(gap.marker, []).append((gap, np.nan_to_num(cov)))
            left = [g for g in left if np.isnan(self._found[g].xyz).any()]
        return [found if np.isfinite(found.xyz).any() else self._why(g) for g, found in enumerate(self._found)]

    def _why(self, g: int) -> Prediction:
        name = self._motion.names[self._gaps[g].marker]
        near = self._placings(self._gaps[g].marker)
        why = "none of its neighbours is seen or filled in the gap" if near else "it has no segment with a cycle"
        return Prediction.none(self._gaps[g].length, f"{name}: {why}")

    def _one(self, gap: Gap) -> tuple[Floats, Floats]:
        """(L, 3) mm and (L, 3, 3) mm² of a gap by (1) to (5), NaN where no neighbour is known yet."""
        frames, near = np.arange(gap.start, gap.stop), self._placings(gap.marker)
        if near is None:
            return np.full((gap.length, 3), np.nan), np.full((gap.length, 3, 3), np.nan)
        at = slice(*np.searchsorted(near.frames, [gap.start, gap.stop]))
        whole = np.flatnonzero(~np.isnan(self._filled[near.source, gap.start : gap.stop, 0]).any(1))
        xyz, cov = self._from(near, whole if len(whole) else np.arange(len(near.source)), frames, at)
        there = ~np.isnan(xyz[..., 0])
        w = there / np.trace(cov, axis1=2, axis2=3)
        weight = w.sum(0)
        with np.errstate(invalid="ignore", divide="ignore"):  # (4)
            xyz = (w[..., None] * np.where(there[..., None], xyz, 0.0)).sum(0) / weight[:, None]
            cov = (w[..., None, None] * cov).sum(0) / weight[:, None, None]
        slope, variance = near.slope[at], self._placer.phase_variance(frames)
        return xyz, cov + variance[:, None, None] * slope[:, :, None] * slope[:, None, :]  # (3)

    def _from(self, near: Placings, use: Ints, frames: Ints, at: slice) -> tuple[Floats, Floats]:
        """(1), (2) and (5) from K neighbours `use`: (K, L, 3) and (K, L, 3, 3)."""
        mean, share = self._carried(near, use, frames)
        xyz = self._filled[near.source[use], frames[0] : frames[-1] + 1] + near.way[use, at] + mean
        errors = near.errors
        cov = share[..., None, None] * errors.cov[use, None]
        cov += (errors.noise[use] ** 2)[:, None, None, None] * np.eye(3)
        for own, source in zip(cov, near.source[use], strict=True):
            for gap, of_source in self._cov.get(int(source), []):
                both = (frames >= gap.start) & (frames < gap.stop)
                own[both] += of_source[frames[both] - gap.start]
        return xyz, cov

    def _carried(self, near: Placings, use: Ints, frames: Ints) -> tuple[Floats, Floats]:
        """(K, L, 3) r̂ of (1) and (K, L) the share of S in (2)."""
        errors, (columns, known) = near.errors, self._edge(near, use, int(frames[0]), int(frames[-1]))
        mean, tau, edge = errors.mean[use, None], errors.tau[use], near.frames[columns]
        s2 = np.trace(errors.cov[use], axis1=1, axis2=2) / 3
        c_e = correlation(np.subtract.outer(edge, edge), tau) * (known[:, :, None] & known[:, None])
        c_e += np.where(known, (errors.noise[use] ** 2 / s2 + 1e-6)[:, None], 1.0)[..., None] * np.eye(len(edge))
        c_t = correlation(np.subtract.outer(frames, edge), tau) * known[:, None]
        weights = c_t @ np.linalg.inv(c_e)
        carried = weights @ np.where(known[..., None], errors.r[use[:, None], columns] - mean, 0.0)
        return carried + (mean if self._edges else 0.0), np.clip(1 - (weights * c_t).sum(2), 0.0, 1.0)

    def _edge(self, near: Placings, use: Ints, first: int, last: int) -> tuple[Ints, Bools]:
        """Where frames of a marker's placings next to a gap stand from which errors are carried over, and for which of
        the K neighbours (K, E): at which r is known, on each side as many as wanted, within a quarter of a cycle."""
        low, start, stop, high = np.searchsorted(
            near.frames, [first - self._reach, first, last + 1, last + 1 + self._reach]
        )
        before, after = (~np.isnan(near.errors.r[use, a:b, 0]) for a, b in ((low, start), (stop, high)))
        before &= before[:, ::-1].cumsum(1)[:, ::-1] <= self._edges
        after &= after.cumsum(1) <= self._edges
        known = np.concatenate([before, after], 1)
        columns = np.flatnonzero(known.any(0))
        return np.concatenate([np.arange(low, start), np.arange(stop, high)])[columns], known[:, columns]
