"""A simulated subject who wears a marker set: segments that turn about the set's joints, as its figure stands."""

import numpy as np
import scipy

from kinemark.data import MarkerTrajectory, Trajectories

MAIN, OTHER = 25.0, 8.0
"""Amplitude of a joint's turn about the axis from side to side, and about the two others, deg."""
MISPLACED = 0.012
"""Standard deviation of a marker's place on another subject, share of the height on each axis."""


def body_of(marker_set, seed, *, height=1700.0, misplaced=MISPLACED):
    """Places (3) mm of markers and joints of one subject: the figure's, moved by chance; sides differ."""
    rng = np.random.default_rng(seed)
    return {
        name: height * (np.array(place) + misplaced * rng.normal(size=3) * (name in marker_set.names))
        for name, place in marker_set.places.items()
    }


def standing(marker_set, body, *, n_frames=20, noise=0.3, seed=0):
    """A static trial."""
    return _trial(marker_set, {n: np.tile(body[n], (n_frames, 1)) for n in marker_set.names}, noise, seed)


def moving(marker_set, body, seed, *, duration_s=3.0, rate=100.0, noise=0.3, wobble=2.0):
    """All joints turn, and the root walks; markers of the static trial are off."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(duration_s * rate)) / rate
    turns = {root(marker_set): (_swings(rng, t, OTHER, OTHER), np.outer(t, [1100.0, 0.0, 0.0]))}
    waiting = dict(marker_set.joints)
    while ready := [j for j, (a, b) in waiting.items() if (a in turns) != (b in turns)]:
        a, b = waiting.pop(ready[0])
        parent, child = (a, b) if a in turns else (b, a)
        R, x = turns[parent]
        own = R @ _swings(rng, t, MAIN, OTHER)
        turns[child] = own, x + (R - own) @ body[ready[0]]
    paths = {}
    for name in marker_set.moving:
        R, x = turns[_segment(marker_set, name, turns)]
        paths[name] = R @ body[name] + x
    path = {n: xyz + wobble * _smooth(rng, len(t)) for n, xyz in paths.items()}
    return _trial(marker_set, path, noise, seed)


def root(marker_set):
    """The segment from which the others hang."""
    first = next(iter(marker_set.segments))
    return next((name for name in ("pelvis", "thorax", "trunk") if name in marker_set.segments), first)


def _segment(marker_set, name, turns):
    """The first segment, from the root outwards, that a marker is on; the root for one that is on none."""
    return next((s for s in turns if name in marker_set.segments[s]), next(iter(turns)))


def _swings(rng, t, main, other):
    """(F, 3, 3) turns."""
    rates, phases = rng.uniform(0.6, 1.2, 3), rng.uniform(0, 2 * np.pi, 3)
    angle = np.sin(2 * np.pi * np.outer(t, rates) + phases) - np.sin(phases)
    return scipy.spatial.transform.Rotation.from_euler("yxz", angle * [main, other, other], degrees=True).as_matrix()


def _smooth(rng, n):
    """(n, 3) of unit standard deviation, as skin."""
    raw = scipy.ndimage.gaussian_filter1d(rng.normal(size=(n, 3)), 6.0, axis=0)
    return raw / raw.std()


def _trial(marker_set, paths, noise, seed):
    rng = np.random.default_rng(seed)
    tracks = (MarkerTrajectory.measured(n, xyz + noise * rng.normal(size=xyz.shape)) for n, xyz in paths.items())
    return Trajectories(tuple(tracks), 100.0)
