"""The component angle model within the tracking loop (Swamidas 1997, 3.5.2 and 4.2.5).

In each frame in which a marker is missing, before any point is matched:

1. every track predicts (`active_tracks`);
2. the phase of the motion is found from the segments that were visible in the last cycles (`signal.phase`), and goes
   on at its own speed while none is; the thesis is given it;
3. the component angles between predicted markers are compared with the model's at that phase (`signal.model_places`);
4. missing markers of which one fails are put where the model has them, seen from those that are visible, and that place
   is fed back into the predictor;
5. the region of acceptance begins anew about a corrected place: it grows from there, and not from the last point.

Then points are matched with the corrected regions; a track that the model has placed takes none outside its own. With
**feedback "position"**, the thesis', the place counts as measured, with the velocity and acceleration that follow from
it and the two positions before, and is thrown about. With **"measured"** it is in every frame a position measured with
the variance of the model, and nothing oscillates.

The box about a corrected place has the half size

    h = n (e + p |v|) + |x̂ − x_m| + 3 √(v_m + x'² v_φ)                                          (1)

n the frames since the correction, x̂ the corrected place and x_m the model's, v_m the variance of the place by the
model's cycles, x' its change with the phase, and v_φ the variance of the phase, which grows while nothing is seen of
it.
"""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...data import AngleModel
from ...data.array_types import Bools, Floats, Ints
from ...signal.kalman import KalmanState, correct, correct_with_differences
from ...signal.learn_angle_model import template_of
from ...signal.model_places import ModelPlaces
from ...signal.phase_filter import PhaseState, begin_phase, predict_phase, update_phase
from ...signal.segment_directions import directions
from .active_tracks import ActiveSwamidasTracks
from .constraints import PredictedPoints, half_size
from .model_matching import match_by_model
from .model_names import tracks_of_model
from .swamidas_method import Swamidas

LEAST = 1e-4
"""Variance of a place at least, mm²; chosen."""
STEP = 0.01
"""Cycles over which the change of a place with the phase is taken; chosen: one of the model's hundred steps."""
SIDES = 3.0
"""Standard deviations of (1): a place in a thousand lies outside; by convention."""


class Corrected(NamedTuple):
    """Tracks with their states corrected, what they expect now, and which of them (T) the model has placed; at (M, 3)
    mm the model's markers that are visible, NaN for the others, and the phase by these."""

    active: ActiveSwamidasTracks
    expected: PredictedPoints
    placed: Bools
    at: Floats
    phase: PhaseState


