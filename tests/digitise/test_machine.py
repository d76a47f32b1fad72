"""The state machine of digitising: what a click means, what is found, what is asked, and what is saved."""

import numpy as np
import pytest

from kinemark.data import KinemarkError, same
from kinemark.detect import Centroids
from kinemark.digitise import (
    Absent,
    Accept,
    ByHand,
    DigitisingPhase,
    Given,
    MarkerStatus,
    No,
    Point,
    Replay,
    Revisit,
    SemiAutomatic,
    Undo,
    Verify,
    Yes,
    advance,
    answer_text,
    begin,
    clicked,
    drive,
    find_markers,
    given,
    parse_answer,
    question_of,
    result,
    words,
)
from support.pointing import RADIUS, Shown, U, V, film, image, method, run, straight, third_frame

# ---- Pointing ----


def test_any_white_pixel_means_its_marker():
    image_markers = find_markers(image([(40, 40), (47, 46), (100, 80)]))
    assert len(image_markers.uv) == 3
    for k, place in enumerate(image_markers.uv):
        for v, u in np.argwhere(image_markers.owner == k):
            assert clicked(image_markers, np.array([u, v])) == k
            assert np.hypot(*(place - (u, v))) < RADIUS + 2
    assert (image_markers.owner >= 0).sum() == (image([(40, 40), (47, 46), (100, 80)]) > 60).sum()


def test_touching_markers_share_their_pixels_by_the_nearest_centre():
    disc = np.minimum(np.hypot(U - 40, V - 60), np.hypot(U - 54, V - 60)) - 8
    image_markers = find_markers((10 + 210 * np.clip(0.5 - disc, 0, 1)).astype(np.uint8))
    assert len(image_markers.uv) == 2
    left = clicked(image_markers, np.array([34, 60]))
    assert image_markers.uv[left, 0] == pytest.approx(40, abs=0.2)
    for v, u in np.argwhere(image_markers.owner >= 0):
        assert (clicked(image_markers, np.array([u, v])) == left) == (u < 47) or u == 47


@pytest.mark.parametrize("place", [(5, 5), (43.0, 44.5), (-3, 10), (200, 50), (np.nan, 3)])
def test_pointing_at_nothing_is_refused(place):
    with pytest.raises(KinemarkError, match=r"no white pixel|outside the image"):
        clicked(find_markers(image([(40, 40)])), np.array(place))


def test_dark_markers_on_white():
    plain, dark = (
        find_markers(image([(40, 40)])),
        find_markers(255 - image([(40, 40)]), method=Centroids(195, inverted=True)),
    )
    np.testing.assert_allclose(plain.uv, dark.uv, atol=1e-9)
    assert ((plain.owner >= 0) == (dark.owner >= 0)).all()


# ---- Following ----


def test_what_moves_in_a_straight_line_is_asked_for_in_the_first_two_frames_only():
    paths = straight(20)
    done, operator = run(paths, method(2))
    assert operator.pointed() == [(0, 0), (0, 1), (1, 0), (1, 1)]
    np.testing.assert_allclose(done.uv, paths, atol=0.02)
    assert done.figures["questions"] == 4 and done.figures["questions_by_reason"]["not_found"] == 0
    assert (done.found[:, 2:] == MarkerStatus.AUTOMATIC).all() and (done.found[:, :2] == MarkerStatus.POINTED).all()


@pytest.mark.parametrize(
    ("jump", "asked"), [(2, False), (14, False), (25 + RADIUS, False), (26 + RADIUS, True), (60, True)]
)
def test_the_search_reaches_half_of_fifty_pixels(jump, asked):
    """Its square ends 25 px from the middle, and the marker's own radius, 4 px, comes to help."""
    paths = straight(4, start=((60.0, 60.0),), speed=((0.0, 0.0),))
    paths[0, 3, 0] += jump
    _, operator = run(paths, method(1))
    assert ((3, 0) in operator.pointed()) == asked


def test_fewer_expansions_reach_less_far():
    paths = straight(4, start=((60.0, 60.0),), speed=((0.0, 0.0),))
    paths[0, 3, 0] += 14
    assert (3, 0) in run(paths, method(1, expansions=2))[1].pointed()
    assert (3, 0) not in run(paths, method(1, expansions=5))[1].pointed()


def test_a_hidden_marker_does_not_take_its_neighbours_image():
    paths = straight(12, start=((40.0, 40.0), (52.0, 40.0)), speed=((2.0, 0.0), (2.0, 0.0)))
    paths[0, 6:9] = np.nan
    done, operator = run(paths, method(2))
    later = [(f, m) for f, m in operator.pointed() if f >= 2]
    assert later == [(6, 0), (7, 0), (8, 0), (9, 0), (10, 0)]  # hidden, and until it was seen in two frames again
    np.testing.assert_allclose(done.uv, paths, atol=0.02)
    assert (done.found[0, 6:9] == MarkerStatus.NOT_PRESENT).all()


