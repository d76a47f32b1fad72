"""Pixels that are counted along other axes than the calibration does."""

import json

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


@pytest.mark.parametrize("way", WAYS)
def test_another_corner_rows_before_columns_and_images_of_another_size_are_named(tmp_path, way):
    quality = quality_of(tmp_path, lambda seen, rig: counted(seen, rig, BACK.get(way, way)))
    (differ,) = found(quality, "pixel_axes_differ")
    assert (differ.severity, differ.values["way"]) == ("red", way)
    assert differ.values["other_share"] > 0.9 and differ.values["as_is_share"] < 0.2


def test_pixels_counted_as_calibrated_are_not_doubted(tmp_path):
    assert not found(quality_of(tmp_path, lambda seen, rig: seen), "pixel_axes_differ")
