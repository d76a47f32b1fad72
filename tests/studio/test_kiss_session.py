"""The session of KISS, section 5.2, on the screen: from its tracks to fifteen named trajectories of equal length.

The paper: "16 trajectories left, one marker in two pieces", then names from a list, joins and trimming by hand. Here
somebody who sees only the screen does it, and their interventions are counted.
"""

import numpy as np
import pytest

from kinemark.engine.session import Session
from kinemark.io.c3d import read_c3d
from support.kiss_session import kiss_session
from support.screen_operator import Operator
from support.studio_page import Studio, served, window

WITHIN = 20.0  # mm; the closest markers are 60 mm apart
MOST_ACTIONS = 40


@pytest.fixture
def session(tmp_path):
    subject = kiss_session(tmp_path)
    Session.open(tmp_path).run()
    return tmp_path, subject


def test_fifteen_trajectories_of_equal_length_are_saved_with_their_names(session, chromium_running, record_property):
    folder, subject = session
    with served(folder) as server:
        context = window(chromium_running)
        studio = Studio(context, server).enter(server.address)
        operator = Operator(studio.open())
        operator.problems()
        operator.proposed_names()
        operator.finish("results/walk01/walk01.c3d")
        context.close()
    assert studio.errors == []
    record_property("interventions", operator.actions)
    print(f"{operator.actions} interventions, {operator.seconds:.0f} s", *operator.did, sep="\n  ")

    saved = read_c3d(folder / "results" / "walk01" / "walk01.c3d").trajectories
    assert sorted(saved.names) == sorted(subject.names), "all markers, and nothing else"
    assert all(path.origin[[0, -1]].all() for path in saved), "all begin and end at the same frames"
    true = subject.xyz[:, saved.first_frame - 1 :][:, : saved.n_frames]
    off = np.array([np.linalg.norm(path.xyz - true[subject.names.index(path.name)], axis=1) for path in saved])
    assert (off[np.isfinite(off)] < WITHIN).mean() > 0.995 and np.isfinite(off).mean() > 0.98
    assert saved.n_frames >= 0.8 * subject.n_frames
    assert operator.actions <= MOST_ACTIONS
