"""More markers on a body than its model has, and several bodies in one subject."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..data.array_types import Floats
from .subjects import Capsules, Subject

MOST_TRIES = 100  # places tried for each marker; chosen


def with_markers(subject: Subject, n: int, *, apart_mm: float = 40.0, seed: int = 0) -> Subject:
    """The subject with markers added to the surface of its limbs until there are n, or the first n of its own.

    A name, as X7, is that of a place: a share of a limb and an angle about it, by the seed alone. Where a place is too
    near to another marker no marker has its name, so that in other walks all that are there are called alike.

    Args:
        subject: with limbs where markers are to be added.
        n: markers.
        apart_mm: least distance between the centres of two markers, in every frame.
        seed: of their places.

    Raises:
        ValueError: so many do not fit, or there are no limbs.
    """
    if n > len(subject) and not len(subject.capsules):
        raise ValueError(f"the subject has {len(subject)} markers and no limbs to put {n - len(subject)} more on")
    rng = np.random.default_rng(seed)
    names, xyz, radius = list(subject.names[:n]), list(subject.xyz[:n]), list(subject.radius_mm[:n])
    tries = 0
    while len(xyz) < n:
        limb = tries % len(subject.capsules)
        tries += 1
        if tries > MOST_TRIES * n:
            raise ValueError(f"{n} markers do not fit on the body {apart_mm} mm apart, only {len(xyz)} do")
        size = float(np.median(subject.radius_mm))
        path = _on_limb(subject.capsules, limb, rng.uniform(0.1, 0.9), rng.uniform(0, 2 * np.pi), size)
        if np.linalg.norm(np.array(xyz) - path, axis=-1).min(initial=np.inf) >= apart_mm:
            names.append(f"X{tries - 1}")
            xyz.append(path)
            radius.append(size)
    links = subject.links[(subject.links < n).all(1)]
    return replace(subject, names=tuple(names), xyz=np.array(xyz), radius_mm=np.array(radius), links=links)


def _on_limb(limbs: Capsules, k: int, along: float, around: float, size: float) -> Floats:
    """(F, 3) the centre of a marker that sits on limb k, at a share of its length and an angle about its axis."""
    axis = limbs.b[k] - limbs.a[k]
    z = axis / np.maximum(np.linalg.norm(axis, axis=-1, keepdims=True), 1e-9)
    across = np.eye(3)[np.abs(z).mean(0).argmin()]  # one direction for all frames, so that nothing jumps
    side = np.cross(z, across)
    side /= np.linalg.norm(side, axis=-1, keepdims=True)
    out = np.cos(around) * side + np.sin(around) * np.cross(side, z)
    return np.asarray(limbs.a[k] + along * axis + (limbs.radius[k] + size) * out)


def combined_subjects(*subjects: Subject) -> Subject:
    """Several subjects as one, their names numbered: "1 LASI", "2 LASI".

    Raises:
        ValueError: they differ in rate or number of frames.
    """
    if len({(s.rate, s.n_frames) for s in subjects}) != 1:
        raise ValueError(f"subjects differ in rate or frames: {[(s.rate, s.n_frames) for s in subjects]}")
    first = np.cumsum([0, *(len(s) for s in subjects)])
    limbs = [s.capsules for s in subjects]
    return Subject(
        tuple(f"{i} {name}" for i, s in enumerate(subjects, 1) for name in s.names),
        subjects[0].rate,
        np.concatenate([s.xyz for s in subjects]),
        np.concatenate([s.radius_mm for s in subjects]),
        Capsules(
            tuple(f"{i} {name}" for i, own in enumerate(limbs, 1) for name in own.names),
            np.concatenate([own.a for own in limbs]),
            np.concatenate([own.b for own in limbs]),
            np.concatenate([own.radius for own in limbs]),
        ),
        links=np.concatenate([s.links + n for s, n in zip(subjects, first[:-1], strict=True)]),
    )
