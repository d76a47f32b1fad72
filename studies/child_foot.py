"""The foot of a very young child (KISS 6): markers of 8 mm, 25 mm apart, from images to tracks.

    python studies/child_foot.py [seconds, 0.6] [seed, 1]

"The program had some difficulty in tracking closely spaced markers, such as those on the feet of very young children"
(Shafiq, Tümer and Güler 2001, section 6), who give no figures; all of these are computed.

A child of 86 cm walks at 0.7 m/s through the middle of the volume, with the fifteen markers of KISS and five more on
each foot, which make a grid of two by three with a pitch of 25 mm behind the toes. Markers have a diameter of 8 mm. Six
cameras of 1280 × 1024 px film it; legs hide markers, and markers each other. The chain of KISS (scanning, triplets of
cameras, search spheres) and Kinemark's own (centroids, discs told apart, matching and tracking at once) get the same
images. From 4.2 m a marker is 2.5 px wide and the pitch is 7.7 px at most; from 2.5 m, 4.2 and 13 px. The fields of
KISS's own cameras would show it 1.5 px wide and 0.7 px high.

A swinging foot goes 51 mm a frame at 50 Hz, twice the pitch: where a marker was, others are by then, and those of the
whole grid shifted by one or two places move as evenly as the right ones. At 100 Hz it goes one pitch.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from kinemark.data import Detections, Rig, Tracks
from kinemark.data.array_types import Floats, GreyLevels
from kinemark.detect import Centroids, KissScanning, detect_frames
from kinemark.match import KissTriplets, match
from kinemark.reconstruct import LeastSquares, reconstruct
from kinemark.synth import Optics, Subject, film, ring, truth, walking
from kinemark.synth.score import score
from kinemark.track import KissTracking, track
from kinemark.track.simultaneous import Simultaneous, track_detections

PITCH_MM, RADIUS_MM = 25.0, 4.0  # of the grid and of the markers; of the question
HEIGHT_MM, SPEED_MM_S = 860.0, 700.0  # of a child of two years; chosen
CASES = tuple((rate, metres) for metres in (4.2, 2.5) for rate in (50.0, 100.0))
"""Hz, and metres from the cameras to the middle; chosen."""
WITHIN = 10.0  # mm; less than half of the pitch, so that a point is one marker's; chosen


def child(seconds: float, rate: float, speed: float = SPEED_MM_S) -> Subject:
    """The walking child with a grid of markers on each foot."""
    body = walking(duration_s=seconds, rate=rate, speed_mm_s=speed, height_mm=HEIGHT_MM, marker_radius_mm=RADIUS_MM)
    xyz, names = list(body.xyz), list(body.names)
    for side in ("L", "R"):
        heel, toe = (body.xyz[body.names.index(side + name)] for name in ("HEE", "TOE"))
        along, across = _axes(heel, toe)
        for row, column in ((0, -1), (0, 1), (1, -1), (1, 0), (1, 1)):
            xyz.append(toe - row * PITCH_MM * along + column * PITCH_MM * across)
            names.append(f"{side}F{row}{column + 1}")
    radius = np.full(len(xyz), RADIUS_MM)
    return replace(body, names=tuple(names), xyz=np.array(xyz), radius_mm=radius)


def _axes(heel: Floats, toe: Floats) -> tuple[Floats, Floats]:
    """Unit vectors (F, 3) from heel to toe and level across the foot."""
    along = (toe - heel) / np.linalg.norm(toe - heel, axis=1, keepdims=True)
    across = np.cross([0.0, 0.0, 1.0], along)
    return along, across / np.linalg.norm(across, axis=1, keepdims=True)


def found(images: Sequence[GreyLevels], rig: Rig, rate: float, method: Centroids | KissScanning) -> Detections:
    """The detections of all cameras."""
    blobs = [detect_frames(each, method=method) for each in images]
    uv, cov, area, validity, merged = (
        np.concatenate([getattr(b, name) for b in blobs]) for name in ("uv", "cov", "area", "validity", "merged")
    )
    counts = np.array([b.counts for b in blobs])
    return Detections.build(rig.names, rate, counts, uv, cov, area=area, validity=validity, merged=merged)


def kiss(images: Sequence[GreyLevels], rig: Rig, rate: float) -> Tracks:
    low, high = ((float(a), float(b), float(c)) for a, b, c in rig.volume)
    detections = found(images, rig, rate, KissScanning(threshold=60.0, min_area=2))
    cloud = reconstruct(match(detections, rig, method=KissTriplets()), detections, rig, method=LeastSquares())
    return track(cloud, method=KissTracking(volume=(low, high)))


def kinemark(images: Sequence[GreyLevels], rig: Rig, rate: float) -> Tracks:
    return track_detections(found(images, rig, rate, Centroids(threshold=60.0, min_area=2)), rig, method=Simultaneous())


CHAINS: dict[str, Callable[[Sequence[GreyLevels], Rig, float], Tracks]] = {"KISS": kiss, "Kinemark": kinemark}


def rows(subject: Subject, rig: Rig, seed: int) -> dict[str, tuple[float, ...]]:
    """Chain → feet: % of samples that two cameras see, found, pieces a marker, swaps, RMSE mm; found of all others."""
    images = [np.stack(list(film(c, subject, optics=Optics(subsamples=2), seed=seed + i))) for i, c in enumerate(rig)]
    feet = np.array(["F" in name or "TOE" in name for name in subject.names])
    shown = (truth(rig, subject).visible > 0.5).sum(0) >= 2
    out: dict[str, tuple[float, ...]] = {}
    for name, chain in CHAINS.items():
        tracks = chain(images, rig, subject.rate)
        result = score(tracks, subject.xyz, within=WITHIN)
        had = np.zeros(shown.shape, bool)
        near = result.owner >= 0
        had[result.owner[near], tracks.cloud.frame[near]] = True
        share = [100 * had[some][shown[some]].mean() for some in (feet, ~feet)]
        out[name] = (share[0], result.fragments[feet].mean(), result.swaps, result.rmse, share[1])
    return out


def main() -> None:
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 0.6
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    print(f"{seconds:g} s, seed {seed}; samples that two cameras and more see")
    print("   Hz    m  chain      feet found %  pieces a marker   swaps    RMSE mm   others found %")
    for rate, metres in CASES:
        subject = child(seconds, rate)
        for name, figures in rows(subject, cameras(metres), seed).items():
            share, pieces, swaps, rmse, others = figures
            print(
                f"{rate:5.0f}{metres:5.1f}  {name:9}{share:14.1f}{pieces:17.2f}{swaps:8d}{rmse:11.2f}{others:17.1f}",
                flush=True,
            )


def cameras(metres: float) -> Rig:
    """Six, so far from the middle of the walk."""
    return ring(6, radius=1000 * metres, height=(1100.0, 2300.0), target=(1200.0, 700.0, 400.0))


if __name__ == "__main__":
    main()
