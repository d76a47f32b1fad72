"""Samples that nobody measured are told from what is at rest, in files of any step and rate."""

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.edit.probable_errors import Paths, fillings
from kinemark.signal.filters import butterworth
from support.walked import RATE, clean, every, with_xyz

P, FIRST, STOP = 6, 150, 200


def filled(trial, kind, p=P, first=FIRST, stop=STOP):
    """A trial whose path p is held at its last place, is straight, or stands still to its end or from its beginning."""
    xyz = trial.paths[p].xyz.copy()
    if kind == "straight":
        share = np.linspace(0, 1, stop - first + 2)[1:-1, None]
        xyz[first:stop] = xyz[first - 1] * (1 - share) + xyz[stop] * share
    elif kind == "beginning":
        xyz[:stop] = xyz[stop]
    else:
        xyz[first : stop if kind == "held" else None] = xyz[first - 1]
    return with_xyz(trial, {p: xyz})


def written(trial, step):
    """As a file with whole multiples of a step, or in single precision, has it."""
    xyz = trial.xyz.astype(np.float32) if step is None else np.round(trial.xyz / step) * step
    return with_xyz(trial, dict(enumerate(xyz.astype(float))))


def likely(trial, above=0.5):
    found = [one for one in fillings(Paths.of(trial)) if one.wrong > above]
    return [(one.path, one.first, one.last, one.still) for one in found]


SPANS = {"held": (FIRST, STOP - 1), "straight": (FIRST, STOP - 1), "end": (FIRST, 399), "beginning": (0, STOP - 1)}


@pytest.mark.parametrize("step", [0.0, None, 0.02])
@pytest.mark.parametrize("kind", SPANS)
def test_what_was_filled_is_found_with_its_samples(kind, step):
    trial = filled(clean(), kind)
    trial = trial if step == 0.0 else written(trial, step)
    assert trial.n_frames == 400 and likely(trial, 0.9) == [(P, *SPANS[kind], kind != "straight")]


@pytest.mark.parametrize(("rate", "n"), [(RATE / 2, 10), (RATE / 4, 6)])
def test_it_is_found_at_lower_rates(rate, n):
    trial = filled(every(clean(), round(RATE / rate)), "straight", first=40, stop=40 + n)
    assert likely(trial) == [(P, 40, 39 + n, False)]


@pytest.mark.parametrize("step", [0.0, 0.05])
@pytest.mark.parametrize("seed", [3, 8])
def test_a_clean_walk_has_none_worth_a_look(seed, step):
    trial = clean(seed=seed) if step == 0.0 else written(clean(seed=seed), step)
    assert not likely(trial, 0.05)


def test_what_comes_to_rest_by_and_by_was_measured():
    """A cup that is put on a table, in a file that was filtered."""
    share = (1 - np.cos(np.pi * np.clip(np.arange(400) / RATE - 1, 0, 1))) / 2
    cup = np.column_stack([300 * share, 0 * share, 200 * share * (1 - share)]) + np.array([900.0, 0, 700])
    cup += np.random.default_rng(4).normal(0, 0.2, cup.shape)
    whole = clean()
    xyz = np.array([butterworth(path, rate=RATE, cutoff_hz=6.0) for path in [*whole.xyz, cup]])
    paths = tuple(MarkerTrajectory.measured(name, path) for name, path in zip([*whole.names, "CUP"], xyz, strict=True))
    assert not likely(Trajectories(paths, RATE))


def test_where_all_stand_still_nobody_was_filled():
    xyz = np.repeat(clean().xyz[:, 100:101], 400, axis=1)
    assert not likely(with_xyz(clean(), dict(enumerate(xyz))), 0.0)


def test_nothing_hangs_on_the_origin():
    trial = filled(clean(), "straight")
    far = with_xyz(trial, dict(enumerate(trial.xyz + np.array([2e6, -1e6, 0.0]))))
    assert likely(far) == likely(trial)
