"""Real images as a laboratory of UM²AS: measured places of eight points, their images, and what is digitised.

Nothing is kept of them: tests write what they need into a folder of their own, and skip where the data are absent.
"""

import json
from itertools import islice

import numpy as np

from kinemark.calibrate import assign_points
from kinemark.data import Camera, Rig
from kinemark.detect import Centroids
from kinemark.digitise import find_markers
from kinemark.engine.session import Session
from kinemark.geometry import project_all
from kinemark.io.images import open_images, read_image, write_png
from kinemark.io.rig_toml import write_rig_toml
from kinemark.io.um2as import write_msr
from kinemark.io.video import write_video
from support.shared import shared_data

FRAMES = 3
EIGHT, HELD_OUT = (0, 3, 6, 49, 55, 98, 101, 104), (24, 52, 80)
"""Dots of the body that are taken for control balls, of its edges and its ridge, so not in a plane; and dots whose
places are known, too, which are digitised."""
PICKED = {
    1: ((742, 153), (356, 67), (217, 191), (711, 672), (335, 582), (197, 722)),
    2: ((143, 184), (510, 89), (685, 207), (179, 708), (535, 606), (707, 740)),
    3: ((201, 131), (326, 265), (694, 164), (250, 644), (374, 763), (752, 663)),
    4: ((189, 179), (541, 278), (693, 134), (154, 676), (516, 772), (669, 639)),
}
"""Where each camera has the first, fourth and seventh dot of the first and last row of the body, px."""


def splitter_in(folder):
    """Eight dots of a printed body as control balls, and three others of it as markers that stand still.

    Gives the pixels (4, 8, 2) of the balls, (4, 3, F, 2) of the markers, and their places (3, F, 3) mm. The recording
    of moving dots beside it does not fit the calibration (42 px), so that the body itself is digitised.
    """
    data = shared_data("cameras/dot_body_splitter")
    folder.mkdir(parents=True)
    xyz = np.loadtxt(data / "cal" / "splitter_target.txt")[:, 1:]
    uv = np.empty((4, len(xyz), 2))
    for c, picked in PICKED.items():
        image = read_image(data / "cal" / f"cam{c}.png")
        write_png(folder / f"body_cam{c}.png", image)
        write_video(folder / f"dots_cam{c}.mkv", np.stack([image] * FRAMES), 10.0)
        found = find_markers(image, method=Centroids(max_discs=1, correct_occlusion=False)).uv
        at = np.array(picked, np.float64)
        uv[c - 1] = found[assign_points(found, xyz, picked=np.array([0, 3, 6, 98, 101, 104]), at=at)]
    write_msr(folder / "body.msr", xyz[list(EIGHT)])
    return uv[:, EIGHT], _still(uv[:, HELD_OUT]), _still(xyz[list(HELD_OUT)])


def _still(values):
    """(…, n, k) in every frame: (…, n, F, k)."""
    return np.repeat(np.expand_dims(values, -2), FRAMES, axis=-2)


LONG = 12
"""Frames in which the program itself follows LEDs, to know where they are; those that are digitised come first."""
POSES = (440, 80)
"""Frames of the footage from which on the plate is held in two ways, so that LEDs of both do not lie in a plane."""


def infrared_in(folder):
    """LEDs of a plate, four in each of two of its poses, as control balls, both pictures of a camera laid on each
    other; three LEDs of the second pose, in motion, as markers.

    Gives as `splitter_in` does; places are those of the published calibration, with its lenses.
    """
    data = shared_data("cameras/ir_4cam_footage")
    folder.mkdir(parents=True)
    rig, films = _published(data / "config"), [open_images(data / f"calibration1_{c}.mp4") for c in range(4)]
    parts = [[np.stack(list(islice(film.frames(), at, at + LONG))) for film in films] for at in POSES]
    xyz = [_leds(folder.parent / f"known {k}", rig, part) for k, part in enumerate(parts)]
    balls = np.concatenate([_apart(xyz[0][:, 0], 4), _apart(xyz[1][:, 0], 4)])
    for c in range(4):
        write_png(folder / f"plate_cam{c + 1}.png", np.maximum(parts[0][c][0], parts[1][c][0]))
        write_video(folder / f"leds_cam{c + 1}.mkv", parts[1][c][:FRAMES], 30.0)
    write_msr(folder / "plate.msr", balls)
    markers = xyz[1][[int(np.abs(xyz[1][:, 0] - one).sum(-1).argmin()) for one in _apart(xyz[1][:, 0], 3)]]
    seen = project_all(rig, markers.reshape(-1, 3)).reshape(4, 3, FRAMES, 2)
    return project_all(rig, balls), seen, markers


def _published(config):
    """The cameras as the project's JSON files give them: OpenCV's K and lens terms, x_cam = R X + t in mm."""
    inside, outside = (
        json.loads((config / f"config_camera-{one}.json").read_text()) for one in ("intrinsic", "extrinsic")
    )
    cameras = []
    for a, b in zip(inside, outside, strict=True):
        U, _, Vt = np.linalg.svd(b["R"])  # printed digits: not quite a rotation
        K, lens = np.array(a["intrinsic_matrix"]), np.array(a["distortion_coef"])
        name = f"cam{int(a['camera_id']) + 1}"
        cameras.append(Camera(name, np.array([640, 480]), K, U @ Vt, np.array(b["t"]), lens))
    return Rig(tuple(cameras), "published with the footage")


def _leds(folder, rig, images):
    """(n, F, 3) mm of the LEDs that are followed through all frames."""
    folder.mkdir()
    write_rig_toml(folder / "rig.toml", rig)
    for name, own in zip(rig.names, images, strict=True):
        write_video(folder / f"{name}.mkv", own, 30.0)
    (folder / "session.toml").write_text(
        'name = "known"\n[calibration]\nfile = "rig.toml"\n[[trials]]\nname = "leds"\nimages = "{camera}.mkv"\n'
    )
    xyz = Session.open(folder).trial("leds").run(to="track").trajectories.xyz
    xyz = xyz[:, :FRAMES]
    return xyz[np.isfinite(xyz).all((1, 2))]


def _apart(xyz, n):
    """n places of xyz (N, 3) that are far from each other, the first two the farthest."""
    distance = np.linalg.norm(xyz[:, None] - xyz, axis=-1)
    chosen = list(np.unravel_index(int(distance.argmax()), distance.shape))
    while len(chosen) < n:
        chosen.append(int(distance[chosen].min(0).argmax()))
    return xyz[chosen[:n]]