def test_a_longer_memory_asks_less_after_a_gap():
    paths = straight(12, start=((40.0, 40.0), (52.0, 40.0)), speed=((2.0, 0.0), (2.0, 0.0)))
    paths[0, 6:8] = np.nan
    done, operator = run(paths, method(2, history=4))
    assert [q for q in operator.pointed() if q[0] >= 2] == [(6, 0), (7, 0)]
    np.testing.assert_allclose(done.uv, paths, atol=0.02)


def test_two_markers_that_meet_do_not_serve_as_one_and_part_as_they_were():
    paths = straight(14, start=((40.0, 40.0), (80.0, 43.0)), speed=((3.0, 0.0), (-3.0, 0.0)))
    done, operator = run(paths, method(2))
    same_image = np.abs(done.seen[0] - done.seen[1]).max(-1) < 1e-6
    assert same_image.any()  # they do run together
    asked = {f for f, _ in operator.pointed()}
    assert set(np.flatnonzero(same_image)) <= asked
    np.testing.assert_allclose(done.uv[:, -3:], paths[:, -3:], atol=0.02)


# ---- The reference marker ----


def shifted(paths, seed=0, most=3):
    """With a reference marker that stands still, and all moved by a shift in each frame but the first."""
    shift = np.random.default_rng(seed).integers(-most, most + 1, (paths.shape[1], 2)).astype(float)
    shift[0] = 0
    fixed = np.broadcast_to([20.0, 100.0], (1, paths.shape[1], 2))
    return np.concatenate([paths, fixed]) + shift, shift


def test_the_shift_of_the_images_is_undone():
    true = straight(15)
    paths, shift = shifted(true)
    done, operator = run(paths, method(3, reference="m3"))
    assert max(f for f, _ in operator.pointed()) == 1
    np.testing.assert_allclose(done.shift, shift, atol=0.02)
    np.testing.assert_allclose(done.uv[:2], true, atol=0.03)
    np.testing.assert_allclose(done.uv[2], paths[2], atol=0.02)  # it is kept as it was seen


def test_the_place_at_the_calibration_counts_where_it_is_given():
    paths, _ = shifted(straight(6), most=0)
    done, _ = run(paths, method(3, reference="m3"), constant=np.array([18.0, 101.0]))
    np.testing.assert_allclose(done.uv[:2], paths[:2] - (2, -1), atol=0.02)


def test_a_reference_marker_that_is_covered_is_asked_for_and_its_last_shift_stands():
    paths, shift = shifted(straight(10))
    paths[2, 5] = np.nan
    done, operator = run(paths, method(3, reference="m3"))
    assert [q for q in operator.pointed() if q[0] >= 2] == [(5, 2)]
    assert done.figures["questions_by_reason"]["reference"] == 1
    np.testing.assert_allclose(done.shift[5], shift[4], atol=0.02)


def test_the_reference_marker_is_confirmed_where_that_is_wanted():
    paths, _ = shifted(straight(5))
    m = method(3, reference="m3", confirm_reference=True)
    done, operator = run(paths, m)
    assert [q.frame for q in operator.asked if q.phase is DigitisingPhase.REFERENCE] == [2, 3, 4]
    assert done.figures["questions_by_reason"] == {
        "first_two_frames": 6,
        "not_found": 0,
        "ambiguous": 0,
        "reference": 3,
    }


def test_a_refused_reference_marker_is_pointed_at_and_asked_about_again():
    paths, shift = shifted(straight(4))
    m, images = method(3, reference="m3", confirm_reference=True), film(paths)
    state = third_frame(paths, m, images)
    assert state.phase is DigitisingPhase.REFERENCE
    state = advance(state, No(), images, method=m)
    assert (state.phase, state.marker) == (DigitisingPhase.POINT, 2)
    for wrong in paths[:2, 2]:  # pointed at another marker, which the next question shows
        state = advance(state, Point(*np.rint(wrong)), images, method=m)
        assert (state.phase, question_of(state, method=m).name) == (DigitisingPhase.REFERENCE, "m3")
        np.testing.assert_allclose(question_of(state, method=m).uv, wrong, atol=0.02)
        state = advance(state, No(), images, method=m)
        assert (state.phase, state.marker) == (DigitisingPhase.POINT, 2)
    state = advance(state, Point(*np.rint(paths[2, 2])), images, method=m)
    assert state.phase is DigitisingPhase.REFERENCE and (state.draft.found[:2] == MarkerStatus.OPEN).all()
    state = advance(state, Yes(), images, method=m)
    assert state.phase is DigitisingPhase.REVIEW
    np.testing.assert_allclose(state.draft.shift, shift[2], atol=0.02)


