"""A clinical gait trial from its 2D centroids and calibration alone, against another system's labelled tracks.

The recording (BTS SMART-D, seven cameras, 250 Hz, 1686 frames) holds the 30 tracks that the system itself made. They
are a reference, not the truth, and two things about them must be known before they are compared with.

**Their lens.** The file gives a lens model x_d = x_u g(r_u), and the reference undoes it by one division, x_u ≈ x_d /
g(r_d), instead of solving for x_u. Far from the image centre this is off by a pixel. The study shows it from the
images alone: points triangulated with the exact inverse fit their own images better than points triangulated with the
division. So that identity and completeness can be compared apart from this, positions are compared twice: as Kinemark
makes them, and from the same images through the reference's lens.

**Their swaps.** At some frames a reference track jumps to another marker: its second difference is 20 to 100 mm,
which at 250 Hz means thousands of m/s². Reference tracks are therefore cut where the second difference exceeds 8 mm,
and only their continuous pieces say which marker is which. A track that goes from a piece that ends there to one that
begins there has followed the marker through the reference's swap; one that leaves a piece that goes on has swapped
itself.

Points that no reference track is near are either markers that the reference has lost or ghosts, chance meetings of
images. A control tells them apart: of the images that no point near a reference sample uses, each camera's are
shifted in time against the other cameras', by a second and more. What meets then meets by chance, with as many images
as before.

Run: python studies/gait_trial.py
"""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray
from recordings import recording

from kinemark.data import Camera, Cloud, Detections, Rig, Tracks, Trajectories
from kinemark.geometry import normalised, triangulate, undistort
from kinemark.io.tdf import read_tdf
from kinemark.match import match
from kinemark.reconstruct import reconstruct
from kinemark.score import Score, changes, score
from kinemark.track import track

Floats = NDArray[np.float64]

JUMP = 8.0  # mm; a second difference no marker on a body has at 250 Hz (500 m/s²)
MARGIN = 3  # frames beside a jump that the reference's own smoothing has bent
NEAR = 5.0  # mm; a reference sample counts as found


def division(camera: Camera, uv: Floats) -> Floats:
    """Ideal pixels (D, 2) as the reference makes them: the distorted point divided by g at its own radius."""
    xy = normalised(camera, uv)
    r2 = (xy**2).sum(-1, keepdims=True)
    k1, k2, *_ = camera.distortion
    return xy / (1 + k1 * r2 + k2 * r2**2) @ camera.K[:2, :2].T + camera.K[:2, 2]


def points(rig: Rig, detections: Detections, cloud: Cloud, inverse: object) -> tuple[Floats, Floats, Floats]:
    """Points (P, 3) through a lens's inverse; their images' distance from them, px, and radius, (P, C) each."""
    ideal = np.full((len(cloud), len(rig), 2), np.nan)
    radius = np.full((len(cloud), len(rig)), np.nan)
    for c, camera in enumerate(rig):
        seen = cloud.view[:, c] >= 0
        uv = detections.uv[cloud.view[seen, c]]
        ideal[seen, c] = inverse(camera, uv)  # type: ignore[operator]
        radius[seen, c] = np.linalg.norm(normalised(camera, uv), axis=-1)
    xyz = triangulate(ideal, rig.P)
    x = np.einsum("cij,pj->pci", rig.P, np.column_stack([xyz, np.ones(len(xyz))]))
    return xyz, np.linalg.norm(ideal - x[..., :2] / x[..., 2:], axis=-1), radius


def continuous_pieces(xyz: Floats) -> Floats:
    """Reference tracks (M, F, 3) cut at their jumps: pieces (K, F, 3), NaN outside each."""
    bend = np.zeros(xyz.shape[:2])
    bend[:, 1:-1] = np.nan_to_num(np.linalg.norm(xyz[:, 2:] - 2 * xyz[:, 1:-1] + xyz[:, :-2], axis=-1))
    bad = np.isnan(xyz[..., 0])
    for shift in range(-MARGIN, MARGIN + 1):
        bad |= np.roll(bend > JUMP, shift, axis=1)
    pieces = []
    for m in range(len(xyz)):
        edges = np.flatnonzero(np.diff(np.concatenate([[True], bad[m], [True]]).astype(int)))
        for first, stop in zip(edges[::2], edges[1::2], strict=True):
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


def by_chance(rig: Rig, detections: Detections, tracks: Tracks, near: NDArray[np.bool_]) -> list[float]:
    """Tracked points a frame of the images left over, as they were and with the cameras shifted against each other."""
    used = np.zeros(len(detections), bool)
    view = tracks.cloud.view[near & (tracks.id >= 0)]
    used[view[view >= 0]] = True
    left, rates = detections.keep(~used), []
    for seconds in (0.0, 0.8, 1.0, 1.2):
        shifted = shift_cameras(left, round(seconds * left.rate))
        again = track(reconstruct(match(shifted, rig), shifted, rig))
        rates.append(float((again.id >= 0).sum() / left.n_frames))
    return rates


