"""The flow of UM²AS: control balls → cameras → digitised centroids → places → angles, each step from and to its files.

    calibrate     .msr and eight centroids of one camera      → .cp1            2.3.3, 2.4, B.1–B.8
    digitise      images of one camera, .rf1                  → .da1            3.5
    coordinates   .cp1 .cp2 … and .da1 .da2 …                 → .tdc            2.4, B.9–B.13, figure 2.9
    angles        .tdc                                        → .shd .elb .wst  A.9–A.36

Each step is a function of data, `calibrated`, `placed` and `limb_angles`, and one of files round it. In between all is
in Kinemark's records: mm, NaN for what is not there, a covariance on every place.

The files do not say how many frames there are a second; UM²AS takes all 30 of its video, or every other one.
"""

from __future__ import annotations

from collections.abc import Sequence
from datetime import date
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from ...calibrate import Dlt, calibrate_control_points
from ...data import Angles, KinemarkError, Rig, Trajectories
from ...data.array_types import Floats
from ...data.method import Method
from ...digitise import called, identified, identified_matches, identified_tracks
from ...geometry import to_dlt
from ...io.model_toml import load_model
from ...io.um2as import (
    ENDINGS,
    MM,
    PER_LENGTH,
    camera_number,
    read_angles,
    read_cp,
    read_da,
    read_da_set,
    read_msr,
    read_rf,
    read_tdc,
    trajectories_of_tdc,
    write_angles,
    write_cp,
    write_tdc,
)
from ...kinematics import InverseCosines, SignedAngles, joint_angles
from ...reconstruct import CameraPairs, reconstruct
from ...track import to_trajectories
from ..calibration.from_known_points import rig_of_cp

RATE = 30.0
"""Hz, of the video that UM²AS digitises."""

PAIRS = CameraPairs(within_volume=False)
"""As UM²AS has it: nothing is left out for where it is."""


def calibrated(names: Sequence[str], xyz: Floats, uv: Floats, *, sizes: ArrayLike | None = None) -> Rig:
    """Cameras by the eleven parameters of linear least squares (2.4), no ball left out.

    Args:
        names: (C) of the cameras.
        xyz: (N, 3) mm where the control balls were measured; six or more, UM²AS: eight.
        uv: (C, N, 2) px their centroids.
        sizes: (C, 2) px of the images, where known.

    Raises:
        KinemarkError: a camera sees fewer than six balls, or they lie in a plane; see `calibrate_control_points`.
    """
    sizes = np.zeros((len(names), 2)) if sizes is None else sizes
    balls = [f"ball {n + 1}" for n in range(len(xyz))]
    return calibrate_control_points(names, sizes, xyz, uv, method=Dlt(reject=np.inf), points=balls)


def calibrate_file(msr: Path | str, cp: Path | str, uv: Floats, *, made: date | None = None) -> tuple[Rig, Floats]:
    """From measured places and one camera's centroids (N, 2) px of the balls to its eleven parameters in a file.

    Args:
        msr: the measured places, ball 1 first.
        cp: written; ends in the camera's number, `.cp1`.
        uv: (N, 2) px in the order of the balls.
        made: the date for camera 1's file.

    Returns:
        The camera as a rig, and seen minus reprojected (N, 2), px.

    Raises:
        KinemarkError: there are not as many centroids as balls, or see `calibrated`.
    """
    xyz = read_msr(msr)
    if uv.shape != (len(xyz), 2):
        raise KinemarkError(
            f"{msr} has {len(xyz)} control balls, and {len(uv)} were digitised. Digitise all, ball 1 first."
        )
    rig = calibrated([f"cam{camera_number(cp, 'cp')}"], xyz, uv[None])
    L = to_dlt(rig.P)[0]
    write_cp(cp, L, made=made)
    homogeneous = np.column_stack([xyz, np.ones(len(xyz))]) @ rig.P[0].T
    return rig, uv - homogeneous[:, :2] / homogeneous[:, 2:]


def placed(
    rig: Rig,
    uv: Floats,
    *,
    names: Sequence[str] = (),
    rate: float = RATE,
    method: Method = PAIRS,
) -> Trajectories:
    """Places of digitised markers, by the rule of pairs or another method, with their covariance.

    Args:
        rig: C cameras, two or more.
        uv: (C, M, F, 2) px without shifts; NaN where not present.
        names: (M) of the markers; their numbers from 1 without.
        rate: frames a second, Hz.
        method: how; by default UM²AS's (2.4): each pair of cameras gives a place, and the mean of those that agree
            counts.

    Raises:
        KinemarkError: there are fewer than two cameras.
        ValueError: the arrays do not fit each other.
    """
    if len(rig) < 2:
        raise KinemarkError(f"There is {len(rig)} camera, and a place needs two that see it. Digitise another one.")
    names = names or [str(m + 1) for m in range(uv.shape[1])]
    if len(names) != uv.shape[1]:
        raise ValueError(f"there are {len(names)} names, wanted one for each of {uv.shape[1]} markers")
    seen = identified(uv, cameras=rig.names, rate=rate)
    cloud = reconstruct(identified_matches(*seen), seen.detections, rig, method=method)
    return called(to_trajectories(identified_tracks(cloud, seen.marker), rig), names, uv.shape[2])


