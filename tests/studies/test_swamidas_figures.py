"""The moving average of sensor tracks and the redrawn figures of Swamidas (1997)."""

import numpy as np
import pytest
import swamidas_figures as study


def test_the_moving_average_takes_noise_away_and_leaves_the_curvature():
    for seed in (3, 4):
        rows = study.averages(seed)
        _, noise, off, curvature = (np.array(column) for column in zip(*rows, strict=True))
        assert (np.diff(noise) < 0).all() and noise[4] < noise[0] / 7  # nine samples
        assert (np.diff(off) < 0).all()
        assert (np.abs(curvature[1:] / curvature[2] - 1) < 0.1).all()


def test_noise_and_curvature_are_what_they_are_of_known_tracks():
    path = np.random.default_rng(1).normal(0, 2.0, (4000, 3))
    assert study.noise(path) == pytest.approx(2.0, rel=0.05)
    assert study.noise(np.outer(np.arange(50.0) ** 2, [1.0, 2.0, 3.0])) == pytest.approx(0.0, abs=1e-9)
    t = np.linspace(-1, 1, 101)
    bow = np.column_stack([1000 * t, 30 * (1 - t**2), 0 * t])
    assert study.curvature(bow) == pytest.approx(20.0, abs=0.5)


def test_every_figure_is_drawn_and_within_its_frame():
    page = study.page()
    for figure in ("4.4", "4.5", "4.8", "4.9", "4.10", "4.11", "4.12", "4.13"):
        assert f"Like figure {figure}" in page
    assert "nan" not in page
    places = [p for line in page.split('points="')[1:] for p in line.split('"')[0].split()]
    xy = np.array([[float(n) for n in p.split(",")] for p in places])
    assert (xy >= 0).all() and (xy[:, 0] <= study.WIDTH).all() and (xy[:, 1] <= study.HEIGHT).all()
    gaps = page[page.index("4.13") :].count("<polyline")
    assert gaps == 6  # three tracks with one gap each


def test_more_noise_gives_worse_tracks():
    truth = study.recorded(1, 0.0).xyz
    off = [np.linalg.norm(study.noisy_tracks(1, percent) - truth, axis=-1).mean() for percent in (5, 10, 20)]
    assert off[0] < off[1] / 1.5 < off[2] / 3
