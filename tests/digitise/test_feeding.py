"""An operator digitises a feeding motion behind a lamp: how often they are asked, and how right the centroids are."""

from functools import cache

import numpy as np
import pytest

from kinemark.digitise import DigitisingPhase, MarkerStatus, OtherViews, SemiAutomatic, drive, propose, result
from support.eating import Knowing, footage, image_source

FRAMES = 40
RADIUS = 8.0
"""px of a marker in these images."""


def markers(**options):
    return SemiAutomatic(("1", "2", "3", "4", "5", "6", "7", "REF"), "REF", **options)


@cache
def film_of(c):
    return image_source(footage(FRAMES / 30)[3][c])


@cache
def digitised(c, *, others=(), take=False, shake=0.0):
    """(operator, result) of camera c, with what was digitised of other cameras."""
    rig, _, sight, images = footage(FRAMES / 30)
    m, frames = markers(take_proposals=take), images[c]
    shift = np.zeros((FRAMES, 2))
    if shake:
        shift = np.random.default_rng(5).integers(-shake, shake + 1, (FRAMES, 2)).astype(float)
        frames = np.stack([np.roll(f, s[::-1].astype(int), (0, 1)) for f, s in zip(frames, shift, strict=True)])
    images = image_source(frames) if shake else film_of(c)
    operator = Knowing(sight, c, images, shift=shift)
    uv = np.full((3, 8, FRAMES, 2), np.nan)
    for other in others:
        uv[other] = digitised(other)[1].uv
    views = OtherViews(rig, c, uv)

    def ask(frame, marker, shift, expected, image_markers, free):
        return propose(
            views, frame, marker, shift=shift, expected=expected, image_markers=image_markers, free=free, method=m
        )

    constant = sight.uv[c, 7, 0]
    state = drive(operator, images, n_frames=FRAMES, method=m, constant=constant, proposer=ask if others else None)
    return operator, result(state, method=m)


def error(c, done):
    """(M, F) px from the true centres, and how much of each marker was in sight."""
    sight = footage(FRAMES / 30)[2]
    return np.linalg.norm(done.uv - sight.uv[c], axis=-1), sight.visible[c]


@pytest.mark.parametrize("c", [0, 1, 2])
def test_questions_are_few_and_centroids_right(c):
    """AskedQuestion for are the first two frames, what is hidden, and what has just come back."""
    operator, done = digitised(c)
    off, visible = error(c, done)
    whole = off[visible > 0.99]
    assert np.quantile(whole, 0.95) < 0.08 and whole.max() < 4.0  # where images run together, as far as they can see
    assert np.nanmax(off) < RADIUS  # of a marker that is partly hidden, the part in sight
    assert np.isfinite(off[visible >= operator.least]).all()  # none is missed
    hidden = visible < operator.least
    back = np.diff(hidden.astype(int), axis=1) == -1
    count = done.figures["questions_by_reason"]
    assert count["first_two_frames"] == 16 and count["reference"] == 0
    assert count["not_found"] <= hidden[:, 2:].sum() + 2 * back.sum() + 6  # images that run together serve one marker
    assert done.figures["not_present"] == np.isnan(off).sum() <= hidden.sum()


def test_the_lamp_hides_markers_from_two_cameras():
    """Else the test above would say little."""
    visible = footage(FRAMES / 30)[2].visible
    assert (visible[0] < 0.35).sum() >= 10 and (visible[1] < 0.35).sum() >= 5


def test_what_is_hidden_from_none_is_never_asked_for():
    done = digitised(2)[1]
    assert done.figures["questions"] == 16 and done.figures["corrected"] == 0
    assert (done.found[:, 2:] == MarkerStatus.AUTOMATIC).all()


def test_the_number_of_questions_is_one_in_ten_at_most():
    """320 markers a camera, of which the operator points at these, and puts few of the others right."""
    figures = [digitised(c)[1].figures for c in range(3)]
    assert figures[0]["questions"] <= 40 and figures[1]["questions"] <= 26
    assert figures[0]["corrected"] <= 10 and figures[1]["corrected"] <= 2
    for f in figures:
        assert f["questions"] == sum(f["questions_by_reason"].values())
        assert f["questions_share"] == f["questions"] / 320


def run_together(question):
    """Whether the image of the marker touches another's."""
    uv = footage(FRAMES / 30)[2].uv[0, :, question.frame]
    return np.sort(np.hypot(*(uv - uv[question.marker]).T))[1] < 2 * RADIUS + 3


def test_two_other_cameras_propose_the_missing_answer():
    """Where the marker is, to a part of a pixel, and whether it is seen there: not if a limb or another is in front."""
    operator, done = digitised(0, others=(1, 2))
    put = [q for q in operator.asked if q.phase is DigitisingPhase.POINT and q.name != "REF"]
    assert all(q.proposal is not None for q in put)
    places = np.array([q.proposal.uv - operator.place(q.marker, q.frame) for q in put])
    assert np.abs(places).max() < 0.3
    assert done.figures["proposals_confirmed"] == sum(map(operator.agrees, put)) > 0.8 * len(put)
    refused = [q for q in put if not operator.agrees(q)]
    assert all(q.proposal.seen or run_together(q) for q in refused)
    assert all(operator.visible[q.marker, q.frame] < 0.35 or not q.proposal.seen for q in refused)


@pytest.mark.parametrize("other", [1, 2])
def test_one_other_camera_gives_a_line(other):
    """What lies on it and is nobody's is mostly the marker, whole or in part; where nothing does, it is hidden."""
    operator, _ = digitised(0, others=(other,))
    said = [q for q in operator.asked if q.phase is DigitisingPhase.POINT and q.proposal is not None]
    assert len(said) >= 15
    for q in said:
        if q.proposal.seen:
            assert np.hypot(*(q.proposal.uv - operator.place(q.marker, q.frame))) < RADIUS
        else:
            assert operator.visible[q.marker, q.frame] < operator.least or run_together(q)


def test_taken_without_a_question_only_the_reference_marker_is_asked_for():
    operator, done = digitised(0, others=(1, 2), take=True)
    assert {q.name for q in operator.asked if q.phase is DigitisingPhase.POINT} == {"REF"}
    assert done.figures["questions"] == 2 and done.figures["proposals_taken_unasked"] >= 20
    assert done.figures["proposals_confirmed"] == 0  # nobody was asked
    off, visible = error(0, done)
    assert np.quantile(off[visible > 0.99], 0.95) < 0.08 and np.nanmax(off) < RADIUS
    assert np.isfinite(off[visible > 0.9]).all()


def test_images_that_shake_are_put_right_by_the_reference_marker():
    still, shaken = digitised(2)[1], digitised(2, shake=4)[1]
    assert shaken.figures["questions"] == still.figures["questions"]
    off, visible = error(2, shaken)
    assert np.nanmax(off[:7][visible[:7] > 0.99]) < 0.2
    assert np.abs(shaken.seen - still.seen).max() > 3
    assert (shaken.found == still.found).all()


def test_views_of_other_cameras_are_checked():
    rig = footage(FRAMES / 30)[0]
    with pytest.raises(ValueError, match="camera is 3"):
        OtherViews(rig, 3, np.zeros((3, 8, 5, 2)))
    with pytest.raises(ValueError, match="uv has shape"):
        OtherViews(rig, 0, np.zeros((2, 8, 5, 2)))
