"""Records moved with the world, answers compared, and the table of cases: what `test_shift_law` is made of."""

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from functools import partial, singledispatch
from typing import Any, NamedTuple

import numpy as np

from kinemark.calibrate.bundle import Sticks
from kinemark.calibrate.world_frame import carried
from kinemark.data import Camera, Cloud, MarkerTrajectory, Rig, Rods, Tracks, Trajectories
from kinemark.fill import MarkerArray, Rays, StaticShape
from kinemark.sensitivity import SampledFrames
from kinemark.synth import Capsules, Subject

FAR = np.array([1e7, -1e7, 1e7])
"""mm: 10 km along each axis. One unit in the last place of such a coordinate is 1.9e-9 mm."""
GRID = 2.0**-20
"""mm: places on this grid, a nanometre, are moved by `FAR` without rounding."""


class Answer(NamedTuple):
    """What a function gives: places, mm, which move with the world, and the rest, which does not."""

    places: Any = ()
    rest: Any = ()


CASES = {}
"""By name: case(by) -> Answer; mm and share that its answer may be off; the functions that it is about."""
MM, SHARE = 1e-7, 1e-9
OPEN = 1e-6
"""Of what a calibration leaves open: `Camera.cov` is about the world's origin, so that (10 km / 3 m)² cancels."""


def law(*functions, mm=MM, share=SHARE, each=None, name=""):
    """A case for these functions; or for each of some parameters, by name."""

    def add(case):
        label = name or functions[0].__name__
        for way, parameter in (each or {}).items():
            CASES[f"{label}[{way}]"] = partial(case, parameter=parameter), mm, share, functions
        if not each:
            CASES[label] = case, mm, share, functions
        return case

    return add


def on_grid(xyz):
    return np.round(np.asarray(xyz, float) / GRID) * GRID


@singledispatch
def moved(record, by):
    """The same in a world whose origin is somewhere else; places of arrays (…, 3)."""
    raise TypeError(f"nothing says how a {type(record).__name__} moves")


@moved.register(np.ndarray)
@moved.register(list)
@moved.register(tuple)
def _(xyz, by):
    return np.asarray(xyz, float) + by


@moved.register
def _(points: dict, by):
    return {name: xyz + by for name, xyz in points.items()}


@moved.register
def _(camera: Camera, by):
    return carried(camera, np.eye(3), by, 1.0)[0]


@moved.register
def _(rig: Rig, by):
    return Rig(tuple(moved(camera, by) for camera in rig), rig.method, rig.volume + by)


@moved.register(MarkerTrajectory)
@moved.register(Cloud)
@moved.register(Rods)
def _(record, by):
    return replace(record, xyz=record.xyz + by)


@moved.register
def _(trial: Trajectories, by):
    return replace(trial, paths=tuple(moved(path, by) for path in trial))


@moved.register(MarkerArray)
@moved.register(StaticShape)
@moved.register(SampledFrames)
def _(record, by):
    return record._replace(xyz=record.xyz + by)


@moved.register
def _(tracks: Tracks, by):
    return replace(tracks, cloud=moved(tracks.cloud, by))


@moved.register
def _(rays: Rays, by):
    return rays._replace(rig=moved(rays.rig, by))


@moved.register
def _(subject: Subject, by):
    limbs = subject.capsules
    return replace(subject, xyz=subject.xyz + by, capsules=moved(limbs, by))


@moved.register
def _(limbs: Capsules, by):
    return replace(limbs, a=limbs.a + by, b=limbs.b + by)


@moved.register
def _(sticks: Sticks, by):
    return replace(sticks, centre=sticks.centre + by)


def leaves(value, name="answer"):
    """All numbers, texts and arrays of a nested record, with the way to each."""
    if isinstance(value, np.ndarray | float | int | str | bytes | bool | np.generic) or value is None:
        yield name, value
    elif is_dataclass(value) and not isinstance(value, type):
        for field in fields(value):
            yield from leaves(getattr(value, field.name), f"{name}.{field.name}")
    elif isinstance(value, Mapping):
        for key in value:
            yield from leaves(value[key], f"{name}[{key!r}]")
    elif hasattr(value, "_asdict"):
        for key, part in value._asdict().items():
            yield from leaves(part, f"{name}.{key}")
    elif isinstance(value, Sequence):
        yield f"len({name})", len(value)
        for k, part in enumerate(value):
            yield from leaves(part, f"{name}[{k}]")
    else:
        raise TypeError(f"{name} is a {type(value).__name__}, and nothing says how to compare it")


def differences(here, there, by):
    """How far a moved world's answer is from the moved answer: of places, mm, and of the rest, by its own size."""
    mm = [np.abs(b - (a + by)) for a, b in _pairs(here.places, there.places)]
    share = [
        np.abs(b - a) / max(np.abs(a[np.isfinite(a)]).max(initial=0.0), 1e-3) for a, b in _pairs(here.rest, there.rest)
    ]
    return [float(np.max([np.nanmax(d) for d in each if (~np.isnan(d)).any()], initial=0.0)) for each in (mm, share)]


def _pairs(here, there):
    """Arrays of numbers of both; whatever is not a number must be equal, and what is missing, missing in both."""
    ours, theirs = list(leaves(here)), list(leaves(there))
    assert [name for name, _ in ours] == [name for name, _ in theirs]
    for (name, a), (_, b) in zip(ours, theirs, strict=True):
        if np.asarray(a).dtype.kind == "f":
            a, b = np.asarray(a), np.asarray(b)
            assert a.shape == b.shape and np.array_equal(np.isfinite(a), np.isfinite(b)), name
            yield np.where(np.isfinite(a), a, np.nan), np.where(np.isfinite(a), b, np.nan)
        else:
            np.testing.assert_array_equal(a, b, err_msg=name)
