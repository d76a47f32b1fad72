"""Rules of digitising: what is near enough, what is in doubt, what other cameras say; named detections."""

from functools import cache

import numpy as np
import pytest

from kinemark.data import Trajectories
from kinemark.detect import Centroids
from kinemark.digitise import (
    OtherViews,
    called,
    clicked,
    drive,
    find_markers,
    identified,
    identified_matches,
    propose,
    result,
    words,
)
from kinemark.digitise.search import expected
from kinemark.geometry import project_all
from support.eating import CENTRE, SIZE, laboratory
from support.pointing import RADIUS, Shown, U, film, image, method, run, straight, third_frame

# ---- Where a marker is looked for ----


def with_reference(paths, shift):
    """A marker that stands still as the last, and all moved by shift (F, 2)."""
    return np.concatenate([paths, np.broadcast_to([20.0, 100.0], (1, *paths.shape[1:]))]) + shift


def test_markers_are_expected_on_their_line_and_with_the_image():
    m = method(3, reference="m3")
    paths = with_reference(straight(3), np.array([[0, 0], [2, 1], [-3, 4]]))
    np.testing.assert_allclose(expected(third_frame(paths, m, film(paths)), m)[:2], paths[:2, 2], atol=0.05)


@pytest.mark.parametrize(("shift", "asked"), [(2 + RADIUS, False), (4 + RADIUS, True)])
def test_the_reference_marker_is_looked_for_on_five_pixels_only(shift, asked):
    """So that another marker that passes farther away is not taken for it."""
    moved = np.zeros((3, 2))
    moved[2, 0] = shift
    _, operator = run(with_reference(straight(3), moved), method(3, reference="m3"))
    assert ((2, 2) in operator.pointed()) == asked


def test_of_two_markers_the_nearer_takes_the_image_also_if_it_is_the_later():
    paths = straight(8, start=((40.0, 40.0), (50.0, 40.0)), speed=((2.0, 0.0), (2.0, 0.0)))
    paths[:, 6:, 0] -= 4
    paths[0, 6] = np.nan
    done, operator = run(paths, method(2))
    assert (6, 0) in operator.pointed() and (6, 1) not in operator.pointed()
    np.testing.assert_allclose(done.uv[1, 6], paths[1, 6], atol=0.02)


MEETINGS = 16
TOGETHER = Centroids(max_discs=1, correct_occlusion=False)
"""Images that touch are one, as UM²AS sees them."""


def meeting(seed):
    """Paths (2, 16, 2) of markers that come together, stay so for a while, and part, in any manner."""
    rng = np.random.default_rng(seed)
    f, stay = np.arange(16), rng.integers(0, 3)
    gap = np.maximum(np.maximum(7 - f, f - 6 - stay), 0) * rng.uniform(2, 5) + rng.uniform(0, 3)
    turn = rng.uniform(0, 2 * np.pi)
    angle = np.where(f < 7, turn, turn + rng.choice([0, np.pi]) + rng.normal(0, 0.5))
    half = gap[:, None] / 2 * np.stack([np.cos(angle), np.sin(angle)], -1)
    middle = np.array([70.0, 60.0]) + f[:, None] * rng.uniform(-1.5, 1.5, 2)
    return np.stack([middle + half, middle - half])


def exchanged(paths, done):
    """Whether each is once where the other is, though they are apart."""
    own, other = (np.linalg.norm(done.uv - p, axis=-1) for p in (paths, paths[::-1]))
    return bool(((other < own - 3) & (np.linalg.norm(paths[0] - paths[1], axis=-1) > 12)).any())


def test_markers_that_met_are_asked_for_when_two_images_would_do():
    """Of all meetings hardly one ends with the names exchanged; as UM²AS does it, one in four does."""
    count = {}
    for clear in (1.0, 1.5):
        m, done = method(2, ambiguity_ratio=clear), []
        for seed in range(MEETINGS):
            paths = meeting(seed)
            images = cache(lambda f, paths=paths: find_markers(image(paths[:, f]), method=TOGETHER))
            done.append(result(drive(Shown(paths), images, n_frames=16, method=m), method=m))
        doubts = [one.figures["questions_by_reason"]["ambiguous"] for one in done]
        count[clear] = sum(exchanged(meeting(seed), one) for seed, one in enumerate(done)), max(doubts)
    assert count[1.0][0] >= MEETINGS / 4 and count[1.0][1] == 0
    assert count[1.5][0] <= MEETINGS / 10 and count[1.5][1] <= 4


def test_an_ambiguous_question_says_why():
    paths = straight(8, start=((40.0, 40.0), (60.0, 40.0)), speed=((0.0, 0.0), (0.0, 0.0)))
    paths[1, 5:] = np.nan
    paths[0, 5, 0] += 8
    images = film(np.concatenate([paths, paths[:1] - np.where(np.arange(8) == 5, 17.0, np.nan)[:, None] * [1, 0]]))
    asked = []

    def operator(question, state):
        if question.ambiguous:
            asked.append(words(question))
        return Shown(paths)(question, state)

    drive(operator, images, n_frames=8, method=method(2))
    assert "Frame 6: point at marker m1, expected near (40, 40)" in asked[0]
    assert all(said.startswith("Frame 6") and "Two images would do." in said for said in asked)


