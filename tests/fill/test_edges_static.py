"""Bad samples beside gaps are trimmed and good ones are not; lost markers are placed from a static trial."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.data import Origin
from kinemark.fill import Auto, Gap, MarkerArray, StaticShape, fill
from kinemark.fill.edges import GapEdges, trim_edges
from kinemark.fill.static import FromStatic, place_absent
from kinemark.io.c3d.to_trial import read_c3d
from support.filling import swaying
from support.shared import shared_data
from support.walked import clean, spiked, without

GAIT = "mocap3d/qualisys_gait/Gait - CGM2 1.c3d"
STATIC = "mocap3d/qualisys_gait/Static - CGM2 1.c3d"


def read(path):
    return MarkerArray.of(read_c3d(shared_data(path)).trajectories)


def with_bad_edge(motion, gap, n, size, side, rng):
    x = motion.xyz.copy()
    frames = range(gap.start - n, gap.start) if side == "before" else range(gap.stop, gap.stop + n)
    x[gap.marker, list(frames)] += size * (v := rng.normal(size=3)) / np.linalg.norm(v)
    return motion._replace(xyz=x).hidden([gap])


@pytest.mark.parametrize("side", ["before", "after"])
@pytest.mark.parametrize("n", [1, 2, 4])
def test_bad_samples_are_found_and_only_these(side, n):
    motion, _ = swaying()
    rng, hits = np.random.default_rng(n), 0
    for start in range(60, 500, 20):
        gap = Gap(int(rng.integers(5)), start, start + 25)
        t = trim_edges(with_bad_edge(motion, gap, n, 6.0, side, rng), [gap])
        own, other = (t.before, t.after) if side == "before" else (t.after, t.before)
        hits += own[0] == n and other[0] <= 5
        assert t.gaps[0] == Gap(gap.marker, gap.start - t.before[0], gap.stop + t.after[0])
        assert np.isnan(t.motion.xyz[gap.marker, t.gaps[0].start : t.gaps[0].stop]).all()
        assert not np.isnan(t.motion.xyz[gap.marker, [t.gaps[0].start - 1, t.gaps[0].stop]]).any()
    assert hits >= 20  # of 22


def test_bad_samples_are_found_under_white_noise():
    """A parabola makes much of it: with five times the usual error half of these were not seen."""
    motion, _ = swaying()
    rng, hits = np.random.default_rng(7), 0
    noisy = motion._replace(xyz=motion.xyz + rng.normal(0, 1.0, motion.xyz.shape))
    for start in range(60, 500, 20):
        gap = Gap(int(rng.integers(5)), start, start + 25)
        hits += trim_edges(with_bad_edge(noisy, gap, 2, 16.0, "before", rng), [gap]).before[0] > 0
    assert hits >= 19  # of 22


def test_good_edges_stay():
    """A few in a hundred at most, over all markers and many places of a real walk."""
    motion = read(GAIT)
    trimmed = tried = 0
    for start in range(30, 280, 50):
        gaps = [Gap(k, start, start + 15) for k in np.flatnonzero(motion.seen.all(1))]
        for gap in gaps[::3]:
            t = trim_edges(motion.hidden([gap]), [gap])
            trimmed, tried = trimmed + (t.before[0] > 0) + (t.after[0] > 0), tried + 2
    assert tried > 100 and trimmed <= 0.04 * tried


def test_a_stroke_in_which_the_marker_always_vanishes_is_no_error():
    """All markers are thrown aside and back beside the gap, as nowhere else in the trial."""
    motion, _ = swaying()
    frames, gap = np.arange(600), Gap(1, 290, 305)
    stroke = 300.0 * np.exp(-(((frames - 306) / 3.0) ** 2))[:, None] * np.array([0.3, 0.9, -0.3])
    t = trim_edges(motion._replace(xyz=motion.xyz + stroke).hidden([gap]), [gap], method=GapEdges(neighbours=3))
    assert t.before[0] == t.after[0] == 0
    alone = motion.xyz.copy()
    alone[1] += stroke
    t = trim_edges(motion._replace(xyz=alone).hidden([gap]), [gap], method=GapEdges(neighbours=3))
    assert t.after[0] > 0  # where its neighbours stay calm it is one


def test_a_gross_edge_of_a_real_walk_is_found():
    motion, rng = read(GAIT), np.random.default_rng(2)
    gaps = [Gap(int(k), 150, 170) for k in np.flatnonzero(motion.seen.all(1))[::2]]
    found = [trim_edges(with_bad_edge(motion, g, 2, 25.0, "before", rng), [g]).before[0] for g in gaps]
    assert np.mean(np.array(found) == 2) > 0.85


def test_a_trial_that_shows_too_little_is_left_alone():
    motion, _ = swaying(frames=40)
    for m in (motion, MarkerArray(motion.xyz[:1], 100.0, ("M0",)), motion._replace(xyz=np.full((5, 40, 3), np.nan))):
        t = trim_edges(m.hidden([Gap(0, 15, 25)]), [Gap(0, 15, 25)])
        assert not t.before.any() and not t.after.any()
    for method in (GapEdges(most_trimmed=0), GapEdges(neighbours=0)):
        assert trim_edges(motion, [Gap(0, 0, 40), Gap(1, 10, 11)], method=method).before.shape == (2,)
    with pytest.raises(ValueError, match="fit_samples"):
        GapEdges(fit_samples=3)


def absent(motion, k):
    x = motion.xyz.copy()
    x[k] = np.nan
    return motion._replace(xyz=x)


def test_a_marker_of_a_rigid_body_is_placed_exactly():
    motion, shape = swaying(noise=0.0)
    static = StaticShape(motion.names, shape @ Rotation.from_rotvec([1, 2, 3]).as_matrix().T + 500, np.zeros(5))
    (placed,) = place_absent(absent(motion, 2), static)
    assert placed.name == "M2" and not placed.reason and len(placed.references) >= 3
    assert np.abs(placed.xyz - motion.xyz[2]).max() < 1e-6 and placed.expected_mm < 1e-3
    without = MarkerArray(motion.xyz[[0, 1, 3, 4]], 100.0, ("M0", "M1", "M3", "M4"))  # not in the file at all
    assert np.allclose(place_absent(without, static)[0].xyz, placed.xyz)


def test_the_expected_error_is_as_large_as_the_error():
    """Over many bodies that bend: within a factor of about two on average, and larger where more bends."""
    ratio, levels = [], []
    for bend in (1.0, 4.0, 12.0):
        expected = []
        for seed in range(12):
            motion, shape = swaying(bend=bend, seed=seed)
            placed = place_absent(absent(motion, 0), StaticShape(motion.names, shape, np.zeros(5)))[0]
            error = np.linalg.norm(placed.xyz - motion.xyz[0], axis=1).mean()
            ratio.append(error / placed.expected_mm)
            expected.append(placed.expected_mm)
        levels.append(np.median(expected))
    assert 0.4 < np.median(ratio) < 1.6
    assert levels[0] < levels[1] < levels[2]


def test_a_real_walk_without_a_marker_of_its_static_trial():
    motion, static = read(GAIT), StaticShape.of(read(STATIC))
    both = [k for k in np.flatnonzero(motion.seen.all(1)) if motion.names[k] in static.names][::9]
    error, expected = [], []
    for k in both:
        placed = next(p for p in place_absent(absent(motion, k), static) if p.name == motion.names[k])
        error.append(np.linalg.norm(placed.xyz - motion.xyz[k], axis=1).mean())
        expected.append(placed.expected_mm)
    assert np.median(error) < 20
    assert 0.2 < np.median(np.array(error) / expected) < 1.5
    assert np.corrcoef(np.argsort(np.argsort(error)), np.argsort(np.argsort(expected)))[0, 1] > 0.3


def test_what_cannot_be_placed_says_why():
    motion, shape = swaying()
    static = StaticShape(motion.names, shape, np.zeros(5))
    few = MarkerArray(motion.xyz[:2], 100.0, motion.names[:2])
    for placed in place_absent(few, static):
        assert placed.reason and np.isnan(placed.xyz).all() and np.isnan(placed.expected_mm)
    line = static._replace(xyz=np.arange(5)[:, None] * np.array([50.0, 0, 0]))
    assert place_absent(absent(motion, 0), line)[0].reason
    assert place_absent(motion._replace(xyz=np.nan * motion.xyz), static)[0].reason
    assert place_absent(motion, static) == []
    with pytest.raises(ValueError, match="M7"):
        place_absent(motion, static, method=FromStatic(reference_markers=("M0", "M1", "M7")))
    named = place_absent(absent(motion, 0), static, method=FromStatic(reference_markers=("M1", "M2", "M4")))[0]
    assert set(named.references) == {"M1", "M2", "M4"}


def test_frames_without_the_reference_markers_stay_empty():
    motion, shape = swaying()
    hidden = absent(motion, 0).hidden([Gap(k, 50, 80) for k in range(1, 5)])
    placed = place_absent(hidden, StaticShape(motion.names, shape, np.zeros(5)))[0]
    assert np.isnan(placed.xyz[50:80]).all() and not np.isnan(placed.xyz[:50]).any()
    assert (np.isnan(placed.cov[:, 0, 0]) == np.isnan(placed.xyz[:, 0])).all()


def test_a_static_trial_gives_the_middle_of_each_marker():
    motion, _ = swaying()
    still = motion._replace(xyz=motion.xyz[:, :1] + np.random.default_rng(0).normal(0, 0.5, (5, 300, 3)))
    shape = StaticShape.of(absent(still, 3))
    assert shape.names == ("M0", "M1", "M2", "M4")
    assert np.allclose(shape.xyz, motion.xyz[[0, 1, 2, 4], 0], atol=0.2)
    assert np.allclose(shape.sd, 0.5 * 3**0.5, rtol=0.1)
    assert StaticShape.of(motion._replace(xyz=np.nan * motion.xyz)).names == ()


def test_no_measured_sample_is_replaced_unasked():
    """By default 88 samples of four files were, up to 36 mm; `trim` asks for it."""
    given = without(spiked(clean().frames(0, 250), 5, 149, 150, mm=35.0), 5, 150, 171)
    quick = Auto(candidates=("linear", "rigid_body"))
    replaced = {}
    for trim in (0, 5):
        filled = fill(given, method=quick, limit_mm=np.inf, **({"trim": trim} if trim else {}))
        measured = [(old.origin == Origin.MEASURED) for old in given]
        pairs = zip(given, filled.trajectories, measured, strict=True)
        replaced[trim] = sum(int((old.xyz[at] != new.xyz[at]).any(1).sum()) for old, new, at in pairs)
        assert (149 in filled.gaps[0].trimmed, 149 in filled.gaps[0].suspicious) == (trim > 0, trim == 0)
    assert replaced[0] == 0 < replaced[5]
