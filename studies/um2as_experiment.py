"""How the errors of centroids travel through UM²AS: the experiment of its thesis (chapter 4) in a laboratory like it.

The laboratory is put together from what the thesis prints (lengths there in cm, here in mm): the eight control balls of
the .msr file of figure 3.5; three cameras along X, Y and Z, 2.4 m from the point where their axes meet (2.3.1), here
the middle of the balls. The eleven parameters of table 4.2 are those of a camera with focal lengths of 1082 and 1286
px, 2.2 m from the balls, so all cameras are given these, and images of 512 × 512. Their ratio, 0.841,
is the aspect ratio of section 4.1: the parameters were found from images that were not corrected for it.

An error of the control balls' centroids changes the parameters by (UM²AS eq. 4.11)

    e_L = 100 |L' − L| / |L|  %                                          (1)

and errors of a marker's centroids, of its parameters, or of both move it by d = |X' − X| (2) and (eq. 4.12)

    e_X = 100 |X' − X| / |X|  %                                          (3)

(1) adds px², px²/mm² and 1/mm²; L4 and L8, in px, hold more than 99 % of |L|², so that (1) says where the image of the
world's origin goes and hardly anything else. (3) depends on where the origin is. (2) depends on neither, and is to be
preferred. X is the mean of the pairs of cameras that agree (`reconstruct.pairs`; UM²AS 2.4).

To first order markers have the errors of `um2as_equations` (7), with the errors of all control balls' centroids as what
frames share, which (5) there takes to parameters (4); `kinemark.sensitivity` takes them on to angles and means.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from um2as_equations import check_points, fit_parameters, pair_points, parameter_gain, point_gains
from um2as_equations import project as project_dlt
from um2as_sampling import Error, Sampled, Sampling, circle, climb, sample

from kinemark.data import KinemarkError
from kinemark.data.array_types import Floats
from kinemark.geometry import to_dlt
from kinemark.reconstruct.camera_pairs import agreeing
from kinemark.sensitivity import Spread

CONTROL_BALLS = 10.0 * np.array(
    [
        [72.2, 40.5, -6.4],
        [60.0, 31.8, 31.5],
        [63.6, 5.8, 59.5],
        [46.8, 16.8, -7.5],
        [21.0, 5.7, 73.9],
        [13.7, 46.7, 37.8],
        [48.3, 72.3, 62.2],
        [32.5, 31.2, 58.9],
    ]
)
"""(8, 3) mm, the .msr file of figure 3.5; of the thesis."""

PER_MM = np.array([0.1, 0.1, 0.1, 1.0, 0.1, 0.1, 0.1, 1.0, 0.1, 0.1, 0.1])
"""Turns parameters for cm into those for mm; by definition."""

TABLE_4_2 = PER_MM * np.array(
    [
        *(-0.9359012, 4.0529704, 0.0655944, 94.7372513),
        *(-0.8824302, 0.0630595, -4.8949742, 410.1895447),
        *(-0.0037763, -0.0001727, -0.0001233),
    ]
)
"""(11) the thesis' actual parameters of camera 1."""

PERTURBED_4_2 = PER_MM * np.array(
    [
        *(-0.9164725, 4.1039071, 0.0780605, 93.3254852),
        *(-0.8767406, 0.0625963, -4.9290571, 412.7666931),
        *(-0.0036892, -0.0001282, -0.0000876),
    ]
)
"""(11) the same after the largest of a million perturbations; of the thesis."""

DISTANCE_MM = 2400.0  # mm from camera to the balls; of the thesis' laboratory (UM²AS 4.2)
FOCAL_PX = (1082.0, 1286.0)  # px, of table 4.2 of the thesis
SIZE = (512, 512)  # px of an image; chosen for the thesis' laboratory
FROM_ORIGIN_MM = 719.0
"""|X| of the thesis' marker: 3.28 cm are 4.56 % of 71.9 cm."""

CALIBRATION_PX, MARKER_PX = 0.5, 13.0
"""The thesis' greatest errors of a control ball's and of a limb marker's centroid (4.2)."""


