"""Naming above a wet floor: images of markers in it have no name, and the markers keep theirs."""

import numpy as np

from kinemark.data import Cloud, Tracks
from kinemark.engine.naming.naming import name_tracks
from kinemark.engine.naming.templates import SessionTemplate
from kinemark.label import Labelling, learn_template
from kinemark.synth import ring, walking, with_markers
from kinemark.track.simultaneous.diagnosis.mirror_images import mirror_images

RIG = ring(4)


def walk(seed, speed):
    walker = walking(duration_s=2.0, rate=50.0, seed=seed, wobble_mm=2.0, marker_radius_mm=7.0, speed_mm_s=speed)
    return with_markers(walker, 39, seed=1)


def tracks_of(xyz, rng):
    """Tracks (M, F, 3) with noise."""
    M, F = xyz.shape[:2]
    xyz = xyz.swapaxes(0, 1).reshape(-1, 3) + rng.normal(0, 0.5, (M * F, 3))
    own = np.arange(M * F)[:, None].repeat(4, 1)
    cloud = Cloud(50.0, np.arange(F + 1) * M, xyz, np.tile(np.eye(3) / 4, (M * F, 1, 1)), np.full(M * F, 0.2), own)
    return Tracks(cloud, np.tile(np.arange(M), F))


def test_images_in_a_floor_have_no_name():
    """The images of all markers are a body as well, of which some would have names."""
    truth, rng = walk(3, 1000.0), np.random.default_rng(310)
    M, by = len(truth.names), {"": SessionTemplate(learn_template(walk(1, 900.0).trajectories), ("another",))}
    real = truth.xyz + np.array([0, 0, 60 - truth.xyz[..., 2].min()])  # soles are thick
    floor = real * [1, 1, -1]
    real[::3, :60] = np.nan  # markers that are hidden for long, their images not
    tracks = tracks_of(np.concatenate([floor, real]), rng)
    known = np.isfinite(tracks.cloud.xyz).all(1)
    tracks = Tracks(tracks.cloud.keep(known), tracks.id[known])
    images = mirror_images(tracks, RIG).tolist()
    assert images == list(range(M))
    found = name_tracks(tracks, by, how=Labelling(), images=images)
    assert all(name.startswith("*") for name in found.tracker_names[:M])
    right = sum(name == true for name, true in zip(found.tracker_names[M:], truth.names, strict=True))
    without = name_tracks(tracks, by, how=Labelling())
    assert right >= 0.9 * M > sum(a == b for a, b in zip(without.tracker_names[M:], truth.names, strict=True))
