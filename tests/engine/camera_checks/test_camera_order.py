"""Cameras in the wrong order are put in order where it is sure which one has whose images, and only there."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import Rig, make_finding
from kinemark.engine.camera_checks.camera_order import images_of_others, put_in_order, told_in_order
from kinemark.report.words import text_of
from kinemark.track.simultaneous import Simultaneous, diagnose, track_simultaneously
from support.laboratory import camera, observe, ring
from support.motions import dance

PATHS = dance(n=8, frames=20)


def wrong_way(rig, order):
    """The rig with its cameras in another order under the same names."""
    return Rig(tuple(replace(rig[k], name=name) for k, name in zip(order, rig.names, strict=True)))


def told(seen, rig):
    result = track_simultaneously(seen, rig, Simultaneous())
    return images_of_others(diagnose(seen, rig, result), seen, rig, result.tracks.cloud)


ORDERS = {
    "two of three": [1, 0, 2],
    "two of four": [2, 1, 0, 3],
    "three in a ring": [1, 2, 0, 3, 4],
    "two pairs": [1, 0, 3, 2, 4, 5],
    "two pairs of eight": [1, 0, 3, 2, 4, 5, 6, 7],
    "three in a ring of four": [1, 2, 0, 3],
    "two pairs of four": [3, 2, 1, 0],
    "five in any order": [2, 4, 1, 0, 3],
    "eight by one": [1, 2, 3, 4, 5, 6, 7, 0],
}


@pytest.mark.parametrize("order", ORDERS.values(), ids=ORDERS)
def test_the_rig_comes_out_as_it_was(order):
    rig = ring(len(order))
    seen, _ = observe(rig, PATHS, noise=0.1)
    wrong = wrong_way(rig, order)
    images_of = told(seen, wrong)
    assert images_of == {rig.names[k]: rig.names[order.index(k)] for k in range(len(order)) if order[k] != k}
    right = put_in_order(wrong, images_of)
    assert right.names == rig.names
    assert all(np.array_equal(a.R, b.R) and np.array_equal(a.K, b.K) for a, b in zip(right, rig, strict=True))
    text = text_of(told_in_order(images_of))
    assert all(f"{name} has those of {other}" in text for name, other in images_of.items())


def test_nothing_is_put_in_order_where_nothing_is_wrong_or_a_camera_has_the_images_of_two():
    rig = ring(5)
    seen, _ = observe(rig, PATHS, noise=0.1)
    assert told(seen, rig) == {}
    assert told(seen, wrong_way(rig, [0, 0, 2, 3, 4])) == {}  # the images of one are given for two


def test_of_pairs_that_would_do_as_well_none_is_chosen():
    """Half a turn of a square is the square: the other two exchanged are this world turned."""
    places = [(4000, 0, 1500), (0, 4000, 1500), (-4000, 0, 1500), (0, -4000, 1500)]
    rig = Rig(tuple(camera(f"c{k}", place) for k, place in enumerate(places)))
    seen, _ = observe(rig, PATHS, noise=0.1)
    wrong = wrong_way(rig, [2, 1, 0, 3])
    assert told(seen, wrong) == {}
    one = make_finding("camera_takes_place_of_other", cameras=["c0", "c2"], left_out=True)
    other = make_finding("camera_takes_place_of_other", cameras=["c2", "c0"], left_out=True)
    cloud = track_simultaneously(seen, wrong, Simultaneous()).tracks.cloud
    assert images_of_others([one, other], seen, wrong, cloud) == {}
