"""Pixels that are counted along other axes than the calibration does."""

import json
from dataclasses import replace

import numpy as np
import pytest

from kinemark.engine.camera_checks.pixel_axes import WAYS, counted
from kinemark.engine.session import Session
from kinemark.io.records import save
from support.findings import found
from support.sessions import folder_of


def quality_of(path, change):
    """The figures of a trial whose detections were changed."""
    folder, rig, detections = folder_of(path, 5)
    save(folder / "one.h5", change(detections, rig))
    return json.loads((Session.open(folder).run()["one"].folder / "quality.json").read_text("utf-8"))


BACK = {"half_size": "double_size", "double_size": "half_size"}
OWN = {
    "centre": lambda uv, size: uv - (size - 1) / 2,
    "centre_v_up": lambda uv, size: (uv - (size - 1) / 2) * [1, -1],
    "share": lambda uv, size: (uv + 0.5) / size,
    "share_v_up": lambda uv, size: np.stack([(uv[:, 0] + 0.5) / size[0], 1 - (uv[:, 1] + 0.5) / size[1]], -1),
}
"""How files count that count from the middle, or in shares of the image."""


def as_file(seen, rig, way):
    """The detections as a file counts them."""
    if way not in OWN:
        return counted(seen, rig, BACK.get(way, way))
    uv = np.array(seen.uv)
    for c, one in enumerate(rig):
        uv[seen.camera == c] = OWN[way](uv[seen.camera == c], one.size)
    return replace(seen, uv=uv)


@pytest.mark.parametrize("way", WAYS)
def test_another_corner_rows_before_columns_and_images_of_another_size_are_named(tmp_path, way):
    quality = quality_of(tmp_path, lambda seen, rig: as_file(seen, rig, way))
    (differ,) = found(quality, "pixel_axes_differ")
    assert (differ.severity, differ.values["way"]) == ("red", way)
    assert differ.values["other_share"] > 0.9 and differ.values["as_is_share"] < 0.2


def test_pixels_counted_as_calibrated_are_not_doubted(tmp_path):
    assert not found(quality_of(tmp_path, lambda seen, rig: seen), "pixel_axes_differ")
