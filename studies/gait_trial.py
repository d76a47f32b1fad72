"""A clinical gait trial from its 2D centroids and calibration alone, against another system's labelled tracks.

The recording (BTS SMART-D, seven cameras, 250 Hz, 1686 frames) holds the 30 tracks that the system itself made. They
are a reference, not the truth, and two things about them must be known before they are compared with.

**Their lens.** The file gives a lens model x_d = x_u g(r_u), and the reference undoes it by one division, x_u ≈ x_d /
g(r_d), instead of solving for x_u. Far from the image centre this is off by a pixel. The study shows it from the
images alone: points triangulated with the exact inverse fit their own images better than points triangulated with the
division. So that identity and completeness can be compared apart from this, positions are compared twice: as each
method makes them, and as the linear solution from the same images through the reference's lens.

**Their swaps.** At some frames a reference track jumps to another marker: its second difference is 20 to 100 mm,
which at 250 Hz means thousands of m/s². Reference tracks are therefore cut where the second difference exceeds 8 mm,
and only their continuous pieces say which marker is which. A track that goes from a piece that ends there to one that
begins there has followed the marker through the reference's swap; one that leaves a piece that goes on has swapped
itself.

Points that no reference track is near are either markers that the reference has lost or ghosts, chance meetings of
images. Some lie on tracks that are a reference marker before or after. For the others a control tells them apart: of
the images that no point near a reference sample uses, each camera's are shifted in time against the other cameras', by
a second and more. What the method then makes of them it makes by chance, with as many images as before; so many of
its extra points may be ghosts, and the others are markers.

**Their merged images.** Where two markers run together in a camera, the reference takes the one image there is for a
marker's own, and is drawn away from where the other cameras see it. `gait_trial_judges` says, without any tracker,
which samples of the reference stand up, and three judges say who is right where a method differs from it by NEAR to
FARTHEST mm: the images, the path, and the distances to other markers.

Run: python studies/gait_trial.py [method …], a part of its name, or "all"; the first three where none is given.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from gait_trial_judges import (
    CLEARLY,
    NEAR,
    Disputed,
    FrameImages,
    Standing,
    judged,
    projected,
    standing,
)
from numpy.typing import NDArray
from recordings import recording

from kinemark.data import Camera, Cloud, Detections, Rig, Tracks
from kinemark.data.array_types import Floats
from kinemark.data.method import Method
from kinemark.geometry import normalised, triangulate, undistort
from kinemark.io.tdf import read_tdf
from kinemark.match import EpipolarTriplets, KissTriplets, match
from kinemark.numerics.runs import true_runs
from kinemark.reconstruct import CameraPairs, LeastSquares, reconstruct
from kinemark.signal import assign
from kinemark.synth.score import Score, changes, score
from kinemark.track import DistanceOnly, ExtrapolationLadder, KissTracking, Swamidas, track
from kinemark.track.simultaneous import Simultaneous, track_detections

JUMP = 8.0  # mm; a second difference no marker on a body has at 250 Hz (500 m/s²)
MARGIN = 3  # frames beside a jump that the reference's own smoothing has bent
SHIFT = 0.8  # s; of each camera against the one before it, for the control
FARTHEST = 30.0  # mm; of our point from a reference sample that it is another opinion of
RINGS = ((0.0, 0.2), (0.2, 0.3), (0.3, 0.4), (0.4, 1.0))


def division(camera: Camera, uv: Floats) -> Floats:
    """Ideal pixels (D, 2) as the reference makes them: the distorted point divided by g at its own radius."""
    xy = normalised(camera, uv)
    r2 = (xy**2).sum(-1, keepdims=True)
    k1, k2, *_ = camera.distortion
    return xy / (1 + k1 * r2 + k2 * r2**2) @ camera.K[:2, :2].T + camera.K[:2, 2]


OURS, THEIRS = "the exact inverse (Kinemark)", "one division (the reference)"
LENSES: dict[str, Callable[[Camera, Floats], Floats]] = {OURS: undistort, THEIRS: division}


def points(
    rig: Rig, detections: Detections, cloud: Cloud, inverse: Callable[[Camera, Floats], Floats]
) -> tuple[Floats, Floats, Floats]:
    """Points (P, 3) through a lens's inverse; their images' distance from them, px, and radius, (P, C) each."""
    ideal = np.full((len(cloud), len(rig), 2), np.nan)
    radius = np.full((len(cloud), len(rig)), np.nan)
    for c, camera in enumerate(rig):
        seen = cloud.detection[:, c] >= 0
        uv = detections.uv[cloud.detection[seen, c]]
        ideal[seen, c] = inverse(camera, uv)
        radius[seen, c] = np.linalg.norm(normalised(camera, uv), axis=-1)
    xyz = triangulate(ideal, rig.P)
    return xyz, np.linalg.norm(ideal - projected(rig, xyz), axis=-1), radius


def continuous_pieces(xyz: Floats) -> Floats:
    """Reference tracks (M, F, 3) cut at their jumps: pieces (K, F, 3), NaN outside each."""
    bend = np.zeros(xyz.shape[:2])
    bend[:, 1:-1] = np.nan_to_num(np.linalg.norm(xyz[:, 2:] - 2 * xyz[:, 1:-1] + xyz[:, :-2], axis=-1))
    bad = np.isnan(xyz[..., 0])
    for shift in range(-MARGIN, MARGIN + 1):
        bad |= np.roll(bend > JUMP, shift, axis=1)
    pieces = []
    for m in range(len(xyz)):
        for first, stop in true_runs(~bad[m]):
            piece = np.full(xyz.shape[1:], np.nan)
            piece[first:stop] = xyz[m, first:stop]
            pieces.append(piece)
    return np.array(pieces)


def extras(tracks: Tracks, near: NDArray[np.bool_]) -> tuple[float, float]:
    """Tracked points a frame that no reference sample is near: all, and those on no reference marker's track."""
    extra = (tracks.id >= 0) & ~near
    theirs = np.bincount(tracks.id[near], minlength=len(tracks)) >= tracks.lengths / 3
    strangers = extra & ~theirs[np.maximum(tracks.id, 0)]
    n = tracks.cloud.n_frames
    return float(extra.sum() / n), float(strangers.sum() / n)


