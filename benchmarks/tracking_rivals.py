"""Other packages that make tracks, driven with the scenes of `tracking.py`: OpenPTV's `optv` and `trackpy`.

**optv** (OpenPTV, particle tracking in fluids, C) matches the images of at most four cameras along epipolar segments
into quadruplets, triplets and pairs, places the points, and has a tracker of its own that reads all of that from files.
Its cameras look along their −z and its sensors are in mm, so with our R and pixels of `PIXEL` mm

    Dᵀ = diag(1, −1, −1) R Wᵀ,    (ω, φ, κ) from D = R_x(ω) R_y(φ) R_z(κ)                (1)

and the lens is undone beforehand. An epipolar segment is the part of a ray between two planes of constant z, so rays
must not run along them: the world is turned by W so that no camera looks along its planes (2).

**trackpy** links points of successive frames to the nearest ones; here points that Kinemark has matched and placed,
with `memory` and with the length below which tracks are dropped (`filter_stubs`) as those of Kinemark's own ladder.
With its predictor it looks about where a point's neighbours' velocity brings it.

What either wants to be told was chosen by trial on two of the scenes, for its sake. Most of the time
of `optv` goes into files and into handing over images one by one, which its package wants.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from kinemark.data import Cloud, Detections, Rig, Tracks
from kinemark.data.array_types import Floats, Ints
from kinemark.geometry import undistort
from kinemark.match import EpipolarTriplets, match
from kinemark.reconstruct import reconstruct

SPEED = 5000.0  # mm/s; of the fastest marker, as a track begins without a prediction; 4000 loses feet
SHORTEST = 10  # points of a track
MEMORY, LONG_MEMORY = 0.04, 0.1  # s; without and with prediction
PIXEL = 0.01  # mm
BAND = 0.5  # px beside an epipolar segment
ACCELERATION = 100_000.0  # mm/s²; more finds a little more and swaps, less finds less
DEPTH = 1300.0  # mm before and behind the middle of the volume


# ---- trackpy ----


def trackpy_nearest(detections: Detections, rig: Rig) -> Tracks:
    """`trackpy.link` on our points."""
    import trackpy

    trackpy.quiet()
    cloud = our_points(detections, rig)
    return linked(trackpy.link(table(cloud), **limits(cloud)), cloud)


def trackpy_predicted(detections: Detections, rig: Rig) -> Tracks:
    """The same with trackpy's predictor."""
    import pandas
    import trackpy

    trackpy.quiet()
    cloud = our_points(detections, rig)
    points = table(cloud)
    frames = [points[points.frame == f] for f in range(cloud.n_frames)]
    predictor = trackpy.predict.NearestVelocityPredict()
    return linked(pandas.concat(predictor.link_df_iter(frames, **limits(cloud, LONG_MEMORY))), cloud)


def our_points(detections: Detections, rig: Rig) -> Cloud:
    """Matched so that no image serves two points, as a linker cannot know that of two such points one is a ghost."""
    return reconstruct(match(detections, rig, method=EpipolarTriplets(pairs="best")), detections, rig)


def table(cloud: Cloud) -> Any:
    """The points as trackpy wants them."""
    import pandas

    columns = dict(zip("xyz", cloud.xyz.T, strict=True))
    return pandas.DataFrame({**columns, "frame": cloud.frame, "row": np.arange(len(cloud))})


def limits(cloud: Cloud, memory: float = MEMORY) -> dict[str, Any]:
    """The parameters of linking."""
    return {
        "search_range": SPEED / cloud.rate,
        "memory": round(memory * cloud.rate),
        "pos_columns": ["x", "y", "z"],
        "adaptive_stop": 1.0,
        "adaptive_step": 0.9,
    }


def linked(found: Any, cloud: Cloud) -> Tracks:
    """Tracks from trackpy's table, the short ones dropped."""
    identity = np.full(len(cloud), -1)
    identity[found["row"].to_numpy()] = found["particle"].to_numpy()
    return without_stubs(identity, cloud)


def without_stubs(identity: Ints, cloud: Cloud) -> Tracks:
    """Tracks of `SHORTEST` points and more, numbered anew."""
    named = identity >= 0
    short = np.bincount(identity[named], minlength=1) < SHORTEST
    identity = np.where(named & ~short[np.maximum(identity, 0)], identity, -1)
    kept = identity >= 0
    identity[kept] = np.unique(identity[kept], return_inverse=True)[1]
    return Tracks(cloud, identity)


# ---- OpenPTV ----