@dataclass(frozen=True, slots=True, eq=False)
class LinearisedErrors:
    """C linear cameras and the N control points that they were calibrated with.

    Attributes:
        names: (C) of the cameras.
        points: (N, 3) mm.
        uv: (C, N, 2) px where the cameras see the points.
        L: (C, 11) the parameters that follow.
    """

    names: tuple[str, ...]
    points: Floats
    uv: Floats
    L: Floats = field(init=False)

    def __post_init__(self) -> None:
        check_points(self.points)
        if self.uv.shape != (len(self.names), len(self.points), 2) or not np.isfinite(self.uv).all():
            raise ValueError(
                f"uv has shape {self.uv.shape} with {(~np.isfinite(self.uv)).sum()} unknown values; wanted "
                f"({len(self.names)}, {len(self.points)}, 2), all known"
            )
        object.__setattr__(self, "L", fit_parameters(self.points, self.uv))

    @classmethod
    def of_parameters(cls, L: Floats, points: Floats = CONTROL_BALLS) -> LinearisedErrors:
        """One camera of printed parameters (11)."""
        return cls(("printed",), points, project_dlt(L, points)[None])


class Moved(NamedTuple):
    """How far a marker moved in every sample: mm by (2), percent by (3); the largest, and the largest possible."""

    sampled: Sampled
    mm: Floats
    percent: Floats
    max_mm: float
    max_percent: float


class Changed(NamedTuple):
    """Percent by (1) in every sample; the largest sampled, and the largest possible with its parameters L (11)."""

    sampled: Sampled
    percent: Floats
    max_percent: float
    max_L: Floats


def laboratory(points: Floats = CONTROL_BALLS) -> LinearisedErrors:
    """The three cameras, along X, along Y and from the ceiling, and the control points (N, 3) mm that they see."""
    target = (points.min(0) + points.max(0)) / 2
    cx = (np.array(SIZE) - 1) / 2
    K = np.array([[FOCAL_PX[0], 0.0, cx[0]], [0.0, FOCAL_PX[1], cx[1]], [0.0, 0.0, 1.0]])
    L = []
    for R in _rotations():
        centre = target - DISTANCE_MM * R[2]
        L.append(to_dlt(K @ np.column_stack([R, -R @ centre])))
    return LinearisedErrors(
        ("camera 1", "camera 2", "camera 3"), points, np.stack([project_dlt(each, points) for each in L])
    )


def _rotations() -> Floats:
    """(3, 3, 3) world → camera, v downwards in the images: looking along −X, −Y and down."""
    forward, down = -np.eye(3), np.array([[0.0, 0.0, -1.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]])
    return np.stack([np.cross(down, forward), down, forward], 1)


def marker(cameras: LinearisedErrors, distance: float = FROM_ORIGIN_MM) -> Floats:
    """(3) mm the thesis' marker: on the line from the origin through the middle of the control points."""
    centre = (cameras.points.min(0) + cameras.points.max(0)) / 2
    return np.asarray(centre * distance / np.linalg.norm(centre))


def calibration_error(cameras: LinearisedErrors, c: int, radius: float) -> Error:
    """e_L (S) % by (1) of angles (S, N): every control point of camera c moved by `radius` px."""
    _check_radius(radius)
    L, size = cameras.L[c], np.linalg.norm(cameras.L[c])

    def error(theta: Floats) -> Floats:
        moved = fit_parameters(cameras.points, cameras.uv[c] + circle(theta, radius))
        return np.asarray(100 * np.linalg.norm(moved - L, axis=1) / size)  # (1)

    return error


def calibration_experiment(
    cameras: LinearisedErrors,
    c: int,
    *,
    radius: float = CALIBRATION_PX,
    method: Sampling = Sampling(),  # noqa: B008  frozen
) -> Changed:
    """UM²AS 4.3.1: how far the parameters of camera c go, by (1).

    Raises:
        ValueError: the radius is not positive, or the samples have no solution.
    """
    error = calibration_error(cameras, c, radius)
    found = sample(error, len(cameras.points), method)
    theta = climb(error, found.starts, turn=method.turn, seed=method.seed)
    largest = fit_parameters(cameras.points, cameras.uv[c] + circle(theta, radius))
    return Changed(found, found.error, float(error(theta[None])[0]), largest)