def test_a_reference_marker_that_is_not_present_is_not_asked_about_again():
    paths, shift = shifted(straight(4))
    m, images = method(3, reference="m3", confirm_reference=True), film(paths)
    state = third_frame(paths, m, images)
    state = advance(advance(state, No(), images, method=m), Absent(), images, method=m)
    assert state.phase is DigitisingPhase.REVIEW
    np.testing.assert_allclose(state.draft.shift, shift[1], atol=0.02)


def test_what_is_said_after_the_last_frame_is_gone_through_again():
    """A frame is looked at again when all are saved; the same answers lead there by themselves."""
    paths, m, said = straight(3), method(2), []
    saying = [Revisit(1), Verify(), No(), Point(50.0, 51.0), Yes(), Accept(), Undo(), Accept()]

    def operator(question, state):
        return Shown(paths)(question, state) if None in state.saved else saying.pop(0)

    state = drive(
        operator, film(paths), n_frames=3, method=m, reopened=lambda question: bool(saying),
        on_answer=lambda question, answer: said.append(given(question, answer)),
    )  # fmt: skip
    np.testing.assert_array_equal(state.saved[1].uv[0], [50.0, 51.0])
    replay = Replay(said)
    again = drive(replay, film(paths), n_frames=3, method=m, reopened=replay.goes_on)
    assert replay.unused == 0
    for one, other in zip(state.saved, again.saved, strict=True):
        assert same(one, other)


# ---- Saving, going back ----


def second_frame(paths, m):
    """The state in which the second frame is being digitised, after the first was saved."""
    images = film(paths)
    state = begin(paths.shape[1], images, method=m)
    for place in paths[:, 0]:
        state = advance(state, Point(*place), images, method=m)
    assert state.saved[0] is None and state.phase is DigitisingPhase.REVIEW  # all is known and nothing saved
    return advance(state, Accept(), images, method=m), images


def test_nothing_is_saved_before_it_is_accepted():
    m = method(2)
    state, images = second_frame(straight(5), m)
    assert state.saved[0] is not None and state.saved[1:] == (None,) * 4
    state = advance(state, Point(42, 41), images, method=m)
    dropped = advance(state, Revisit(0), images, method=m)  # what is known of the second frame is given up
    again = advance(dropped, Accept(), images, method=m)
    assert again.frame == 1 and (again.draft.found == MarkerStatus.OPEN).all()


def test_taking_back_is_the_state_before():
    """Whatever was answered."""
    paths, m = straight(6), method(2)
    images = film(paths)
    state = begin(6, images, method=m)
    answers = [Point(40, 40), Absent(), Verify(), Yes(), No(), Point(99.5, 80.25), Accept(), Point(42, 41), Absent()]
    answers += [Accept(), Revisit(0), ByHand(), Point(40, 40), Point(100, 80), Accept()]
    for answer in answers:
        after = advance(state, answer, images, method=m)
        back = advance(after, Undo(), images, method=m)
        for name in ("saved", "frame", "draft", "phase", "marker", "searched"):
            assert same(getattr(back, name), getattr(state, name))
        assert back.asked == after.asked  # a question that was answered was a question
        state = after
    for _ in answers:
        state = advance(state, Undo(), images, method=m)
    assert state.saved == (None,) * 6 and state.phase is DigitisingPhase.POINT
    with pytest.raises(ValueError, match="no answer to take back"):
        advance(state, Undo(), images, method=m)


def test_a_marker_is_corrected_to_the_very_place_and_the_others_stay():
    m = method(2)
    state, images = second_frame(straight(5), m)
    state = advance(state, Revisit(0), images, method=m)
    before = state.draft
    for answer in (Verify(), Yes(), No(), Point(101.25, 77.5)):
        state = advance(state, answer, images, method=m)
    assert state.phase is DigitisingPhase.REVIEW and not same(state.saved[0], state.draft)
    np.testing.assert_array_equal(state.draft.uv, [before.uv[0], (101.25, 77.5)])
    assert state.draft.found[1] == MarkerStatus.PLACED
    state = advance(state, Accept(), images, method=m)
    np.testing.assert_array_equal(state.saved[0].uv[1], (101.25, 77.5))
    assert state.frame == 1  # it goes on where it was
    assert [a.reason for a in state.asked] == ["first_two_frames"] * 2 + ["corrected"]