class AngleGuide:
    """Compares and corrects the predictions of the tracks that are markers of a model.

    Args:
        model: of the motion.
        method: how it is used.
        rate: Hz.
        n_first: frames by which tracks are known for the model's markers.
    """

    def __init__(self, model: AngleModel, method: Swamidas, rate: float, n_first: int) -> None:
        self._model, self._method, self._cycle = model, method, model.period * rate
        self._template, spread = template_of(model)
        self._spread = np.maximum(spread, method.model_spread)
        self._places = ModelPlaces(
            model, phase_tolerance=method.phase_tolerance, segment_tolerance=method.segment_tolerance or None
        )
        n = len(model.names)
        self._first: deque[tuple[Ints, Floats]] = deque(maxlen=n_first)
        self._phase = PhaseState(np.zeros(2), np.zeros((2, 2)))  # until the tracks are known
        self._path, self._since = np.full((n, 2, 3), np.nan), np.zeros(n, np.int64)
        self.track: Ints | None = None

    def missing(self, active: ActiveSwamidasTracks) -> Bools:
        """(T) tracks that are missing markers of the model, for it to place."""
        row = self._rows(active.id)
        mine = np.zeros(len(active.id), bool)
        mine[row[row >= 0]] = True
        return mine & active.going & (active.missed > 0)

    def correct(
        self, active: ActiveSwamidasTracks, expected: PredictedPoints, observed: Floats, error: Floats, sd: float
    ) -> Corrected:
        """Steps 2 to 5 of a frame.

        Args:
            active, expected: T tracks.
            observed: (T, 3) mm the points that visible markers have taken in this frame; NaN for the others.
            error: (3) mm e of (1).
            sd: mm σ of the predictor.
        """
        row = self._rows(active.id)
        known = (row >= 0)[:, None]
        at = np.where(known, observed[row], np.nan)
        seen = ~np.isnan(at[:, 0])
        missing = known[:, 0] & self.missing(active)[row] & ~seen
        visible, phase = at.copy(), self._updated(at)
        at[missing] = expected.xyz[row[missing]]
        place, spread = self._placed(at, seen, phase.phase, phase.variance)
        missing &= ~np.isnan(place[:, 0])
        wrong = missing.copy()
        if self._method.feedback == "position":
            wrong &= self._places.wrong(at, phase.phase)
        self._since[wrong] = 0
        state = self._fed_back(active.state, row, wrong, place, spread, sd) if wrong.any() else active.state
        at[missing] = state.x[row[missing], 0]
        if self._method.feedback == "position":
            at[wrong] = place[wrong]
        half = half_size(self._since + 1, error, active.velocity[row], self._method.velocity_share)
        half += np.abs(at - place) + SIDES * np.sqrt(spread)  # (1)
        placed = np.zeros(len(active.id), bool)
        placed[row[missing]] = True
        expected = _moved(expected, row[missing], at[missing], state.x[row[missing], 1], half[missing])
        return Corrected(replace(active, state=state), expected, placed, visible, phase)

    def match(self, corrected: Corrected, points: Floats, inside: Bools) -> Ints:
        """The point (T), of those that no visible marker has taken (N, 3) mm, of each track; −1 for none.

        Args:
            corrected: of `correct`.
            points: those that are left.
            inside: (T, N) those in the regions of acceptance of tracks that the model has placed.
        """
        row = self._rows(corrected.active.id)
        mine = np.flatnonzero((row >= 0) & corrected.placed[row])  # markers of the model
        own = row[mine]
        before = self._known_segments(corrected.at)

        def cost(taken: Ints) -> float:
            at = corrected.at.copy()
            at[mine] = np.where((taken >= 0)[:, None], points[taken], np.nan)
            return self._cost(corrected.phase, at, self._known_segments(at) & ~before)

        off = np.linalg.norm(points - corrected.expected.xyz[own, None], axis=-1)
        taken = np.full(len(corrected.active.id), -1)
        taken[own] = match_by_model(inside[own], off, cost)
        return taken

    def _known_segments(self, at: Floats) -> Bools:
        """(S) whose ends are both known."""
        return ~np.isnan(at[self._model.links, 0]).any(1)

    def _cost(self, phase: PhaseState, at: Floats, new: Bools) -> float:
        """The first two sums of (1) of `model_matching` for markers at (M, 3) mm that make segments (S) known."""
        if not new.any():
            return 0.0
        y = np.where(np.repeat(new, 3), self._directions(at[:, None])[0], np.nan)
        then = update_phase(phase, y, self._template, self._spread, cycle=self._cycle)
        link, length = self._model.links[new], self._model.length[new]
        stretch = np.linalg.norm(at[link[:, 1]] - at[link[:, 0]], axis=1) - length
        limit = np.maximum(self._model.spread[new], self._method.model_spread * length)
        off, change = (y - self._template(then.x[0])) / self._spread, then.x - phase.x
        return float(np.nansum(off**2) + ((stretch / limit) ** 2).sum() + change @ np.linalg.solve(phase.P, change))

    def advance(self, tracks: Ints, said: Floats, identity: Ints, points: Floats) -> None:
        """Remember a frame: where tracks (T) were said to be (T, 3) mm, and its points (n, 3) mm by identity (n)."""
        if self.track is None:
            self._first.append((identity, points))
            if len(self._first) == self._first.maxlen:
                self._name()
            return
        row = self._rows(tracks)
        now = np.where((row >= 0)[:, None], said[row], np.nan) if len(said) else np.full((len(row), 3), np.nan)
        self._path = np.stack([now, self._path[:, 0]], 1)
        seen = self._seen(identity, points)
        self._since = np.where(np.isnan(seen[:, 0]), self._since + 1, 0)
        self._phase = self._updated(seen)

    def _name(self) -> None:
        """Find the tracks that are the model's markers, by the first frames, and the phase."""
        n_tracks = max((int(identity.max(initial=-1)) for identity, _ in self._first), default=-1) + 1
        paths = np.full((n_tracks, len(self._first), 3), np.nan)
        for f, (identity, points) in enumerate(self._first):
            paths[identity[identity >= 0], f] = points[identity >= 0]
        self.track = tracks_of_model(self._model, paths, cycle=self._cycle, least_spread=self._method.model_spread)
        if self.track is not None:
            own = paths[self.track]
            self._phase = begin_phase(self._directions(own), self._template, self._spread, cycle=self._cycle)
            self._path = own[:, [-1, -2]]

    def _directions(self, own: Floats) -> Floats:
        """(F, 3 S) of markers (M, F, 3)."""
        return directions(own, self._model.links).transpose(1, 0, 2).reshape(own.shape[1], -1)

    def _seen(self, identity: Ints, points: Floats) -> Floats:
        """(M, 3) mm of the model's markers among the points (n, 3) of a frame; NaN where missing."""
        assert self.track is not None
        m, n = np.nonzero(self.track[:, None] == identity)
        seen = np.full((len(self.track), 3), np.nan)
        seen[m] = points[n]
        return seen

    def _rows(self, tracks: Ints) -> Ints:
        """(M) where the model's markers stand among tracks (T); −1 for none."""
        row = np.full(len(self._model.names), -1)
        if self.track is not None:
            m, t = np.nonzero((self.track[:, None] == tracks) & (self.track >= 0)[:, None])
            row[m] = t
        return row

    def _updated(self, at: Floats) -> PhaseState:
        """The phase in the frame that comes, by the markers (M, 3) mm of it that are known; NaN for the others."""
        ahead, y = predict_phase(self._phase, cycle=self._cycle), self._directions(at[:, None])[0]
        return update_phase(ahead, y, self._template, self._spread, cycle=self._cycle)

    def _placed(self, at: Floats, seen: Bools, phase: float, variance: float) -> tuple[Floats, Floats]:
        """Places (M, 3) mm by the model, and the variance (M, 3) mm² of each coordinate as in (1)."""
        place, spread = self._places.place(at, seen, phase)
        later, _ = self._places.place(at, seen, phase + STEP)
        return place, spread[:, None] + ((later - place) / STEP) ** 2 * variance

    def _fed_back(
        self, state: KalmanState, row: Ints, wrong: Bools, place: Floats, spread: Floats, sd: float
    ) -> KalmanState:
        """Step 4, in the frame of the places."""
        x, P, own = state.x.copy(), state.P.copy(), row[wrong]
        before, past = KalmanState(x[own], P[own]), np.concatenate([place[wrong, None], self._path[wrong]], 1)
        if self._method.feedback == "position" and not np.isnan(past).any():
            x[own], P[own] = correct_with_differences(before, past, sd)
        else:
            lasting = max(self._cycle / 10, 1.0)
            x[own], P[own] = correct(before, place[wrong], np.maximum(spread[wrong].mean(1) * lasting, LEAST))
        return KalmanState(x, P)


def _moved(expected: PredictedPoints, own: Ints, at: Floats, velocity: Floats, half: Floats) -> PredictedPoints:
    """Step 5: tracks `own` (n) are expected at (n, 3) mm, with this velocity and a box of this half size (n, 3)."""
    xyz, ways, halves = expected.xyz.copy(), expected.velocity.copy(), expected.half.copy()
    xyz[own], ways[own], halves[own] = at, velocity, half
    return expected._replace(xyz=xyz, velocity=ways, half=halves)
