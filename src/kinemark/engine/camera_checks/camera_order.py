"""Cameras in the wrong order, put in order.

The tracker leaves out a camera whose images fit nothing, and says which other one's place they take. Where these places
are those of the same cameras in another order, each is given the calibration of the one whose images it has (1): two
exchanged ones, several pairs, or three and more in a ring. Of a camera whose images fit nothing at all and one whose
place nobody takes, if there is one of each, the first takes the second's; two that fit nothing are each other's (2).
Whoever calls sees by tracking again whether that is so. With too few cameras left to track by, an
exchange is found by trying (`swapped_cameras`) (3). Where another pair would do as well, as in a room as symmetrical as
its cameras, nobody can tell which is right, and nothing is put in order (4).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from ...data import Cloud, Detections, Finding, Rig, make_finding
from ...data.method import Method
from ...match import MATCH
from .swapped_cameras import swapped_cameras

IN_PLACE_OF, FITS_NOTHING = "camera_takes_place_of_other", "camera_fits_nothing"
FEW = 3
"""Cameras of which two in the wrong order leave none to track by, so that the tracker names nobody; by definition."""


def images_of_others(
    findings: Sequence[Finding], detections: Detections, rig: Rig, cloud: Cloud, *, placing: Method
) -> dict[str, str]:
    """Cameras by name, and the one whose images each has instead of its own; empty where that is not so, or not sure.

    Args:
        findings: of the tracker. detections: what was tracked. rig, cloud: cameras and points of the tracks.
        placing: how points are placed where exchanges are tried.
    """
    taken = _taken(findings)
    if not taken and len(rig) > FEW:
        return {}
    swapped = swapped_cameras(detections, rig, cloud, matching=MATCH.make(), placing=placing)
    pairs = [name for one in swapped for name in one.cameras]
    if not taken and len(pairs) == 2:  # (3)
        taken = {pairs[0]: pairs[1], pairs[1]: pairs[0]}
    return taken if taken.keys() == set(taken.values()) and taken.keys() >= set(pairs) else {}  # (1), (4)


def _taken(findings: Iterable[Finding]) -> dict[str, str]:
    """Cameras by name, and the one whose place each takes."""
    taken = {one.cameras[0]: one.cameras[1] for one in findings if one.kind == IN_PLACE_OF}
    unlike = {name: None for one in findings if one.kind == FITS_NOTHING for name in one.cameras}
    open_, free = set(taken.values()) - taken.keys(), taken.keys() - set(taken.values())
    if len(open_) == len(free) == 1 and open_ <= unlike.keys():
        taken[open_.pop()] = free.pop()  # (2)
    if not taken and len(unlike) == 2:
        taken = dict(zip(unlike, reversed(unlike), strict=True))  # (2)
    return taken


def put_in_order(rig: Rig, images_of: Mapping[str, str]) -> Rig:
    """The rig, in which cameras by name have the calibration of the others."""
    by_name = {camera.name: camera for camera in rig}
    cameras = (replace(by_name[images_of.get(one.name, one.name)], name=one.name) for one in rig)
    return replace(rig, cameras=tuple(cameras))


def told_in_order(images_of: Mapping[str, str]) -> Finding:
    """What was put in order."""
    return make_finding("cameras_put_in_order", cameras=images_of, images_of_list=tuple(images_of.values()))
