"""What the stage `track` tells of its input, by where that comes from."""

from types import SimpleNamespace

import pytest

from kinemark.data import make_finding
from kinemark.engine import tracking_stage
from kinemark.engine.tracking_in_time import Tracked
from kinemark.engine.tracking_stage import from_detections
from kinemark.reconstruct import LeastSquares
from kinemark.track.simultaneous import Simultaneous
from support.captures import capture, ring, walk


@pytest.mark.parametrize("images", [None, "walk/{camera}.mkv"])
def test_only_of_centroids_from_files_is_their_noise_told_as_overstated(monkeypatch, images):
    """Nobody can state another noise of those that Kinemark finds itself in images, as it advised."""
    rig = ring()
    records = capture(rig, walk())
    told = make_finding("noise_overstated", stated_px=0.29, seen_px=0.07), make_finding("nothing_goes_on", rate_hz=50.0)
    monkeypatch.setattr(tracking_stage, "in_any_order", lambda *_: Tracked(records["tracks"], diagnostics=told))
    methods = {"track": Simultaneous(), "reconstruct": LeastSquares(), "match": None}
    settings = SimpleNamespace(**methods, cameras=SimpleNamespace(delays_ms={}))
    source = SimpleNamespace(of=SimpleNamespace(entry=SimpleNamespace(images=images)))
    inputs = SimpleNamespace(rig=rig, settings=settings, source=source, calibrated=SimpleNamespace(figures={}))
    found = from_detections(inputs, {"detect": records["detections"]}).diagnostics
    assert [one.kind for one in found] == [one.kind for one in told if images is None or one.kind != "noise_overstated"]
