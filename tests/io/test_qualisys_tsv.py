"""TSV of Qualisys Track Manager: every way of its export holds the same markers."""

import numpy as np
import pytest

from kinemark.data import KinemarkError
from kinemark.io.trial import read_trial

NAMES = ("LASI", "RASI", "R heel")


def places():
    xyz = np.random.default_rng(1).uniform(-2000, 2000, (12, len(NAMES), 3)).round(3)
    xyz[3:5, 1] = np.nan
    return xyz


def tsv(columns=2, heading=True, gap="0.000", first=1, frames=12, names=NAMES):
    lines = [f"NO_OF_FRAMES\t{frames}", "NO_OF_CAMERAS\t8", f"NO_OF_MARKERS\t{len(NAMES)}", "FREQUENCY\t120"]
    lines += ["NO_OF_ANALOG\t0", "TIME_STAMP\t2020-01-01, 10:00:00\t12.5", "DATA_INCLUDED\t3D"]
    lines += ["EVENT\tLeft heel strike\t7\t0.05000", "MARKER_NAMES\t" + "\t".join(names)]
    lines += ["TRAJECTORY_TYPES\tMeasured\tMixed\tMeasured"]
    if heading:
        columns_ = ["Frame", "Time"][:columns] + [f"{name} {axis}" for name in NAMES for axis in "XYZ"]
        lines.append("\t".join(columns_))
    for f, row in enumerate(places()):
        cells = [str(f + first), f"{(f + first - 1) / 120:.5f}"][:columns]
        lines.append("\t".join(cells + [gap if np.isnan(x) else f"{x:.3f}" for x in row.ravel()]))
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("gap", ["0.000", "", "NULL"])
@pytest.mark.parametrize(("columns", "heading"), [(2, True), (2, False), (1, True), (0, True), (0, False)])
@pytest.mark.parametrize(
    "change", [lambda s: s, lambda s: "\ufeff" + s.replace("\n", "\r\n"), lambda s: s.replace(".", ",")]
)
def test_every_export_holds_the_same_markers(tmp_path, gap, columns, heading, change):
    path = tmp_path / "walk.tsv"
    path.write_bytes(change(tsv(columns, heading, gap)).encode())
    trial = read_trial(path)
    assert trial.trajectories.names == NAMES and trial.trajectories.rate == 120
    np.testing.assert_array_equal(trial.trajectories.xyz, places().transpose(trial_axes(trial)))
    assert trial.events.label == ("Left heel strike",) and trial.events.time == pytest.approx([0.05])


def trial_axes(trial):
    """Frames or markers come first in `xyz`."""
    return (0, 1, 2) if trial.trajectories.xyz.shape[0] == 12 else (1, 0, 2)


def test_frames_count_as_in_the_file(tmp_path):
    (tmp_path / "a.tsv").write_text(tsv(first=392), "utf-8")
    assert read_trial(tmp_path / "a.tsv").trajectories.first_frame == 392


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda s: s.replace("MARKER_NAMES", "BODY_NAMES").replace("\t3D", "\t6D"), "holds 6D, and no markers"),
        (lambda s: s.replace("FREQUENCY\t120", "FREQUENCY\t0"), "--rate-hz"),
        (lambda s: "\n".join(s.split("\n")[:-4]) + "\n", "its heading says 12"),
        (lambda s: s[: s.rfind("\t")], "line 23"),
        (lambda s: s.replace("\tR heel\n", "\n"), "cells"),
        (lambda s: "\n".join(s.split("\n")[:11]) + "\n", "no frames"),
        (lambda s: "", "empty"),
    ],
)
def test_what_is_no_whole_export_is_refused_with_what_to_do(tmp_path, change, says):
    (tmp_path / "a.tsv").write_text(change(tsv()), "utf-8")
    with pytest.raises(KinemarkError, match=says):
        read_trial(tmp_path / "a.tsv")


@pytest.mark.parametrize(("kept", "frames", "lost"), [(0.55, 5, 0), (1.0, 12, 0), (-5, 12, 1)])
def test_what_is_left_of_a_file_that_is_cut_off_is_read_when_asked(tmp_path, kept, frames, lost):
    """Whole rows, and of the last row all but a number that may have lost digits."""
    text = tsv()
    cut = text[: int(kept * len(text))] if kept > 0 else text[:kept]
    (tmp_path / "a.tsv").write_text(cut, "utf-8")
    trial = read_trial(tmp_path / "a.tsv", partial=True)
    found, whole = trial.trajectories.xyz, places().transpose(1, 0, 2)[:, :frames]
    assert found.shape[1] == frames
    assert np.isnan(found).any(2).sum() == np.isnan(whole).any(2).sum() + lost
    known = np.isfinite(found)
    np.testing.assert_array_equal(found[known], whole[known])
    assert bool(trial.notes) == (kept != 1.0)


def test_the_date_of_a_recording_is_kept(tmp_path):
    (tmp_path / "a.tsv").write_text(tsv(), "utf-8")
    assert read_trial(tmp_path / "a.tsv").about["date"] == "2020-01-01T10:00:00"


def test_a_file_that_ends_within_its_first_row_holds_nothing(tmp_path):
    text = tsv()
    (tmp_path / "a.tsv").write_text(text[: text.index("1\t0.00000") + 12], "utf-8")
    with pytest.raises(KinemarkError, match="cut off"):
        read_trial(tmp_path / "a.tsv", partial=True)
