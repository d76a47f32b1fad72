"""Where shall the cameras stand? A placement for a volume and a subject, and what it will measure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..calibrate.quality import points_of, volume_grid
from ..data import Camera, KinemarkError, Rig
from ..data.array_types import Bools, Floats
from ..data.progress import tell
from ..synth import Subject
from .placement import Candidates, choose, judged
from .prediction import Prediction, predict
from .room import Room, Sensor, candidates
from .sight import free_of_limbs, seen_alone, seen_on_bodies
from .subject import walks

PLACES = 250
"""Places of the volume by which cameras are chosen, about; chosen for speed."""
MOST_CAMERAS = 32
"""That are placed at once; chosen."""
METHOD = "planned: not calibrated"
"""What a planned rig says of how it was made."""


@dataclass(frozen=True, slots=True)
class Planning:
    """What is asked of the cameras.

    Attributes:
        cameras: how many there shall be, those given among them.
        diameter_mm: of the markers.
        centroid_px: standard deviation of a centroid along u and v.
        subject_mm: height of the person who walks through; 0 for none.
        markers: of that person: the fifteen of the lower limbs, or as many on the whole body.
    """

    cameras: int = 6
    diameter_mm: float = 14.0
    centroid_px: float = 0.1
    subject_mm: float = 1730.0
    markers: int = 15

    def __post_init__(self) -> None:
        if not 2 <= self.cameras <= MOST_CAMERAS:
            raise KinemarkError(f"{self.cameras} cameras are asked for, wanted 2 to {MOST_CAMERAS}.")
        wrong = [n for n in ("diameter_mm", "centroid_px") if not getattr(self, n) > 0]
        if wrong or self.subject_mm < 0:
            name = wrong[0] if wrong else "subject_mm"
            raise KinemarkError(f"{name} is {getattr(self, name)}, wanted more than 0 (a subject of 0 is none).")


class CameraPlan(NamedTuple):
    """A placement and what it will measure.

    rig: the cameras, those given first; given: how many those are; prediction: of the rig; following: the camera that
    should come next, and the prediction with it; both None where no place is left; candidates: how many were judged.
    """

    rig: Rig
    given: int
    room: Room
    sensor: Sensor
    planning: Planning
    prediction: Prediction
    following: Camera | None
    with_following: Prediction | None
    candidates: int


def plan_cameras(
    room: Room,
    sensor: Sensor,
    planning: Planning = Planning(),
    *,
    given: Rig | None = None,
) -> CameraPlan:
    """Cameras for a volume: where they should stand, what they will measure, and where one more should stand.

    Args:
        room: the volume and where cameras may stand.
        sensor: of the cameras to be placed.
        planning: how many cameras, for which markers and which subject.
        given: cameras that stand already and stay.

    Raises:
        KinemarkError: no place is left for a camera, the subject does not fit, or there are more cameras given than
            asked for.
    """
    given = Rig(()) if given is None else given
    new = planning.cameras - len(given)
    if new < 0:
        raise KinemarkError(
            f"{len(given)} cameras are given and {planning.cameras} asked for. Ask for at least {len(given)}."
        )
    bodies = _bodies(room, planning)
    xyz, weight = _sites(room, bodies)
    found = _judged_candidates(room, sensor, planning, bodies, xyz)
    stand = _judged_given(given, sensor, planning, bodies, xyz)
    chosen = choose(found, weight, new, given=stand)
    if len(chosen) < new:
        raise KinemarkError(
            f"There is place for {len(chosen)} of {new} cameras only. Allow more heights or "
            "distances, or ask for fewer."
        )
    rig = _rig(given, [found.cameras[k] for k in chosen], room)
    after = judged_with(stand, found, chosen)
    following = choose(found, weight, 1, given=after)
    more = _rig(rig, [found.cameras[k] for k in following], room) if following else None
    return CameraPlan(
        rig, len(given), room, sensor, planning,
        _predict(rig, room, sensor, planning, bodies),
        more.cameras[-1] if more else None,
        _predict(more, room, sensor, planning, bodies) if more else None,
        len(found.cameras),
    )  # fmt: skip


def _predict(rig: Rig, room: Room, sensor: Sensor, planning: Planning, bodies: Sequence[Subject]) -> Prediction:
    return predict(
        rig, room, bodies, diameter_mm=planning.diameter_mm, least_px=sensor.least_px, centroid_sd=planning.centroid_px
    )


def _bodies(room: Room, planning: Planning) -> tuple[Subject, ...]:
    if planning.subject_mm == 0:
        return ()
    found = walks(room, diameter_mm=planning.diameter_mm, height_mm=planning.subject_mm, markers=planning.markers)
    if not np.isfinite(found[0].xyz).any():
        raise KinemarkError(
            "No marker of the walking subject comes into the volume. Give a volume that reaches down to the floor "
            "that the subject walks on, or a subject of 0 mm for none."
        )
    return found


def _sites(room: Room, bodies: Sequence[Subject]) -> tuple[Floats, Floats]:
    """Places (N, 3) mm of the volume and of the bodies' markers, and the weight (N) of each; both count half."""
    grid = points_of(volume_grid(room.volume, places=PLACES))
    body = np.concatenate([*(one.xyz.reshape(-1, 3) for one in bodies), np.zeros((0, 3))])
    there = np.isfinite(body).all(1)
    part = 0.5 if there.any() else 1.0
    weight = np.concatenate([np.full(len(grid), part / len(grid)), there * 0.5 / max(there.sum(), 1)])
    return np.concatenate([grid, body]), weight


