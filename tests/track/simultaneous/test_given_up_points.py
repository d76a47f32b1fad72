"""Points that lose one of their images, and points that are given up, at once."""

import numpy as np

from kinemark.geometry.weighted_points import DEFAULT_ERRORS
from kinemark.track.simultaneous import Simultaneous, track_with_decisions
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.ghosts.given_up_points import _of_fewer_images
from kinemark.track.simultaneous.noise.measurement_noise import Noise
from kinemark.track.simultaneous.points.solved_points import Solver, Working, solved
from support.laboratory import observe, ring
from support.motions import dance
from support.scenes import make, scene, tally

MARKERS, FRAMES, NOISE = 3, 20, 0.1
LESS, GONE = np.arange(5, 15), np.arange(8, 12)


def recorded():
    """Markers' images, a solver of their points, and the points."""
    rig = ring(4)
    xyz = dance(n=MARKERS, frames=FRAMES, seed=2)
    detections, marker = observe(rig, xyz, noise=NOISE, seed=3)
    images = read_images(detections, rig)
    detection = np.full((4, FRAMES * MARKERS), -1)
    detection[images.camera, images.frame * MARKERS + marker] = np.arange(len(marker))
    frame, which = np.divmod(np.arange(FRAMES * MARKERS), MARKERS)
    none = np.zeros(len(rig))
    working = Working(rig, images, Noise(none, none, none, none, none, none))
    solver = Solver(detections, working, np.zeros(len(marker), bool), DEFAULT_ERRORS)
    return images, solver, solved(frame, detection, xyz[which, frame].T, solver), which


def test_points_that_exchange_images_exchange_places():
    """They are far from where they were, which is no guess then."""
    images, solver, before, which = recorded()
    other, changed = before.detection.copy(), (which < 2) & np.isin(before.frame, LESS)
    one, two = np.flatnonzero(changed & (which == 0)), np.flatnonzero(changed & (which == 1))
    other[one], other[two] = before.detection[two], before.detection[one]
    held, _ = _of_fewer_images([before], other, np.ones(len(which), bool), images, solver, Simultaneous())
    assert np.linalg.norm(before.xyz[one] - before.xyz[two], axis=1).min() > 100
    np.testing.assert_allclose(held[0].xyz[one], before.xyz[two], atol=0.01)
    np.testing.assert_allclose(held[0].xyz[two], before.xyz[one], atol=0.01)
    np.testing.assert_array_equal(held[0].xyz[~changed], before.xyz[~changed])


def test_a_point_that_loses_an_image_and_is_given_up_moves_no_other():
    """Of marker 1 in frames LESS camera 3 is left out, and in GONE of them the whole point."""
    images, solver, before, which = recorded()
    frame = before.frame
    fewer = before.detection.copy()
    fewer[(which == 1) & np.isin(frame, LESS), 3] = -1
    sound = ~((which == 1) & np.isin(frame, GONE))
    held, kept = _of_fewer_images([before], fewer, sound.copy(), images, solver, Simultaneous())
    after, changed = held[0], (fewer != before.detection).any(1)
    np.testing.assert_array_equal(kept, sound)
    np.testing.assert_array_equal(after.detection, fewer[sound])
    np.testing.assert_array_equal(after.frame, frame[sound])
    np.testing.assert_array_equal(after.xyz[~changed[sound]], before.xyz[sound & ~changed])
    again = solved(frame[sound & changed], fewer[sound & changed].T, before.xyz[sound & changed].T, solver)
    np.testing.assert_allclose(after.xyz[changed[sound]], again.xyz, atol=1e-6)
    assert not (again.xyz == before.xyz[sound & changed]).any()


def test_two_markers_images_that_meet_a_merged_one_of_both_are_given_up():
    """Two cameras see one of either, and a third camera both in one image, which the file marks."""
    one = make(scene(2147))
    counts = tally(one, *track_with_decisions(one.detections, one.rig))
    assert counts.ghosts <= 20  # 51 where the merged image counts as a third
    assert counts.two_found > 0.97 * counts.two and counts.more_found > 0.995 * counts.more