def by_chance(rig: Rig, detections: Detections, tracks: Tracks, near: NDArray[np.bool_], method: TrialMethod) -> float:
    """Points a frame that the method makes of the images left over, the cameras shifted against each other."""
    used = np.zeros(len(detections), bool)
    detection = tracks.cloud.detection[near & (tracks.id >= 0)]
    used[detection[detection >= 0]] = True
    shifted = shift_cameras(detections.keep(~used), round(SHIFT * detections.rate))
    again = run(method, shifted, rig)
    return float((again.id >= 0).sum() / detections.n_frames)


def shift_cameras(detections: Detections, frames: int) -> Detections:
    """The detections with camera c moved by c times so many frames, around the end."""
    orders = [np.roll(np.arange(detections.n_frames), frames * c) for c in range(len(detections.cameras))]
    rows = [np.arange(len(detections))[detections.rows(c, f)] for c, order in enumerate(orders) for f in order.tolist()]
    counts = [detections.counts[c][order] for c, order in enumerate(orders)]
    row = np.concatenate(rows)
    cov = detections.cov[row]
    return Detections.build(detections.cameras, detections.rate, counts, detections.uv[row], cov)


def disputed(tracks: Tracks, xyz: Floats, found: Score, reference: Floats) -> Disputed:
    """Missed samples with the points (P, 3) of tracks that no sample is near, as the assignment pairs them best."""
    cloud, free = tracks.cloud, (found.owner < 0) & (tracks.id >= 0)
    missed = np.isfinite(reference[..., 0]) & ~there(tracks, found, reference)
    pairs = [np.zeros((3, 0), np.int64)]
    for f in range(cloud.n_frames):
        p = np.flatnonzero(free[cloud.start[f] : cloud.start[f + 1]]) + cloud.start[f]
        m = np.flatnonzero(missed[:, f])
        i, j = assign(np.linalg.norm(reference[m, f][:, None] - xyz[p], axis=-1), np.full(len(m), FARTHEST))
        pairs.append(np.array([m[i], np.full(len(i), f), p[j]]))
    marker, frame, point = np.concatenate(pairs, 1)
    return Disputed(marker, frame, xyz[point])


def there(tracks: Tracks, found: Score, reference: Floats) -> NDArray[np.bool_]:
    """(M, F) whether a sample is found."""
    out = np.zeros(reference.shape[:2], bool)
    near = found.owner >= 0
    out[found.owner[near], tracks.cloud.frame[near]] = True
    return out


def pieces_per_track(result: Score, reference: Floats, shortest: int = 25) -> float:
    """Mean number of our tracks on each continuous reference piece of at least 0.1 s."""
    long = np.isfinite(reference[..., 0]).sum(1) >= shortest
    return float(result.fragments[long].mean())


