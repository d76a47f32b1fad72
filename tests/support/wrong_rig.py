"""Sessions whose calibration file is wrong in one way, and the truth behind them."""

from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from kinemark.data import Detections, Rig
from kinemark.geometry import project
from kinemark.io.records import save
from kinemark.io.rig_toml import write_rig_toml
from support.laboratory import observe, ring
from support.scenes.bodies import walker

RATE, FRAMES, MARKERS = 100.0, 150, 15
TOUCHED, LATE_FRAMES, TURN_PX = 2, 0.4, 12.0
"""The camera that is bumped, or late, by how many frames, and by how many px."""
GAP, MARKER, ALONE = slice(50, 95), 4, 2
"""Frames in which a marker is hidden from all cameras but one."""


class Wrong(NamedTuple):
    """The session's folder; the cameras as they are, and as its file states them; true places (M, F, 3) mm; what the
    pictures show."""

    folder: object
    true: Rig
    stated: Rig
    xyz: np.ndarray
    detections: Detections

    def shown(self, camera, m, f):
        """(2) px where a camera's picture shows a marker in a frame, from 0."""
        at = body(np.array([(f + self.late(camera)) / RATE]))[m, 0]
        return project(self.true[camera], at[None])[0]

    def late(self, camera):
        """Frames by which its pictures are late."""
        return LATE_FRAMES if self.folder.name == "late" and camera == TOUCHED else 0.0


@cache
def _path():
    grid = np.arange(FRAMES + 3) / RATE
    return CubicSpline(grid, walker("walk", MARKERS, grid, np.random.default_rng(4), False).xyz, axis=1)


def body(t):
    """True places (M, T, 3) mm at times (T) s."""
    return _path()(t)


def bare(rig):
    """Without lens terms."""
    return replace(rig, cameras=tuple(replace(camera, distortion=np.zeros(5)) for camera in rig))


def turned(rig, c, px):
    """With camera c turned, so that its images are so many px beside."""
    camera = rig[c]
    turn = Rotation.from_rotvec(np.array([0.8, 0.6, 0.3]) * px / camera.K[0, 0]).as_matrix()
    new = replace(camera, R=turn @ camera.R, t=turn @ camera.t)
    return replace(rig, cameras=(*rig.cameras[:c], new, *rig.cameras[c + 1 :]))


def wrong_session(folder, kind, more=""):
    """A session that is wrong by its folder's name: `lens`, `bumped` or `late`; and `right`."""
    true = ring(6, focal=1500.0, lens=np.array([-0.25, 0.0, 0.0, 0.0, 0.0]))
    stated = {"lens": bare, "bumped": lambda rig: turned(rig, TOUCHED, TURN_PX)}.get(kind, lambda rig: rig)(true)
    t = np.arange(FRAMES) / RATE
    wrong = Wrong(folder / kind, true, stated, body(t), None)
    found = [observe(true.select([camera.name]), body(t + wrong.late(c) / RATE), noise=0.2, seed=c)
             for c, camera in enumerate(true)]  # fmt: skip
    kept = [~_hidden(c, *one) for c, one in enumerate(found)]
    counts = np.concatenate([one.keep(own).counts for (one, _), own in zip(found, kept, strict=True)])
    uv, cov = (np.concatenate([getattr(one, name)[own] for (one, _), own in zip(found, kept, strict=True)])
               for name in ("uv", "cov"))  # fmt: skip
    wrong = wrong._replace(detections=Detections.build(true.names, RATE, counts, uv, cov))
    wrong.folder.mkdir()
    save(wrong.folder / "walk.h5", wrong.detections)
    write_rig_toml(wrong.folder / "rig.toml", stated)
    text = f'name = "{kind}"\n[calibration]\nfile = "rig.toml"\n[fill]\n'
    text += '[[trials]]\nname = "walk"\ndetections = "walk.h5"\n'
    (wrong.folder / "session.toml").write_text(text + more)
    return wrong


def _hidden(c, detections, marker):
    """Which of a camera's images are of the marker that the others do not see."""
    frame = detections.frame
    return (marker == MARKER) & (frame >= GAP.start) & (frame < GAP.stop) & (c != ALONE)
