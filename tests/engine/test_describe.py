"""What `info` says of a trial's points."""

from dataclasses import replace

import numpy as np

from kinemark.data import Trial
from kinemark.engine.describe import describe, described
from kinemark.io.images import write_png
from kinemark.io.trial import write_trial
from kinemark.io.video import write_video
from support.computed import computed, walker, with_computed


def test_computed_points_are_no_markers_and_their_gaps_no_gaps(tmp_path):
    trial = with_computed(walker(1))
    away = np.arange(trial.n_frames) % 50 > 40
    cut = tuple(p.only(~away) if p.name in computed(walker(1)) else p for p in trial)
    write_trial(Trial("walk", replace(trial, paths=cut)), tmp_path / "walk.c3d")
    facts = describe(tmp_path / "walk.c3d")
    assert facts["markers"] == list(walker(1).names)
    assert set(facts["computed_points"]) == set(computed(walker(1))) and facts["gaps"]["count"] == 0
    assert any(line.startswith(f"computed of markers: {len(computed(walker(1)))}: ") for line in described(facts))


def test_markers_that_are_never_seen_are_told(tmp_path):
    trial = walker(1)
    first = trial.paths[0]
    without = (first.only(np.zeros(trial.n_frames, bool)), *trial.paths[1:])
    write_trial(Trial("walk", replace(trial, paths=without)), tmp_path / "walk.c3d")
    facts = describe(tmp_path / "walk.c3d")
    assert facts["never_seen"] == [first.name] and f"never seen: 1: {first.name}" in described(facts)


def test_a_video_is_called_one(tmp_path):
    """It "holds images", and the next line said "video: True"."""
    still, film = tmp_path / "cam1.png", tmp_path / "cam1.mkv"
    frames = np.zeros((3, 32, 48), np.uint8)
    write_png(still, frames[0])
    write_video(film, frames, rate=25.0)
    assert [described(describe(path))[0] for path in (still, film)] == ["holds: images", "holds: a video"]