# ---- Methods ----


class Staged(NamedTuple):
    """Matching, reconstruction and tracking one after another."""

    matching: Method
    tracking: Method
    placing: Method = LeastSquares()


TrialMethod = Staged | Simultaneous

METHODS: dict[str, TrialMethod] = {
    "simultaneous": Simultaneous(),
    "epipolar_triplets, extrapolation_ladder": Staged(EpipolarTriplets(), ExtrapolationLadder()),
    "kiss_triplets, kiss_tracking": Staged(KissTriplets(), KissTracking()),
    "… with camera_pairs": Staged(EpipolarTriplets(), ExtrapolationLadder(), CameraPairs()),
    "epipolar_triplets, swamidas": Staged(EpipolarTriplets(), Swamidas(initiate_from="any", max_coasting=0.1)),
    "epipolar_triplets, distance_only": Staged(EpipolarTriplets(), DistanceOnly()),
}
USUAL = 3  # of these are run where none is named


def run(method: TrialMethod, detections: Detections, rig: Rig) -> Tracks:
    """From detections to tracks."""
    if isinstance(method, Simultaneous):
        return track_detections(detections, rig, method=method)
    matches = match(detections, rig, method=method.matching)
    return track(reconstruct(matches, detections, rig, method=method.placing), method=method.tracking)


# ---- The tables ----


class Row(NamedTuple):
    """What a method made: its tracks, seconds of processor, and its scores through either lens.

    placed: its points through either lens; whole: against the reference tracks; cut: against their continuous pieces.
    """

    tracks: Tracks
    seconds: float
    placed: dict[str, Floats]
    whole: dict[str, Score]
    cut: dict[str, Score]

    @property
    def near(self) -> NDArray[np.bool_]:
        """(P) points near a reference sample, through the reference's lens."""
        return self.whole[THEIRS].owner >= 0


def made(method: TrialMethod, detections: Detections, rig: Rig, reference: Floats, pieces: Floats) -> Row:
    """The row of a method."""
    began = time.process_time()
    tracks = run(method, detections, rig)
    seconds = time.process_time() - began
    linear = points(rig, detections, tracks.cloud, division)[0]
    theirs = np.where(np.isnan(linear), tracks.cloud.xyz, linear)  # one image alone has none
    placed = {OURS: tracks.cloud.xyz, THEIRS: theirs}
    whole, cut = (
        {lens: score(tracks, truth, within=NEAR, xyz=xyz) for lens, xyz in placed.items()}
        for truth in (reference, pieces)
    )
    return Row(tracks, seconds, placed, whole, cut)


def lens_table(rig: Rig, detections: Detections, cloud: Cloud) -> None:
    """Print which inverse of the lens fits the images themselves."""
    print("Which inverse of the lens fits the images themselves? Median distance from the reprojection, px,")
    print("of points that four or more cameras see, by the image's distance from the optical axis:")
    print(" " * 32 + "".join(f"{f'{a:.1f}–{b:.1f}':>10}" for a, b in RINGS))
    four = (cloud.detection >= 0).sum(1) >= 4
    for name, inverse in LENSES.items():
        _, off, radius = points(rig, detections, cloud, inverse)
        row = [np.nanmedian(off[four][(radius[four] >= a) & (radius[four] < b)]) for a, b in RINGS]
        print(f"  {name:<30}" + "".join(f"{value:10.3f}" for value in row))


HEAD = (
    f"  {'':42}{'recall':>8}{'median':>8}{'95 %':>7}{'swaps':>7}{'tracks per':>12}{'tracks per':>12}{'extra':>8}"
    f"{'strangers':>11}{'chance':>8}{'markers':>9}{'time':>7}\n"
    f"  {'':42}{'5 mm, %':>8}{'mm':>8}{'mm':>7}{'':>7}{'piece':>12}{'ref. track':>12}{'/frame':>8}"
    f"{'/frame':>11}{'/frame':>8}{'/frame':>9}{'s':>7}"
)


def line(name: str, row: Row, lens: str, pieces: Floats, chance: float) -> str:
    """The row of a table."""
    whole, cut = row.whole[lens], row.cut[lens]
    extra, strangers = extras(row.tracks, whole.owner >= 0)
    return (
        f"  {name:42}{100 * whole.recall:8.1f}{whole.median:8.2f}{whole.p95:7.2f}{cut.swaps:7d}"
        f"{pieces_per_track(cut, pieces):12.2f}{whole.fragments.mean():12.1f}{extra:8.2f}{strangers:11.2f}{chance:8.2f}"
        f"{extra - min(strangers, chance):9.2f}{row.seconds:7.2f}"
    )


