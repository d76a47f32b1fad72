"""The control balls and markers of UM²AS, their images, and its files."""

from datetime import date

import numpy as np

from kinemark.engine.um2as.flow import calibrate_file
from kinemark.geometry import project_all
from kinemark.io.um2as import write_da, write_msr
from kinemark.synth import truth
from support.eating import laboratory, meal

CM = ((72.2, 40.5, -6.4), (60.0, 31.8, 31.5), (63.6, 5.8, 59.5), (46.8, 16.8, -7.5))
CM += ((21.0, 5.7, 73.9), (13.7, 46.7, 37.8), (48.3, 72.3, 62.2), (32.5, 31.2, 58.9))
BALLS = 10 * np.array(CM)
"""mm; the places that figure 3.5 of the thesis prints."""

MARKERS = ("1", "2", "3", "4", "5", "6", "7", "REF")


def seen_balls(noise=0.1, seed=0):
    rig = laboratory()
    uv = project_all(rig, BALLS)
    return rig, uv + np.random.default_rng(seed).normal(0, noise, uv.shape)


def seen_meal(noise=0.1, seed=1, seconds=1.5):
    """(rig, subject, uv (C, M, F, 2)) with what the lamp hides as NaN."""
    rig, subject = laboratory(), meal(seconds)
    sight = truth(rig, subject)
    uv = sight.uv + np.random.default_rng(seed).normal(0, noise, sight.uv.shape)
    uv[sight.visible < 0.5] = np.nan
    return rig, subject, uv


def files(tmp_path, cameras=(0, 1, 2)):
    """box.msr, box.cpN and feed.daN of these cameras, and the subject."""
    write_msr(tmp_path / "box.msr", BALLS)
    _, balls = seen_balls()
    _, subject, uv = seen_meal()
    for c in cameras:
        calibrate_file(tmp_path / "box.msr", tmp_path / f"box.cp{c + 1}", balls[c], made=date(1992, 11, 27))
        write_da(tmp_path / f"feed.da{c + 1}", uv[c])
    return [tmp_path / f"box.cp{c + 1}" for c in cameras], [tmp_path / f"feed.da{c + 1}" for c in cameras], subject
