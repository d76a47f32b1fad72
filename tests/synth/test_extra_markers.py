"""More markers on a body, and more bodies."""

import numpy as np
import pytest

from kinemark.synth import combined_subjects, observe, ring, stationary, walking, with_markers

WALK = walking(duration_s=0.4, rate=50.0)


def test_added_markers_sit_on_limbs_and_keep_apart():
    many = with_markers(WALK, 60, apart_mm=45.0, seed=2)
    assert len(many) == 60 and len(set(many.names)) == 60
    np.testing.assert_array_equal(many.xyz[: len(WALK)], WALK.xyz)
    new = many.xyz[len(WALK) :]
    apart = np.linalg.norm(many.xyz[:, None] - new, axis=-1)
    apart[np.arange(len(WALK), 60), np.arange(len(new))] = np.inf
    assert apart.min() >= 45.0
    limbs = WALK.capsules
    axis = limbs.b - limbs.a
    share = ((new[:, None] - limbs.a) * axis).sum(-1) / (axis**2).sum(-1)
    off = np.linalg.norm(new[:, None] - limbs.a - np.clip(share, 0, 1)[..., None] * axis, axis=-1)
    size = float(np.median(WALK.radius_mm))
    assert np.isclose(off, limbs.radius[:, None] + size, atol=1e-6).all(-1).any(1).all()


def test_added_markers_move_as_smoothly_as_the_limbs():
    many = with_markers(walking(duration_s=1.0, rate=200.0), 80, seed=1)
    own = np.linalg.norm(np.diff(many.xyz[:15], 2, axis=1), axis=-1).max()
    new = np.linalg.norm(np.diff(many.xyz[15:], 2, axis=1), axis=-1).max()
    assert new < 2 * own


def test_fewer_are_the_first_and_too_many_are_refused():
    assert with_markers(WALK, 5).names == WALK.names[:5]
    with pytest.raises(ValueError, match="do not fit"):
        with_markers(WALK, 20, apart_mm=2000.0)
    with pytest.raises(ValueError, match="no limbs"):
        with_markers(stationary(("a",), [[0, 0, 0]], radius_mm=7.0), 2)


def test_two_people_hide_each_others_markers():
    other = walking(duration_s=0.4, rate=50.0, middle=(1200.0, 1000.0), phase=0.2)
    both = combined_subjects(WALK, other)
    assert len(both) == len(WALK) + len(other) and both["2 " + other.names[3]] == pytest.approx(other.xyz[3])
    assert len(both.capsules) == len(WALK.capsules) + len(other.capsules)
    joined = [(both.names[a], both.names[b]) for a, b in both.links]
    assert all(a.split()[0] == b.split()[0] for a, b in joined) and len(joined) == len(WALK.links) + len(other.links)
    rig = ring(6)
    alone = observe(rig, WALK).sight.visible
    assert (observe(rig, both).sight.visible[:, : len(WALK)] <= alone + 1e-9).all()
    assert (observe(rig, both).sight.visible[:, : len(WALK)] < alone - 0.5).any()
    with pytest.raises(ValueError, match="differ in rate"):
        combined_subjects(WALK, walking(duration_s=0.4, rate=100.0))


def test_unmerged_views_count_the_images_of_one_marker_alone():
    rig = ring(6)
    seen = observe(rig, WALK, merge_px=15.0)
    assert (seen.unmerged_views <= 6).all()
    whole = observe(rig, WALK)
    np.testing.assert_array_equal(whole.unmerged_views, (whole.sight.visible >= 0.5).sum(0))
    assert (seen.unmerged_views <= whole.unmerged_views).all() and (seen.unmerged_views < whole.unmerged_views).any()


@pytest.mark.parametrize("seed", [102, 106, 107])
def test_a_name_is_that_of_one_place_in_every_walk(seed):
    """A place that was refused in one of two walks had moved the names of all after it up by one."""
    slow, fast = (
        with_markers(
            walking(duration_s=2.0, rate=100.0, seed=s, wobble_mm=3.0, marker_radius_mm=7.0, speed_mm_s=v, phase=p),
            53,
            seed=seed,
        )
        for s, v, p in ((seed, 800.0, 0.8), (seed + 50, 700.0, 0.3))
    )
    both = [name for name in slow.names if name in fast.names]
    assert len(both) < 53 == len(slow) == len(fast)
    far = []
    for walk in (slow, fast):
        xyz = walk.xyz[[walk.names.index(name) for name in both]]
        far.append(np.linalg.norm(xyz[:, None] - xyz[None], axis=-1).mean(2))
    near = np.sort(np.abs(far[0] - far[1]), axis=1)[:, 5]
    assert near.max() < 15.0