class Ptv:
    """Cameras and parameters of OpenPTV for a rig."""

    def __init__(self, rig: Rig, rate: float) -> None:
        from optv.parameters import ControlParams, TrackingParams, VolumeParams

        self.rig = rig
        self.turn, self.middle = turned(rig)
        size = tuple(int(x) for x in rig[0].size)
        self.control = ControlParams(
            len(rig),
            flags=["hp"],
            image_size=size,
            pixel_size=(PIXEL, PIXEL),
            cam_side_n=1.0,
            wall_ns=[1.0],
            wall_thicks=[1.0],
            object_side_n=1.0,
        )
        self.volume = VolumeParams(
            x_span=[-DEPTH, DEPTH],
            z_spans=[[-DEPTH, DEPTH], [-DEPTH, DEPTH]],
            pixels_tot=0.0,
            pixels_x=0.0,
            pixels_y=0.0,
            ref_gray=0.0,
            epipolar_band=BAND * PIXEL,
            min_correlation=0.0,
        )
        reach = SPEED / rate
        self.tracking = TrackingParams(
            velocity_lims=[[-reach, reach]] * 3,
            accel_lim=ACCELERATION / rate**2 + 5.0,
            angle_lim=200.0,
            add_particle=0,
        )
        self.cameras = [self._camera(c) for c in range(len(rig))]

    def _camera(self, c: int) -> Any:
        """(1); behind glass of air, as all straight lines go through that."""
        from optv.calibration import Calibration

        camera = self.rig[c]
        D = self.turn @ camera.R.T @ np.diag([1.0, -1.0, -1.0])
        at = self.turn @ (camera.centre - self.middle)
        angles = np.array([np.arctan2(-D[1, 2], D[2, 2]), np.arcsin(D[0, 2]), np.arctan2(-D[0, 1], D[0, 0])])
        (cx, cy), (w, h) = camera.K[:2, 2], camera.size
        inner = np.array([cx - w / 2, h / 2 - cy, camera.K[0, 0]]) * PIXEL
        glass = D[:, 2] * (D[:, 2] @ at - 500.0)
        return Calibration(at, angles, inner, np.zeros(3), np.zeros(2), np.array([1.0, 0.0]), glass)


def turned(rig: Rig) -> tuple[Floats, Floats]:
    """W and the middle of the rig: of many directions the one for z that no camera looks across (2)."""
    ahead = np.array([camera.R[2] for camera in rig])
    z = np.random.default_rng(0).normal(size=(5000, 3))
    z /= np.linalg.norm(z, axis=1, keepdims=True)
    best = z[np.abs(z @ ahead.T).min(1).argmax()]
    x = np.cross(best, np.eye(3)[np.abs(best).argmin()])
    x /= np.linalg.norm(x)
    across = np.eye(3) - ahead[:, :, None] * ahead[:, None]
    middle = np.linalg.solve(across.sum(0), (across @ rig.centres[..., None]).sum(0)[:, 0])
    return np.stack([x, np.cross(best, x), best]), middle


def openptv(detections: Detections, rig: Rig) -> Tracks:
    """OpenPTV's correspondences, points and tracker."""
    from optv.parameters import SequenceParams
    from optv.tracker import Tracker

    ptv = Ptv(rig, detections.rate)
    with inside_new_folder():
        names = [f"camera{c}." for c in range(len(rig))]
        cloud = ptv_points(detections, ptv, names)
        sequence = SequenceParams(image_base=names, frame_range=(FIRST, FIRST + cloud.n_frames - 1))
        naming = {"corres": b"points", "linkage": b"links", "prio": b"added"}
        with silent():
            Tracker(ptv.control, ptv.volume, ptv.tracking, sequence, ptv.cameras, naming).full_forward()
        return without_stubs(read_links(cloud), cloud)


def openptv_trackpy(detections: Detections, rig: Rig) -> Tracks:
    """OpenPTV's correspondences and points, linked by trackpy."""
    import trackpy

    trackpy.quiet()
    cloud = ptv_points(detections, Ptv(rig, detections.rate), [])
    return linked(trackpy.link(table(cloud), **limits(cloud)), cloud)


FIRST = 10001  # frame in the files' names