def frame_images(rig: Rig, detections: Detections) -> FrameImages:
    """The images through the reference's lens."""
    ideal = np.empty_like(detections.uv)
    for c, camera in enumerate(rig):
        ideal[detections.camera == c] = division(camera, detections.uv[detections.camera == c])
    return FrameImages(ideal, detections.start)


def standing_table(stands: Standing, rows: dict[str, Row], xyz: Floats) -> None:
    """Print how many samples of the reference (M, F, 3) do not stand up, and what is found of the others."""
    known, off = np.isfinite(xyz[..., 0]), (stands.unseen, stands.elsewhere, stands.jumping)
    unseen, elsewhere, jumping = (int(which.sum()) for which in off)
    print(f"Of {known.sum()} reference samples {stands.fallen.sum()} do not stand up: {unseen} lie on no two images,")
    print(f"{elsewhere} elsewhere than most of their images, {jumping} beside a jump.")
    print("Of those that stand up, and of those that do not, so many are found, %:")
    for name, row in rows.items():
        found = there(row.tracks, row.whole[THEIRS], xyz)
        share = [100 * found[known & which].mean() for which in (~stands.fallen, stands.fallen)]
        print(f"  {name:42}{share[0]:8.2f}{share[1]:8.2f}")


def judges_table(stands: Standing, rows: dict[str, Row], xyz: Floats) -> None:
    """Print who is right where a method and the reference (M, F, 3) differ."""
    print(f"Who is right where they differ ({CLEARLY} times nearer), of the samples that a judge can tell:")
    for name, row in rows.items():
        found = row.whole[THEIRS]
        some, known = disputed(row.tracks, row.placed[THEIRS], found, xyz), there(row.tracks, found, xyz)
        for low, high in ((NEAR, 10.0), (10.0, FARTHEST)):
            for judge, said in judged(some, known, xyz, stands, low, high).items():
                print(
                    f"  {name:42}{low:3.0f} to {high:2.0f} mm, {judge:10}{said.n:4d} samples: ours{said.ours:4.0f} %, "
                    f"the reference{said.reference:4.0f} %, neither{said.neither:4.0f} %"
                )


def main(*asked: str) -> None:
    tdf = read_tdf(recording("cameras/gait9_bts/gait9.tdf"))
    assert tdf.rig and tdf.detections and tdf.trajectories
    rig, detections, xyz = tdf.rig, tdf.detections, tdf.trajectories.xyz
    names = list(METHODS)[:USUAL] if not asked else [n for n in METHODS if "all" in asked or any(a in n for a in asked)]
    pieces = continuous_pieces(xyz)
    rows = {name: made(METHODS[name], detections, rig, xyz, pieces) for name in names}
    print(f"{len(xyz)} reference tracks in {len(pieces)} continuous pieces\n")
    staged = [name for name in names if isinstance(METHODS[name], Staged)] or names
    lens_table(rig, detections, rows[staged[0]].tracks.cloud)
    chance = {name: by_chance(rig, detections, row.tracks, row.near, METHODS[name]) for name, row in rows.items()}
    for lens in LENSES:
        print(f"\nAgainst the reference tracks, through {lens}:\n{HEAD}")
        print(f"  {'naive (quoted): triplets, nearest point':42}{'90.2':>8}{'1.07':>8}{'':>38}{'0.6':>8}")
        for name, row in rows.items():
            print(line(name, row, lens, pieces, chance[name]))
    print(
        "\nStrangers are extra points on tracks that are no reference marker before or after. Chance: points that the"
    )
    print(
        "method makes of the images left over with the cameras shifted in time; extra points beyond these are markers."
    )
    print(f"The trial lasted {detections.n_frames / detections.rate:.1f} s; time is that of one processor.")
    stands = standing(rig, frame_images(rig, detections), xyz, pieces)
    standing_table(stands, rows, xyz)
    judges_table(stands, rows, xyz)
    print("Without cutting the reference at its own jumps, so many of its swaps would count as ours:")
    for name, row in rows.items():
        print(f"  {name:42}{len(changes(row.tracks, row.whole[THEIRS].owner, xyz)):8d}")


if __name__ == "__main__":
    main(*sys.argv[1:])
