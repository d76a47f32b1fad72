"""With the angle model in the tracking loop the thesis' tests pass that the predictor alone fails."""

import pytest
import swamidas_model as study


@pytest.mark.parametrize("way", ["position", "measured"])
def test_two_close_markers_hidden_for_two_seconds_are_found_again_by_the_model(way):
    assert not study.passed(3, 12, 0.5, "none")
    assert study.passed(3, 12, 0.5, way)


def test_the_model_of_the_trial_itself_finds_a_marker_hidden_for_two_seconds():
    assert study.passed(3, 6, 0.25, "own")


def test_with_a_model_both_directions_meet_where_the_predictor_alone_fails():
    """Also where the two markers cross in the middle of their gap (run 3, test 11)."""
    assert not study.passed(3, 9, 0.5, "none, meet")
    assert study.passed(3, 9, 0.5, "meeting") and study.passed(3, 11, 0.5, "meeting")


def test_a_trial_with_too_little_left_to_learn_from_says_so():
    assert study.passed(1, 12, 0.0, "own") is None
