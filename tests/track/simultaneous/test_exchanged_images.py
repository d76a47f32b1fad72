"""Two tracks that have exchanged images of two markers."""

import numpy as np
import pytest

from kinemark.track.simultaneous import Simultaneous, track_detections
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.ghosts.chance_meetings import chance_meetings
from kinemark.track.simultaneous.ghosts.drift_beyond import drifting_beyond
from kinemark.track.simultaneous.ghosts.drifting_pairs import drifting, usual_residuals
from kinemark.track.simultaneous.ghosts.exchanged_images import with_exchanged
from support.laboratory import observe, ring
from support.motions import dance
from support.scenes import make, scene, tally

NOISE, MARKERS, FRAMES, METHOD = 0.1, 8, 120, Simultaneous()
PART = np.arange(40, 60)
ONE, OTHER = MARKERS - 1, MARKERS


class Exchange:
    """Points of all markers in four cameras, but in PART, those of ONE and OTHER in cameras 0 and 1 alone.

    OTHER lies 200 mm beside ONE, `above` mm over the plane of both cameras, so that the wrong images nearly fit. Where
    they are `wrong`, either track has the other's image in camera 1.
    """

    def __init__(self, *, wrong=True, above=0.5):
        rig = ring(4)
        xyz = dance(n=MARKERS, frames=FRAMES, seed=2)
        along = rig[0].centre - rig[1].centre
        beside = 200 * along / np.linalg.norm(along) + np.array([0.0, 0.0, above])
        detections, marker = observe(rig, np.concatenate([xyz, xyz[ONE:] + beside]), noise=NOISE, seed=3)
        images = read_images(detections, rig).noisier(np.full(4, (5 * NOISE) ** 2))
        hidden = (marker >= ONE) & np.isin(images.frame, PART) & (images.camera >= 2)
        self.images = images._replace(usable=~hidden, by_cell=images.by_cell.keep(~hidden))
        held = np.full((4, MARKERS + 1, FRAMES), -1)
        held[images.camera, marker, images.frame] = np.where(hidden, -1, np.arange(len(marker)))
        if wrong:
            held[1, [[ONE], [OTHER]], PART] = held[1, [[OTHER], [ONE]], PART]
        self.held = held.reshape(4, -1)
        self.frame, self.id = np.tile(np.arange(FRAMES), MARKERS + 1), np.repeat(np.arange(MARKERS + 1), FRAMES)
        self.known = self.frame, self.id, self.held, self.images
        self.usual = usual_residuals(*self.known, METHOD.gate)

    def changed(self):
        """The detections (4, P) after it."""
        return with_exchanged(*self.known, self.usual, METHOD.gate)


def test_images_that_two_tracks_have_exchanged_are_changed_back():
    """Each track has its own marker's images, as before and after these frames; nothing else tells it."""
    one = Exchange()
    assert not drifting(*one.known, one.usual, METHOD.gate).any()
    assert not drifting_beyond(*one.known, one.usual, 0.0, METHOD.gate, 1 / 100).any()
    assert not chance_meetings(*one.known, one.usual, 0.0, METHOD.gate).any()
    np.testing.assert_array_equal(one.changed(), Exchange(wrong=False).held)


@pytest.mark.parametrize(("wrong", "above"), [(False, 0.5), (False, 0.0), (True, 0.0), (True, 0.2)])
def test_images_stay_where_the_other_way_fits_no_better(wrong, above):
    one = Exchange(wrong=wrong, above=above)
    np.testing.assert_array_equal(one.changed(), one.held)


def test_ghosts_of_exchanged_images_become_markers():
    """Of sixty markers on four cameras: without it 113 ghosts, and 7714 samples of two cameras. Most of those that
    are left are of two chance tracks of remaining images. With what is left of others there are 38."""
    made = make(scene(130008))
    found = tally(made, track_detections(made.detections, made.rig))
    assert found.ghosts <= 31
    assert found.two_found >= 7780
