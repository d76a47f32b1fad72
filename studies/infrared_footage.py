"""Real infrared videos of four cameras, processed as a session, judged by the shape of the target that they show.

The target is a plate with 15 LEDs on a 100 mm grid. Its videos and calibration come from a published project; nothing
says where it was, but its shape is known: in each frame the pattern is laid on the reconstructed points by the rigid
motion that fits best, and what is left over is the error. The pattern's points are told apart without labels, by the
assignment of the least squares fit itself.

Run: python studies/infrared_footage.py [folder for the session]
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from recordings import recording

from kinemark.data import Camera, Rig
from kinemark.data.array_types import Floats, Ints
from kinemark.engine.session import Session
from kinemark.geometry import rigid_align
from kinemark.io.rig_toml import write_rig_toml
from kinemark.signal import assign

FEWEST = 12  # LEDs in place for a frame to count as reconstructed; the plate's corners may be hidden
CORNERS = [np.array(three) for three in ((4, 12, 7), (4, 2, 13), (6, 13, 10))]  # LEDs far apart

SETTINGS = """\
name = "infrared footage"

[calibration]
file = "rig.toml"

[[trials]]
name = "target"
images = "{videos}/calibration1_{{camera}}.mp4"
"""


def published_rig(folder: Path) -> Rig:
    """The cameras as the project's JSON files give them: OpenCV's K and lens terms, x_cam = R X + t in mm."""
    inside = json.loads((folder / "config_camera-intrinsic.json").read_text())
    outside = json.loads((folder / "config_camera-extrinsic.json").read_text())
    cameras = []
    for a, b in zip(inside, outside, strict=True):
        U, _, Vt = np.linalg.svd(b["R"])  # printed digits: not quite a rotation
        K, lens = np.array(a["intrinsic_matrix"]), np.array(a["distortion_coef"])
        cameras.append(Camera(str(a["camera_id"]), np.array([640, 480]), K, U @ Vt, np.array(b["t"]), lens))
    return Rig(tuple(cameras), "published with the footage")


def pattern(folder: Path) -> Floats:
    """The 15 LEDs (15, 3) mm in the plane of the plate."""
    target = json.loads((folder / "tests_config_objects.json").read_text())[0]
    return np.column_stack([np.array(target["points"], float), np.zeros(len(target["points"]))])


def poses(points: Floats, model: Floats, corner: NDArray[np.int64]) -> list[tuple[Floats, Floats]]:
    """Motions that bring three LEDs of the model onto three points, wherever the sides agree to 12 mm."""
    apart = np.linalg.norm(points[:, None] - points, axis=-1)
    side = [np.linalg.norm(model[corner[k]] - model[corner[k - 1]]) for k in range(3)]
    fits = [np.abs(apart - length) < 12 for length in side]
    triples = np.argwhere(fits[1][:, :, None] & fits[2][None] & fits[0].T[:, None])
    return [rigid_align(model[corner], points[triple]) for triple in triples]


def in_place(points: Floats, model: Floats, pose: tuple[Floats, Floats], reach: float) -> tuple[Ints, Ints]:
    """LEDs and points that lie within `reach` mm of each other under a pose, one to one."""
    R, t = pose
    cost = np.linalg.norm((model @ R.T + t)[:, None] - points, axis=-1)
    return assign(cost, np.full(len(model), reach))


def fit(
    points: Floats, model: Floats, last: tuple[Floats, Floats] | None
) -> tuple[Floats, tuple[Floats, Floats]] | None:
    """Distances (n,) mm of the points from the pattern laid on them, and its pose; None where it does not fit.

    The last frame's pose is tried first, then all that three of the LEDs allow.
    """
    starts = [last] if last else []
    for corner in (None, *CORNERS):
        starts = poses(points, model, corner) if corner is not None else starts
        hits = [len(in_place(points, model, pose, 30.0)[0]) for pose in starts]
        if not hits or max(hits) < FEWEST:
            continue
        pose = starts[int(np.argmax(hits))]
        for _ in range(4):
            i, j = in_place(points, model, pose, 20.0)
            if len(i) < FEWEST:
                break
            pose = rigid_align(model[i], points[j])
        else:
            R, t = pose
            return np.linalg.norm(model[i] @ R.T + t - points[j], axis=1), pose
    return None


def print_by_speed(places: Floats, rms: Floats) -> None:
    """The fit of slow and of fast frames: what is not synchronous shows in motion."""
    step = np.linalg.norm(np.diff(places[:, :3], axis=0), axis=1) / np.diff(places[:, 3])
    bounds = np.quantile(step, [0, 0.25, 0.5, 0.75, 1])
    print("  by the speed of the plate, mm a frame:")
    for low, high in pairwise(bounds):
        some = rms[1:][(step >= low) & (step <= high)]
        print(f"    {low:5.1f} to {high:5.1f}: {np.sqrt((some**2).mean()):.2f} mm RMS")


def main() -> None:
    source = recording("cameras/ir_4cam_footage")
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(tempfile.mkdtemp())
    folder.mkdir(parents=True, exist_ok=True)
    write_rig_toml(folder / "rig.toml", published_rig(source / "config"))
    (folder / "session.toml").write_text(SETTINGS.format(videos=source))
    began = time.perf_counter()
    result = Session.open(folder).run()["target"]
    took = time.perf_counter() - began
    model, cloud = pattern(source / "config"), result.tracks.cloud
    off, places, pose = [], [], None
    for f in range(cloud.n_frames):
        found = fit(cloud[f], model, pose) if len(cloud[f]) >= FEWEST else None
        pose = found[1] if found else None
        if found:
            off.append(found[0])
            places.append(np.append(found[1][1], f))
    leds = np.array([len(frame) for frame in off])
    rms = np.array([np.sqrt((frame**2).mean()) for frame in off])
    print(f"{cloud.n_frames} frames, {len(cloud) / cloud.n_frames:.2f} points a frame, {len(result.tracks)} tracks")
    print(f"frames reconstructed, with {FEWEST} or more of the 15 LEDs in place: {len(off)}")
    print(f"  with all 15: {(leds == 15).sum()} (naive, quoted: seen by all cameras in 421)")
    print(f"rigid fit to the pattern: {np.sqrt((np.concatenate(off) ** 2).mean()):.2f} mm RMS over these,")
    print(f"  {np.median(rms):.2f} mm in the median frame (naive, quoted, those 421: 2.53 mm RMS)")
    print_by_speed(np.array(places), rms)
    print(f"reprojection: {np.sqrt((cloud.residual**2).mean()):.2f} px RMS (naive, quoted: 0.35)")
    print(f"{took:.1f} s, {1000 * took / cloud.n_frames:.1f} ms a frame of four cameras, the videos' decoding included")
    print(f"report: {result.folder / 'report.html'}")


if __name__ == "__main__":
    main()
