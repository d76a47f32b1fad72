"""Cameras and the rig they form.

A world point X (mm) is seen by a camera at pixel (u, v):

    x_cam = R X + t                      world → camera, mm                            (1)
    (x, y) = x_cam[:2] / x_cam[2]        normalised image plane                        (2)
    (x', y') = lens(x, y; k1 k2 p1 p2 k3)   OpenCV's radial and tangential terms       (3)
    (u, v, 1) = K (x', y', 1)            px; (0, 0) is the centre of the top-left pixel  (4)

K[1, 1] is negative where the digitiser counts v upwards, so that R stays a rotation.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from .array_types import Floats, Ints
from .arrays import column, set_columns
from .short_repr import ShortRepr

PARAMETERS = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "rx", "ry", "rz", "tx", "ty", "tz")
"""Order of the camera parameters in `Rig.cov`; (rx, ry, rz) is a small turn about the camera's own
axes, R ← exp([r]×) R, in rad; t in mm; the others as in K (px) and the lens terms."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Camera(ShortRepr):
    """One camera.

    Attributes:
        name: its name in the session and in the files.
        size: (2,) image width and height, px; (0, 0) where unknown.
        K: (3, 3) upper triangular, K[2, 2] = 1, px.
        distortion: (5,) k1 k2 p1 p2 k3.
        R: (3, 3) rotation world → camera.
        t: (3,) translation world → camera, mm.
        cov: (15, 15) covariance of `PARAMETERS`; zero rows for those held fixed, all zero where unknown.
        residual: RMS reprojection error of its calibration, px; NaN where unknown.
        common: (15, k) what k independent errors of unit variance, which all cameras of a calibration have in common,
            change of `PARAMETERS`: two cameras a, b have the covariance a.common @ b.common.T between them. `cov` has
            its share of them. k is 0 where nothing of that is known.
    """

    name: str
    size: Ints
    K: Floats
    R: Floats
    t: Floats
    distortion: Floats = field(default_factory=lambda: np.zeros(5))
    cov: Floats = field(default_factory=lambda: np.zeros((15, 15)))
    residual: float = float("nan")
    common: Floats = field(default_factory=lambda: np.zeros((15, 0)))

    def __post_init__(self) -> None:
        set_columns(
            self,
            size=column("size", self.size, np.int64, 2),
            K=column("K", self.K, np.float64, 3, 3),
            R=column("R", self.R, np.float64, 3, 3),
            t=column("t", self.t, np.float64, 3),
            distortion=column("distortion", self.distortion, np.float64, 5),
            cov=column("cov", self.cov, np.float64, 15, 15),
            common=column("common", self.common, np.float64, 15, None),
        )
        if not np.isfinite(self.K).all() or abs(self.K[2, 2] - 1) > 1e-9 or self.K[0, 0] * self.K[1, 1] == 0:
            raise ValueError(f"camera {self.name}: K must be finite with K[2, 2] = 1 and focal lengths, found {self.K}")
        bounded = (np.abs(self.R) < 2).all()  # false for NaN as well
        if not bounded or np.abs(self.R @ self.R.T - np.eye(3)).max() > 1e-6 or np.linalg.det(self.R) < 0:
            raise ValueError(f"camera {self.name}: R must be a rotation, found {self.R}")

    @property
    def P(self) -> Floats:
        """(3, 4) projection of homogeneous world points, mm, to pixels of an ideal lens."""
        return self.K @ np.column_stack([self.R, self.t])

    @property
    def centre(self) -> Floats:
        """(3,) the optical centre in the world, mm."""
        return -self.R.T @ self.t


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Rig(ShortRepr):
    """Calibrated cameras in one world.

    Attributes:
        cameras: the cameras, in the session's order.
        method: how the rig was calibrated, in words; empty where unknown.
        volume: (2, 3) least and greatest corner of the control volume, mm; NaN where not given.
    """

    cameras: tuple[Camera, ...]
    method: str = ""
    volume: Floats = field(default_factory=lambda: np.full((2, 3), np.nan))

    def __post_init__(self) -> None:
        set_columns(self, cameras=tuple(self.cameras), volume=column("volume", self.volume, np.float64, 2, 3))
        if len(set(self.names)) != len(self.names):
            raise ValueError(f"camera names must differ, found {self.names}")
        if len(found := {camera.common.shape[1] for camera in self.cameras} - {0}) > 1:
            raise ValueError(f"cameras have {sorted(found)} errors in common, wanted those of one calibration")

    def __len__(self) -> int:
        return len(self.cameras)

    def __iter__(self) -> Iterator[Camera]:
        return iter(self.cameras)

    def __getitem__(self, c: int) -> Camera:
        return self.cameras[c]

    @property
    def names(self) -> tuple[str, ...]:
        """The cameras' names (C)."""
        return tuple(camera.name for camera in self.cameras)

    @property
    def has_common_errors(self) -> bool:
        """Whether it is known what the calibration's errors of the cameras have in common."""
        return any(camera.common.size for camera in self.cameras)

    @property
    def P(self) -> Floats:
        """(C, 3, 4) projections for ideal lenses, px from mm."""
        return np.array([camera.P for camera in self.cameras]).reshape(-1, 3, 4)

    @property
    def centres(self) -> Floats:
        """(C, 3) optical centres, mm."""
        return np.array([camera.centre for camera in self.cameras]).reshape(-1, 3)

    def select(self, names: Sequence[str]) -> Rig:
        """The rig of these cameras, in this order.

        Raises:
            ValueError: a name is not in the rig.
        """
        missing = [name for name in names if name not in self.names]
        if missing:
            raise ValueError(f"cameras {missing} are not in the calibration, which has {list(self.names)}")
        return Rig(tuple(self.cameras[self.names.index(name)] for name in names), self.method, self.volume)

    def as_known(self) -> Rig:
        """The rig as if its cameras were known exactly."""
        known = tuple(replace(c, cov=np.zeros((15, 15)), common=np.zeros((15, 0))) for c in self.cameras)
        return replace(self, cameras=known)