def shift_cameras(detections: Detections, frames: int) -> Detections:
    """The detections with camera c moved by c times so many frames, around the end."""
    orders = [np.roll(np.arange(detections.n_frames), frames * c) for c in range(len(detections.cameras))]
    counts = [detections.counts[c][order] for c, order in enumerate(orders)]
    uv = [detections[c, f] for c, order in enumerate(orders) for f in order.tolist()]
    return Detections.build(detections.cameras, detections.rate, counts, np.concatenate(uv))


def pieces_per_track(result: Score, reference: Floats, shortest: int = 25) -> float:
    """Mean number of our tracks on each continuous reference piece of at least 0.1 s."""
    long = np.isfinite(reference[..., 0]).sum(1) >= shortest
    return float(result.pieces[long].mean())


def main() -> None:
    tdf = read_tdf(recording("cameras/gait9_bts/gait9.tdf"))
    assert tdf.rig and tdf.detections and tdf.trajectories
    rig, detections, reference = tdf.rig, tdf.detections, tdf.trajectories
    began = time.perf_counter()
    matches = match(detections, rig)
    matched = time.perf_counter()
    cloud = reconstruct(matches, detections, rig)
    placed = time.perf_counter()
    tracks = track(cloud)
    ended = time.perf_counter()
    report(rig, detections, cloud, tracks, reference)
    lasted = detections.n_frames / detections.rate
    print(
        f"\nTime: match {matched - began:.2f} s, reconstruct {placed - matched:.2f} s, track {ended - placed:.2f} s; "
        f"together {ended - began:.2f} s (aim: below the {lasted:.1f} s that the trial lasted)"
    )


def report(rig: Rig, detections: Detections, cloud: Cloud, tracks: Tracks, reference: Trajectories) -> None:
    """Print the comparison."""
    xyz = reference.xyz
    pieces = continuous_pieces(xyz)
    lenses = {"exact inverse (Kinemark)": undistort, "one division (the reference)": division}
    print(
        f"{len(tracks)} tracks of {len(cloud)} points; {len(xyz)} reference tracks in {len(pieces)} continuous pieces\n"
    )
    print("Which inverse of the lens fits the images themselves? Median distance from the reprojection, px,")
    print("of points that four or more cameras see, by the image's distance from the optical axis:")
    rings = ((0.0, 0.2), (0.2, 0.3), (0.3, 0.4), (0.4, 1.0))
    print(" " * 32 + "".join(f"{f'{a:.1f}–{b:.1f}':>10}" for a, b in rings))
    placed = {}
    for name, inverse in lenses.items():
        placed[name], off, radius = points(rig, detections, cloud, inverse)
        four = (cloud.view >= 0).sum(1) >= 4
        row = [np.nanmedian(off[four][(radius[four] >= a) & (radius[four] < b)]) for a, b in rings]
        print(f"  {name:<30}" + "".join(f"{value:10.3f}" for value in row))
    print("\nAgainst the reference tracks:")
    print(f"  {'':<52}{'naive':>8}{'aim':>8}" + "".join(f"{name.split(' (')[0]:>18}" for name in lenses))
    found = {name: score(tracks, xyz, within=NEAR, xyz=place) for name, place in placed.items()}
    cut = {name: score(tracks, pieces, within=NEAR, xyz=place) for name, place in placed.items()}
    other = {n: extras(tracks, found[n].owner >= 0) for n in lenses}
    rows: list[tuple[str, str, str, list[float], int]] = [
        ("recall within 5 mm, %", "90.2", "≥ 98", [100 * found[n].recall for n in lenses], 1),
        ("median distance, mm", "1.07", "≤ 0.5", [found[n].median for n in lenses], 2),
        ("95th percentile, mm", "", "", [found[n].p95 for n in lenses], 2),
        ("swaps", "", "0", [cut[n].swaps for n in lenses], 0),
        ("tracks per continuous reference piece", "", "", [pieces_per_track(cut[n], pieces) for n in lenses], 2),
        ("tracks per reference track", "", "", [found[n].pieces.mean() for n in lenses], 1),
        ("extra points a frame", "0.6", "≤ 0.2", [other[n][0] for n in lenses], 2),
        ("  of these on tracks that are no reference marker", "", "", [other[n][1] for n in lenses], 2),
    ]
    for name, naive, aim, values, digits in rows:
        print(f"  {name:<52}" + f"{naive:>8}{aim:>8}" + "".join(f"{v:18.{digits}f}" for v in values))
    here, *chance = by_chance(rig, detections, tracks, found["one division (the reference)"].owner >= 0)
    print(
        f"\nOf the images left over by these, {here:.2f} tracked points a frame can be made. With the cameras shifted"
    )
    print(f"against each other in time, {max(chance):.2f}: so many are chance, the others are markers.")
    raw = len(changes(tracks, found["one division (the reference)"].owner, xyz))
    print(f"\nWithout cutting the reference at its own jumps, {raw} of its swaps would count as ours.")


if __name__ == "__main__":
    main()
