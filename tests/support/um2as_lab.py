"""A laboratory as UM²AS has it, of which only recordings are there: measured places, images of the balls, videos."""

import numpy as np

from kinemark.geometry import project_all
from kinemark.io.images import write_png
from kinemark.io.um2as import write_msr
from kinemark.io.video import write_video
from kinemark.synth import Optics, render
from support.boxed import BALLS
from support.eating import POST, footage


def laboratory_in(folder, frames):
    """A folder with `box.msr`, `box_cam1.png` … and `feeding_cam1.mkv` …; gives the pixels (C, 9, 2) of the balls and
    of the reference marker, and those (C, M, F, 2) of the markers."""
    folder.mkdir(parents=True, exist_ok=True)
    rig, _, sight, images = footage(frames / 30)
    balls = np.concatenate([BALLS, POST[None]])
    rng = np.random.default_rng(0)
    write_msr(folder / "box.msr", BALLS)
    for c, camera in enumerate(rig):
        write_png(folder / f"box_cam{c + 1}.png", render(camera, balls, 17.0, optics=Optics(subsamples=2), rng=rng))
        write_video(folder / f"feeding_cam{c + 1}.mkv", images[c][:frames], 30.0)
    return project_all(rig, balls), sight.uv