# ---- What other cameras say ----


def seen_by(shift, extra=()):
    """Two other cameras' views of a marker, its place in the first's image, and that image, moved by a shift."""
    rig = laboratory()
    uv = project_all(rig, CENTRE[None] + [30.0, 40.0, 50.0])
    views = np.full((3, 1, 1, 2), np.nan)
    views[1:, 0, 0] = uv[1:, 0]
    v, u = np.mgrid[: SIZE[1], : SIZE[0]]
    at = uv[0, 0] + shift
    discs = [at, *(at + off for off in extra)]
    white = np.min([np.hypot(u - p[0], v - p[1]) for p in discs], axis=0)
    return rig, views, at, find_markers((10 + 210 * np.clip(8.5 - white, 0, 1)).astype(np.uint8))


def proposal(rig, views, image_markers, *, shift, expected=(np.nan, np.nan)):
    free, m = np.ones(len(image_markers.uv), bool), method(1, tolerance=1.0)
    there = OtherViews(rig, 0, views)
    return propose(
        there, 0, 0, shift=shift, expected=np.array(expected), image_markers=image_markers, free=free, method=m
    )


@pytest.mark.parametrize("others", [(1, 2), (1,), (2,)])
def test_proposals_know_that_the_image_has_shifted(others):
    shift = np.array([7.0, 6.0])
    rig, views, at, image_markers = seen_by(shift)
    views[[c for c in (1, 2) if c not in others]] = np.nan
    said = proposal(rig, views, image_markers, shift=shift)
    assert said.seen and np.hypot(*(said.uv - at)) < 0.1
    away = proposal(rig, views, image_markers, shift=np.zeros(2))
    assert not away.seen


def test_two_images_on_the_line_of_one_camera_are_no_answer_but_where_it_is_expected():
    """From the side the line is level: the other image lies on it, far away."""
    rig, place = laboratory(), CENTRE + np.array([30.0, 40.0, 50.0])
    line = project_all(rig, place + np.outer([0, 0.1], rig.centres[1] - place))[0]
    along = (line[1] - line[0]) / np.linalg.norm(line[1] - line[0])
    rig, views, at, image_markers = seen_by(np.zeros(2), extra=(120.0 * along,))
    views[2] = np.nan
    assert proposal(rig, views, image_markers, shift=np.zeros(2)) is None
    said = proposal(rig, views, image_markers, shift=np.zeros(2), expected=at + 3)
    assert said.seen and np.hypot(*(said.uv - at)) < 0.1


# ---- Identity ----


def test_named_detections_are_matched_by_their_names():
    rng = np.random.default_rng(0)
    uv = rng.uniform(0, 500, (3, 5, 7, 2))
    uv[rng.random((3, 5, 7)) < 0.4] = np.nan
    seen = identified(uv, cameras=("a", "b", "c"), rate=30.0)
    matches = identified_matches(*seen)
    views = np.isfinite(uv[..., 0]).sum(0)
    assert len(matches) == (views >= 2).sum()
    for frame, detection in zip(matches.frame, matches.detection, strict=True):
        markers = {int(seen.marker[row]) for row in detection if row >= 0}
        assert len(markers) == 1
        m = markers.pop()
        for c, row in enumerate(detection):
            assert (row < 0) == np.isnan(uv[c, m, frame, 0])
            if row >= 0:
                np.testing.assert_array_equal(seen.detections.uv[row], uv[c, m, frame])


def test_a_marker_nobody_saw_has_an_empty_path():
    names = ("a", "b")
    found = called(Trajectories((), 30.0), names, 4)
    assert found.names == names and np.isnan(found.xyz).all() and found.n_frames == 4
    with pytest.raises(ValueError, match="one coordinate"):
        identified(np.array([[[[1.0, np.nan]]]]), cameras=("a",), rate=1.0)


# ---- Images of other kinds ----


def test_a_search_takes_nothing_masked_and_an_operator_may():
    mask = np.zeros(U.shape, bool)
    mask[30:50, 30:50] = True
    image_markers = find_markers(image([(40, 40), (100, 80)]), mask=mask)
    assert image_markers.usable.tolist() == [False, True] and clicked(image_markers, np.array([40, 40])) == 0


def test_a_lower_field_lies_half_a_line_lower():
    upper, lower = find_markers(image([(40, 40)])), find_markers(image([(40, 40)]), v_offset=0.5)
    np.testing.assert_allclose(lower.uv - upper.uv, [[0, 0.5]])
    assert (lower.owner == upper.owner).all()
