"""Two seconds of a meal before three cameras, digitised camera by camera: how often the operator is asked in all."""

import numpy as np

from kinemark.engine.digitising.files import digitise_trial
from kinemark.engine.session import Session
from support.eating import Knowing, footage
from support.feeding import feeding_in

FRAMES, SEED = 60, 3
"""The meal with most questions of those in docs/theory/digitise.md."""


def digitised(folder, more=""):
    """(uv, figures) of a session with more in `[digitise]`."""
    file = feeding_in(folder, FRAMES, seed=SEED) / "session.toml"
    file.write_text(file.read_text("utf-8").replace("[[trials]]", f"{more}[[trials]]", 1), "utf-8")
    session, cameras = Session.open(folder), iter(range(3))
    sight = footage(FRAMES / 30, SEED)[2]
    task = session.digitising("feeding", session.calibrate().rig)
    return digitise_trial(task, operator=lambda reel: Knowing(sight, next(cameras), reel))


def test_forty_questions_are_enough_where_the_other_cameras_are_believed(tmp_path):
    asked, by_hand = digitised(tmp_path / "asked"), 8 * 2 * 3
    told = digitised(tmp_path / "told", "take_proposals = true\nhistory = 10\n")
    assert by_hand < asked[1]["questions"] < 90
    assert told[1]["questions"] <= 40
    both = np.isfinite(asked[0]) & np.isfinite(told[0])
    assert both.sum() > 0.99 * np.isfinite(asked[0]).sum()
    assert np.quantile(np.abs(told[0] - asked[0])[both], 0.99) < 0.05, "px; the same places"
