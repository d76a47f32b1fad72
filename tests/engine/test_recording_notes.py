"""What is missing of a file needs attention; what nothing needs, or was read otherwise, is said by the way."""

import numpy as np
import pytest

from kinemark.data import Trajectories, Trial
from kinemark.engine.trial_graph import _channels
from kinemark.io.tdf import read_tdf
from support.shared import shared_data

TRACKS = Trajectories((), 250.0)


def findings(notes):
    return list(_channels(Trial("t", TRACKS, notes=notes), TRACKS))


def test_a_usual_recording_needs_no_attention():
    """The file has a setup of cameras and computed torques, which nothing here wants."""
    found = findings(read_tdf(shared_data("cameras/gait9_bts/gait9.tdf")).notes)
    assert [(one.kind, one.severity) for one in found] == [("recording_notes", "info")]
    assert any("block 12" in part for part in found[0].values["parts_list"])


@pytest.mark.parametrize("lost", ["the EMG (block 11), as it ends", "the force plates (block 7), as it has format 9"])
def test_what_is_lost_does(lost):
    found = findings((f"unreadable: {lost}", "volumes (block 13) is not read"))
    assert [(one.kind, one.severity) for one in found] == [
        ("recording_partly_read", "amber"),
        ("recording_notes", "info"),
    ]
    assert found[0].values["parts_list"] == (lost,) or found[0].values["parts_list"] == [lost]


def test_recorded_channels_of_an_unknown_layout_are_lost(tmp_path):
    raw = bytearray(shared_data("cameras/gait9_bts/gait9.tdf").read_bytes())
    entries = np.frombuffer(raw[64 : 64 + 288 * int.from_bytes(raw[20:24], "little")], "<i4").reshape(-1, 72)
    row = int(np.flatnonzero(entries[:, 0] == 12)[0])
    raw[64 + 288 * row : 68 + 288 * row] = (14).to_bytes(4, "little")
    (tmp_path / "a.tdf").write_bytes(raw)
    kinds = {one.kind: one.values["parts_list"] for one in findings(read_tdf(tmp_path / "a.tdf").notes)}
    assert any("general-purpose channels" in part for part in kinds["recording_partly_read"])