def _judged_candidates(
    room: Room, sensor: Sensor, planning: Planning, bodies: Sequence[Subject], xyz: Floats
) -> Candidates:
    """All candidates; what limbs hide depends on where a camera stands alone, and is looked at once a place."""
    cameras, seen, last, free = [], [], -1, []
    stands = list(candidates(room, sensor))
    for k, (p, camera) in enumerate(stands):
        if p != last:
            tell(k, len(stands))
            free, last = [free_of_limbs(camera.centre, body) for body in bodies], p
        view = _seen(camera, sensor, planning, bodies, free, xyz)
        if view.any():
            cameras.append(camera)
            seen.append(view)
    if not cameras:
        raise KinemarkError(
            "No camera sees a marker of that size anywhere in the volume: its image is smaller than "
            f"{sensor.least_px:g} px across. Use larger markers, a longer focal length, or nearer cameras."
        )
    return judged(cameras, np.array(seen), _finite(xyz), centroid_sd=planning.centroid_px)


def _judged_given(given: Rig, sensor: Sensor, planning: Planning, bodies: Sequence[Subject], xyz: Floats) -> Candidates:
    views = [
        _seen(camera, sensor, planning, bodies, [free_of_limbs(camera.centre, body) for body in bodies], xyz)
        for camera in given
    ]
    seen = np.array(views, np.bool_).reshape(len(given), len(xyz))
    return judged(given.cameras, seen, _finite(xyz), centroid_sd=planning.centroid_px)


def judged_with(stand: Candidates, found: Candidates, chosen: Sequence[int]) -> Candidates:
    """Cameras that stand and those chosen, as one."""
    chosen = list(chosen)
    return Candidates(
        (*stand.cameras, *(found.cameras[k] for k in chosen)),
        np.concatenate([stand.information, found.information[:, chosen]], 1),
        np.concatenate([stand.seen, found.seen[chosen]]),
        np.concatenate([stand.centres, found.centres[chosen]]),
    )


def _seen(
    camera: Camera, sensor: Sensor, planning: Planning, bodies: Sequence[Subject], free: Sequence[Bools], xyz: Floats
) -> Bools:
    """(N) which of the places of `_sites` a camera measures."""
    n = len(xyz) - sum(len(body) * body.n_frames for body in bodies)
    alone: Bools = seen_alone(camera, xyz[:n], diameter_mm=planning.diameter_mm, least_px=sensor.least_px)
    on_bodies: Bools = seen_on_bodies(camera, bodies, free, least_px=sensor.least_px)
    seen: Bools = np.concatenate([alone, on_bodies])
    return seen


def _finite(xyz: Floats) -> Floats:
    """Places that are not there as zeros, where nothing is seen."""
    there: Bools = np.asarray(np.isfinite(xyz).all(1))
    return np.where(there[:, None], xyz, 0.0)


def _rig(given: Rig, new: Sequence[Camera], room: Room) -> Rig:
    """The given cameras and the new ones, named cam1, cam2, … where that name is free, with the volume."""
    free = (name for k in range(1, 10 * MOST_CAMERAS) if (name := f"cam{k}") not in given.names)
    named = [replace(camera, name=name) for camera, name in zip(new, free, strict=False)]
    return Rig((*given.cameras, *named), METHOD if new else given.method, room.volume)