def marker_error(
    cameras: LinearisedErrors, place: Floats, radius: float, *, L: Floats | None = None, calibration_radius: float = 0.0
) -> Error:
    """d (S) mm by (2) of angles (S, D): the marker's centroids moved by `radius` px.

    Args:
        cameras: as calibrated without error.
        place: (3) mm, where the marker is.
        radius: px, of the marker's centroids; D = C.
        L: (C, 11) wrong parameters that all samples share; the right ones where None.
        calibration_radius: px; above 0 every sample has its own calibration, from control points moved by this: the
            angles of camera after camera follow those of the marker, D = C + C N.
    """
    _check_radius(radius)
    n = len(cameras.L)
    seen = np.stack([project_dlt(each, place[None])[0] for each in cameras.L])
    actual = pairs_mean(cameras.L, seen[None])[0]

    def error(theta: Floats) -> Floats:
        used = cameras.L if L is None else L
        if calibration_radius > 0:
            turned = theta[:, n:].reshape(len(theta), *cameras.uv.shape[:2])
            used = np.stack(
                [
                    fit_parameters(cameras.points, cameras.uv[c] + circle(turned[:, c], calibration_radius))
                    for c in range(n)
                ],
                1,
            )
        return np.linalg.norm(pairs_mean(used, seen + circle(theta[:, :n], radius)) - actual, axis=1)  # (2)

    return error


def pairs_mean(L: Floats, uv: Floats) -> Floats:
    """(S, 3) mm the mean of the pairs that agree, of images (S, C, 2), by parameters (C, 11) or (S, C, 11)."""
    each = pair_points(L, uv)
    kept = agreeing(each, np.isfinite(uv[..., 0]).sum(1))
    return np.where(kept[..., None], each, 0.0).sum(1) / kept.sum(1)[:, None]


def marker_experiment(
    cameras: LinearisedErrors,
    place: Floats,
    *,
    radius: float = MARKER_PX,
    L: Floats | None = None,
    calibration_radius: float = 0.0,
    method: Sampling = Sampling(),  # noqa: B008  frozen
) -> Moved:
    """UM²AS 4.3.2: how far a marker at `place` (3) mm moves, by (2) and (3); arguments as of `marker_error`.

    Raises:
        KinemarkError: fewer than two cameras, or a marker at the world's origin, where (3) is not defined.
        ValueError: the radius is not positive, or samples have no solution.
    """
    if len(cameras.L) < 2:
        raise KinemarkError(f"A marker's place needs two cameras, and there is {len(cameras.L)}.")
    size = float(np.linalg.norm(place))
    if not size > 0:
        raise KinemarkError("The marker is at the world's origin, where an error in percent of |X| is not defined.")
    error = marker_error(cameras, place, radius, L=L, calibration_radius=calibration_radius)
    directions = len(cameras.L) * (1 + (len(cameras.points) if calibration_radius > 0 else 0))
    found = sample(error, directions, method)
    largest = float(error(climb(error, found.starts, turn=method.turn, seed=method.seed)[None])[0])
    return Moved(found, found.error, 100 * found.error / size, largest, 100 * largest / size)  # (3)


def linear_points(cameras: LinearisedErrors, xyz: Floats, *, centroid_sd: float, calibration_sd: float) -> Spread:
    """Markers (M, F, 3) mm by the means of all pairs of linear cameras, as UM²AS has them (4).

    Args:
        cameras: calibrated with control balls.
        xyz: (M, F, 3) mm, seen by all cameras.
        centroid_sd: of a marker's centroid along u and along v, px.
        calibration_sd: of a control ball's, px.

    Raises:
        ValueError: a standard deviation is negative.
    """
    if not (centroid_sd >= 0 and calibration_sd >= 0):
        raise ValueError(f"centroid_sd is {centroid_sd} and calibration_sd {calibration_sd} px, wanted 0 or more")
    flat = xyz.reshape(-1, 3)
    images, parameters = point_gains(cameras.L, flat)
    gain = [parameter_gain(cameras.points, uv) for uv in cameras.uv]
    by = np.concatenate([parameters[:, :, c] @ gain[c] for c in range(len(gain))], 2)  # (4)
    H = images.reshape(len(flat), 3, -1)
    own = centroid_sd**2 * H @ H.swapaxes(-1, -2)
    return Spread(own.reshape(*xyz.shape, 3), by.reshape(*xyz.shape, -1), calibration_sd**2 * np.eye(by.shape[2]))


def _check_radius(radius: float) -> None:
    if not 0 < radius < np.inf:
        raise ValueError(f"radius is {radius} px, wanted more than 0")