def coordinates_files(
    cps: Sequence[Path | str],
    das: Sequence[Path | str],
    tdc: Path | str,
    *,
    markers: int | None = None,
    method: Method = PAIRS,
) -> Trajectories:
    """From `.cp` and `.da` files of the same two, three or more cameras to places in a `.tdc` file.

    Args:
        cps: one a camera.
        das: one a camera.
        tdc: written.
        markers: a frame; only needed where camera 1's `.da1`, which says it, is not among the files.
        method: as in `placed`.

    Raises:
        KinemarkError: the files do not belong together; the message says which and how.
    """
    rig = rig_of_cp(cps)
    uv, numbers = read_da_set(das, markers=markers)
    have = tuple(f"cam{n}" for n in numbers)
    if have != rig.names:
        raise KinemarkError(
            f"The calibration is of {', '.join(rig.names)} and the motion of {', '.join(have)}. Name .cp and .da files "
            "of the same cameras."
        )
    trajectories = placed(rig, uv, method=method)
    write_tdc(tdc, trajectories.xyz)
    return trajectories


def limb_angles(trajectories: Trajectories, *, signed: bool = True) -> Angles:
    """Angles of shoulder, elbow and wrist from the markers 1 … 7 (A.9–A.36), deg.

    Args:
        trajectories: markers called 1 … 7, or as in the model `um2as`; others may be among them.
        signed: with their sign; else by inverse cosines, which UM²AS takes and which have none.

    Raises:
        KinemarkError: a marker of the model is not there.
    """
    method = SignedAngles() if signed else InverseCosines()
    return joint_angles(trajectories, model=load_model("um2as"), method=method)


def angles_files(tdc: Path | str, outputs: Sequence[Path | str] = (), *, signed: bool = True) -> Angles:
    """From a `.tdc` file to `.shd`, `.elb` and `.wst`, beside it where no files are named.

    Args:
        tdc: markers 1 … 7 first.
        outputs: any of the three, known by their endings.
        signed: as in `limb_angles`.

    Raises:
        KinemarkError: a file is wrong, or an ending none of the three.
    """
    paths = [Path(path) for path in outputs] or [Path(tdc).with_suffix(ending) for ending in ENDINGS.values()]
    if wrong := [path for path in paths if path.suffix.lower() not in ENDINGS.values()]:
        raise KinemarkError(f"{wrong[0]} does not end in {', '.join(ENDINGS.values())}. Name it after its joint.")
    angles = limb_angles(trajectories_of_tdc(tdc, rate=RATE), signed=signed)
    joint = {ending: name for name, ending in ENDINGS.items()}
    for path in paths:
        write_angles(path, angles.deg[angles.joints.index(joint[path.suffix.lower()])])
    return angles


def euler_files(angles: Angles, stem: Path | str) -> list[Path]:
    """Write the angles of shoulder, elbow and wrist to `.shd`, `.elb` and `.wst` beside each other.

    Args:
        angles: of `limb_angles`, or of any model with these joints.
        stem: path of the files without their endings.

    Raises:
        KinemarkError: one of the joints is not there, or a file cannot be written.
    """
    if absent := [name for name in ENDINGS if name not in angles.joints]:
        have = ", ".join(angles.joints)
        raise KinemarkError(f"Euler files are of shoulder, elbow and wrist; {', '.join(absent)} is not among {have}.")
    written = {name: Path(f"{stem}{ending}") for name, ending in ENDINGS.items()}
    for name, path in written.items():
        write_angles(path, angles.deg[angles.joints.index(name)])
    return [*written.values()]


def table(file: Path | str, *, markers: int | None = None) -> tuple[str, list[tuple[float | int, ...]]]:
    """Any of the files as a heading and rows to show, lengths in the file's cm; rows of a motion begin with the frame.

    Args:
        file: of UM²AS.
        markers: a frame, for the `.da` file of a camera other than the first.

    Raises:
        KinemarkError: the ending is of none of the files, or the file is wrong.
    """
    path, suffix = Path(file), Path(file).suffix.lower()
    if suffix == ".msr":
        return "ball\tX\tY\tZ", [(n + 1, *row) for n, row in enumerate((read_msr(path) / MM).tolist())]
    if suffix == ".tdc":
        return "frame\tmarker\tX\tY\tZ", _by_frame(read_tdc(path) / MM)
    if suffix in ENDINGS.values():
        return "frame\tz\tx'\ty''", [(f + 1, *row) for f, row in enumerate(read_angles(path).tolist())]
    if suffix.startswith(".cp"):
        made = read_cp(path).made
        rows = (read_cp(path).L * PER_LENGTH).tolist()
        return f"L\t{made or ''}".rstrip(), [(n + 1, value) for n, value in enumerate(rows)]
    if suffix.startswith(".rf"):
        return "marker\tU\tV", [(1, *read_rf(path).tolist())]
    if suffix.startswith(".da"):
        return "frame\tmarker\tU\tV", _by_frame(read_da(path, markers=markers))
    raise KinemarkError(f"{path} is none of UM²AS's files, which end in .msr .cp1 .rf1 .da1 .tdc .shd .elb .wst.")


def _by_frame(values: Floats) -> list[tuple[float | int, ...]]:
    """Rows (M, F, k) in the order of frames, with frame and marker from 1."""
    return [(f + 1, m + 1, *values[m, f].tolist()) for f in range(values.shape[1]) for m in range(values.shape[0])]
