"""Markers at the edge of a body that hides a lit ground: places, and what is stated of them."""

import numpy as np
import pytest

from kinemark.detect import Centroids, detect
from support.films import Film

from .test_lamps_behind import FRAMES, H, W, filmed


def on_the_edge(seed):
    """A film of markers that ride on the left edge of a bar, which sweeps across a window, and their places."""
    edge = 150 + 70 * np.sin(np.arange(FRAMES) * 0.11 + seed)
    column = np.arange(W)
    bar = (column > edge[:, None]) & (column < edge[:, None] + 50)
    body = np.repeat(bar[:, None], H, 1)
    row = 20 + 35 * np.arange(6)
    drawn = np.random.default_rng(seed).uniform(-2.5, 2.5, 6)
    places = np.stack(np.broadcast_arrays(edge[:, None] + drawn, row), -1)
    return filmed(seed, body=body, paths=places)


def errors(film, places):
    """Errors (D, 2) px of what is found within 2 px, and their covariances."""
    found = detect([film], cameras=["cam1"], rate=50.0)
    off, cov = [], []
    for f in range(FRAMES):
        own = np.flatnonzero((found.frame == f) & found.valid)
        apart = found.uv[own] - places[f][:, None]
        best = np.linalg.norm(apart, axis=-1).argmin(1)
        near = np.linalg.norm(apart, axis=-1).min(1) < 2
        off.append(apart[np.flatnonzero(near), best[near]])
        cov.append(found.cov[own[best[near]]])
    return np.concatenate(off), np.concatenate(cov)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_markers_at_the_edge_of_a_body_before_a_window_are_placed_and_their_error_is_known(seed):
    """They were 0.22 px off, and squared errors 130 times the stated variance."""
    off, cov = errors(*on_the_edge(seed))
    ratio = np.einsum("ni,nij,nj->n", off, np.linalg.inv(cov), off) / 2
    assert len(off) > 0.98 * 6 * FRAMES
    assert np.sqrt((off**2).mean()) < 0.09 and 0.4 < ratio.mean() < 1.5


def test_dark_markers_are_placed_as_bright_ones():
    film, _ = on_the_edge(4)
    negative = Film(255 - film.images)
    bright, dark = (
        detect(
            [one], cameras=["cam1"], rate=50.0, method=Centroids(inverted=is_dark, background="subtract", threshold=50)
        )
        for one, is_dark in ((film, False), (negative, True))
    )
    assert bright.ground_subtracted == dark.ground_subtracted == ("cam1",)
    np.testing.assert_allclose(dark.uv, bright.uv, atol=1e-9)
    np.testing.assert_allclose(dark.cov, bright.cov, atol=1e-9)


@pytest.mark.parametrize("gap", [9.5, 10.5, 12.0])
def test_a_marker_is_not_moved_by_the_rim_of_its_neighbour(gap):
    """Pairs before dark ground, beside a window. They were moved 0.1 px off it."""
    turn = np.arange(FRAMES)[:, None] * 0.1
    first = np.stack(
        [70 + 45 * np.sin(turn + np.arange(4)), np.broadcast_to(40.0 + 45 * np.arange(4), (FRAMES, 4))], -1
    )
    film, places = filmed(5, paths=np.concatenate([first, first + np.array([gap, 0.0])], 1))
    off, _ = errors(film, places)
    assert len(off) > 0.95 * 8 * FRAMES
    assert np.sqrt((off**2).mean()) < 0.04