def ptv_points(detections: Detections, ptv: Ptv, names: list[str]) -> Cloud:
    """The points of all frames; written to files too, under these names of cameras, where there are any."""
    from optv.correspondences import MatchedCoords, correspondences
    from optv.orientation import point_positions

    uv = ideal(detections, ptv.rig)
    views, points = [], []
    for f in range(detections.n_frames):
        rows = [np.arange(len(uv))[detections.rows(c, f)] for c in range(len(ptv.rig))]
        rows = [row[np.argsort(uv[row, 1])] for row in rows]  # its tracker takes for granted that v rises
        targets = [target_array(uv[row]) for row in rows]
        flat = [MatchedCoords(t, ptv.control, cal) for t, cal in zip(targets, ptv.cameras, strict=True)]
        _, groups, _ = correspondences(targets, flat, ptv.cameras, ptv.volume, ptv.control)
        ids = np.concatenate(groups, axis=1)
        metric = np.array([own.get_by_pnrs(i) for own, i in zip(flat, ids, strict=True)])
        xyz = point_positions(metric.transpose(1, 0, 2).copy(), ptv.control, ptv.cameras, ptv.volume)[0]
        views.append(np.stack([np.append(row, -1)[i] for row, i in zip(rows, ids, strict=True)], 1))
        points.append(xyz.reshape(-1, 3))
        if names:
            write_frame(f, xyz, ids, targets, names)
    n = np.array([len(xyz) for xyz in points])
    xyz = np.concatenate(points) @ ptv.turn + ptv.middle
    return Cloud(
        rate=detections.rate,
        start=np.concatenate([[0], np.cumsum(n)]),
        xyz=xyz,
        cov=np.full((len(xyz), 3, 3), np.nan),
        residual=np.full(len(xyz), np.nan),
        detection=np.concatenate(views),
    )


def ideal(detections: Detections, rig: Rig) -> Floats:
    """(D, 2) pixels without the lens."""
    uv = np.empty_like(detections.uv)
    for c, camera in enumerate(rig):
        own = slice(detections.start[c, 0], detections.start[c, -1])
        uv[own] = undistort(camera, detections.uv[own])
    return uv


def target_array(uv: Floats) -> Any:
    """Images of one camera and frame, all alike but for their places."""
    from optv.tracking_framebuf import TargetArray

    targets = TargetArray(len(uv))
    for i, at in enumerate(uv):
        targets[i].set_pos(at)
        targets[i].set_pnr(i)
        targets[i].set_pixel_counts(25, 5, 5)
        targets[i].set_sum_grey_value(1000)
    return targets


def write_frame(f: int, xyz: Floats, ids: Ints, targets: list[Any], names: list[str]) -> None:
    """The files of one frame that OpenPTV's tracker reads."""
    for c, (own, name) in enumerate(zip(targets, names, strict=True)):
        at = {int(i): k for k, i in enumerate(ids[c]) if i >= 0}
        lines = [f"{i:4d} {t.pos()[0]:9.4f} {t.pos()[1]:9.4f} 25 5 5 1000 {at.get(i, -1)}" for i, t in enumerate(own)]
        Path(f"{name}{FIRST + f:04d}_targets").write_text("\n".join([str(len(own)), *lines, ""]))
    columns = np.pad(ids, ((0, 4 - len(ids)), (0, 0)), constant_values=-1).T
    lines = [
        f"{k + 1:4d} {x:9.3f} {y:9.3f} {z:9.3f} " + " ".join(f"{i:4d}" for i in row)
        for k, ((x, y, z), row) in enumerate(zip(xyz, columns.tolist(), strict=True))
    ]
    Path(f"points.{FIRST + f}").write_text("\n".join([str(len(xyz)), *lines, ""]))


def read_links(cloud: Cloud) -> Ints:
    """(P) identities from the links that OpenPTV's tracker wrote: of each point, the one before it or −1."""
    identity, n = np.full(len(cloud), -1), 0
    for f in range(cloud.n_frames):
        rows = np.arange(len(cloud))[cloud.rows(f)]
        lines = Path(f"links.{FIRST + f}").read_text().splitlines()[1:]
        for row, line in zip(rows, lines, strict=True):
            before = int(line.split()[0])
            if before >= 0:
                identity[row] = identity[cloud.start[f - 1] + before]
            else:
                identity[row], n = n, n + 1
    return identity


@contextmanager
def inside_new_folder() -> Iterator[None]:
    """Work in a folder of its own, as OpenPTV's names of files are short."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            yield
        finally:
            os.chdir(before)


@contextmanager
def silent() -> Iterator[None]:
    """Without what C prints."""
    kept = os.dup(1)
    with Path(os.devnull).open("w") as nowhere:
        os.dup2(nowhere.fileno(), 1)
        try:
            yield
        finally:
            os.dup2(kept, 1)
            os.close(kept)


class Rival(NamedTuple):
    """What runs, the packages it needs, and how many cameras it can take."""

    run: Callable[[Detections, Rig], Tracks]
    needs: tuple[str, ...]
    most_cameras: int = 1000

    @property
    def absent(self) -> list[str]:
        """Packages that are not installed."""
        return [package for package in self.needs if not find_spec(package)]


RIVALS = {
    "trackpy.link on our points": Rival(trackpy_nearest, ("trackpy",)),
    "trackpy with predictor on our points": Rival(trackpy_predicted, ("trackpy",)),
    "optv": Rival(openptv, ("optv",), 4),
    "optv, trackpy.link": Rival(openptv_trackpy, ("optv", "trackpy"), 4),
}