def test_the_next_frame_expects_what_a_corrected_one_lets_expect():
    paths, m = straight(5), method(2)
    paths[0, 2:] = np.nan
    operator, images = Shown(paths), film(paths)
    state = begin(5, images, method=m)
    while state.frame < 2:
        state = advance(state, operator(question_of(state, method=m), state), images, method=m)
    expected = question_of(state, method=m).uv
    np.testing.assert_allclose(expected, 2 * paths[0, 1] - paths[0, 0], atol=0.05)
    moved = paths[0, 1] + (3.0, -1.5)
    for answer in (Revisit(1), Verify(), No(), Point(*moved), Yes(), Accept()):
        state = advance(state, answer, images, method=m)
    assert state.frame == 2
    np.testing.assert_allclose(question_of(state, method=m).uv, expected + 2 * np.array([3.0, -1.5]), atol=0.05)


def test_an_answer_that_fits_no_question_is_refused_and_changes_nothing():
    m = method(2)
    state, images = second_frame(straight(5), m)
    for answer in (Accept(), Verify(), No(), Yes(), ByHand(), Revisit(3), Revisit(-1), Revisit(99)):
        with pytest.raises(ValueError, match=r"no answer to a question|not been saved|no frame|nothing is proposed"):
            advance(state, answer, images, method=m)
    with pytest.raises(KinemarkError, match="no white pixel"):
        advance(state, Point(3, 3), images, method=m)


# ---- Answers in a file ----


def test_answers_read_as_they_were_written():
    for answer in (Point(312.0, 204.5), Absent(), Yes(), No(), Accept(), Verify(), ByHand(), Revisit(11), Undo()):
        assert parse_answer(answer_text(answer)) == answer
    assert parse_answer(answer_text(Point(np.float64(1.5), np.float64(2)))) == Point(1.5, 2)
    assert parse_answer(" 312,204 ") == Point(312, 204) and parse_answer("FRAME 12") == Revisit(11)
    for wrong in ("", "312", "312 204 7", "frame", "frame -1", "nan nan", "maybe"):
        with pytest.raises(ValueError, match="not understood"):
            parse_answer(wrong)


def test_the_same_answers_give_the_same_again_and_only_the_rest_is_asked():
    paths, _ = shifted(straight(12))
    paths[0, 6:8] = np.nan
    m, said = method(3, reference="m3"), []
    told = lambda question, answer: said.append(given(question, answer))  # noqa: E731
    done, _ = run(paths, m, on_answer=told)
    again = drive(Replay(said), film(paths), n_frames=12, method=m)
    assert same(tuple(result(again, method=m))[:4], tuple(done)[:4]) and result(again, method=m).figures == done.figures
    half = Shown(paths)
    part = drive(Replay(said[: len(said) // 2], otherwise=half), film(paths), n_frames=12, method=m)
    assert same(result(part, method=m).uv, done.uv)
    assert len(half.asked) == len(said) - len(said) // 2
    with pytest.raises(KinemarkError, match=r"no answer to this: Frame 1: point at marker m1"):
        drive(Replay([]), film(paths), n_frames=12, method=m)
    extra = Replay([*said, Given(3, "m1", Absent())])
    drive(extra, film(paths), n_frames=12, method=m)
    assert extra.unused == 1


def test_questions_are_put_in_words():
    m = method(2)
    state, _ = second_frame(straight(5), m)
    assert words(question_of(state, method=m)) == "Frame 2: point at marker m1, or - if it is not present."


# ---- Degenerate input ----


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"markers": ()}, "at least one"),
        ({"markers": ("a", "a")}, "each name once"),
        ({"markers": ("a",), "reference": "b"}, "reference is 'b'"),
        ({"markers": ("a",), "grid": 0}, "grid"),
        ({"markers": ("a",), "history": 1}, "history"),
        ({"markers": ("a",), "tolerance": 0.0}, "tolerance"),
    ],
)
def test_impossible_parameters_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        SemiAutomatic(**options)


def test_nothing_to_digitise():
    with pytest.raises(ValueError, match="n_frames is 0"):
        begin(0, film(straight(1)), method=method(1))
    with pytest.raises(ValueError, match="wanted None"):
        begin(3, film(straight(3)), method=method(1), constant=np.zeros(2))
    with pytest.raises(KinemarkError, match="No frame was saved"):
        result(begin(3, film(straight(3)), method=method(1)), method=method(1))
    black = np.full((1, 4, 2), np.nan)
    done, operator = run(black, method(1))
    assert np.isnan(done.uv).all() and len(operator.pointed()) == 4
    with pytest.raises(ValueError, match="rows, columns"):
        find_markers(np.zeros((2, 3, 4), np.uint8))


def test_one_frame_alone():
    done, _ = run(straight(1), method(2))
    np.testing.assert_allclose(done.uv, straight(1), atol=0.02)
