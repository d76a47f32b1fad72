"""The experiments of Swamidas (1997), re-run on a few phases, still say what the documentation says of them."""

import numpy as np
import pytest

from kinemark.track.swamidas import Constraint, Swamidas, follow_points, track_distance
from support.studies import STUDIES


@pytest.fixture(scope="module")
def studies():
    """The studies as modules: tracking, images, runs."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(STUDIES))
        import swamidas
        import swamidas_images
        import swamidas_runs

        yield swamidas, swamidas_images, swamidas_runs


@pytest.fixture(scope="module")
def outcomes(studies):
    """Some tests of each run from two phases."""
    tracking, _, _ = studies
    return {number: tracking.passes(number, 2, (1, 3, 12)) for number in (1, 2, 3)}


def passed(outcomes):
    return [o.passed for o in outcomes]


def test_with_all_markers_in_sight_the_error_is_zero(studies):
    _, _, runs = studies
    for number in (1, 2, 3):
        run = runs.recorded(number, 0.3)
        cloud, marker = runs.cloud_of(run.xyz, np.ones((3, 120), bool), 30.0)
        followed = follow_points(cloud)
        np.testing.assert_array_equal(followed.tracks.id, marker)
        np.testing.assert_array_equal(followed.path(1), run.xyz[1, :120])


def test_gaps_stand_where_the_tables_have_them(studies):
    _, _, runs = studies
    one, two = runs.visible(20, 1), runs.visible(20, 2)
    assert [np.flatnonzero(~row)[[0, -1]].tolist() for row in one] == [[10, 29], [80, 99], [150, 169]]
    hidden = [sorted(set((np.flatnonzero(~row) // 10 * 10).tolist())) for row in two]
    assert hidden == [[10, 20, 150, 160], [10, 20, 80, 90], [80, 90, 150, 160]]
    assert [runs.gap_frames(test) for test in (1, 6, 7, 12)] == [10, 60, 10, 60]


def test_slow_motion_passes_and_close_markers_fail_over_long_gaps(outcomes):
    assert all(passed(outcomes[1][1] + outcomes[1][3]))
    assert all(passed(outcomes[2][1] + outcomes[2][3]))
    assert not any(passed(outcomes[3][12]))
    assert sum(passed(outcomes[2][12])) <= 1
    by = [by for tests in outcomes.values() for some in tests.values() for o in some for by in o.by]
    assert {Constraint.REGION, Constraint.DISTANCE, Constraint.VELOCITY} <= set(by)


def test_errors_of_prediction_are_those_of_the_tables_in_square_feet(studies, outcomes):
    tracking, _, _ = studies
    published = {test: np.array(tracking.SQUARED[1, test])[:, :2] for test in (1, 3)}
    for test, low, high in ((1, 0.0, 0.01), (3, 0.02, 1.5)):
        found = np.mean([o.squared for o in outcomes[1][test]], axis=0)[:2, :2] / tracking.FOOT**2
        assert low <= found.mean() <= high
        assert low <= published[test][:2].mean() <= high
    off = np.array([o.off for o in outcomes[1][12]]) / tracking.FOOT
    assert 3 < np.abs(off).max(1).min() <= np.abs(off).max() < 12  # published: five feet


def test_the_segments_lengths_help_with_two_markers_missing(studies, outcomes):
    tracking, _, _ = studies
    better = tracking.passes(2, 2, (12,), method=Swamidas(segment_tolerance=0.05))
    assert sum(passed(better[12])) > sum(passed(outcomes[2][12]))


def test_the_distance_alone_fails_soonest_with_close_markers(studies):
    tracking, _, runs = studies
    one, two = ([tracking.gap_at_failure(run, k, longest=25) for run in tracking.runs(3, 2)] for k in (1, 2))
    assert max(two) <= 9
    assert max(one) <= 25
    slow = tracking.runs(1, 2)[0]
    cloud, marker = runs.cloud_of(slow.xyz, runs.visible(18, 1), 30.0)
    np.testing.assert_array_equal(track_distance(cloud).id, marker)
    assert tracking.gap_at_failure(slow, 2, longest=max(two)) == max(two) + 1


def test_matching_fails_with_noise_and_first_where_markers_are_close(studies):
    _, images, _ = studies
    rig = images.cameras()
    table = images.matching(rig, images.FOCAL, rounds=1)
    assert [table[0, n] for n in (1, 2, 3)] == [0, 0, 0]
    assert table[5, 1] == 0
    assert 3 < table[10, 3] < 30
    assert [15 < table[20, n] < 50 for n in (1, 2, 3)] == [True] * 3
    assert table[20, 3] == max(table.values())
    assert max(images.matching(rig, 1.0, rounds=1).values()) == 0


def test_the_error_of_reconstruction_goes_with_the_noise(studies):
    _, images, _ = studies
    table = images.reconstruction(images.cameras(), 1.0)
    for number in (1, 2, 3):
        assert table[0, number].max() < 1e-6
        assert 0.04 < table[20, number].min() <= table[20, number].max() < 0.08
        assert table[20, number].mean() / table[5, number].mean() == pytest.approx(0.035 / 0.005, rel=0.1)


def test_missing_images_are_left_out_and_extra_ones_harm_only_near_the_line(studies):
    _, images, runs = studies
    rig = images.cameras()
    run = runs.recorded(2, 0.0, duration_s=4.0)
    assert images.hidden(rig, images.images(rig, run)) == (0.0, 2.0)
    wrong, nearer = images.extra(rig, images.images(rig, run, (0.5, 0.5)))
    assert nearer <= wrong < 2.0
    exact, none = images.extra(rig, images.images(rig, run))
    assert exact == none == 0.0
