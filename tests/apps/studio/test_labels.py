"""Names that are not sure are proposed for the tracks that they are of."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("fastapi", reason="the studio's dependencies are absent: pip install 'kinemark[studio]'")

from kinemark.apps.studio.labels import labels
from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.findings.labels import label_figures
from kinemark.label import label, learn_template
from support.named_sessions import walk


def test_an_unsure_name_stands_beside_its_track():
    whole = walk(1, 1100.0, 0.8, 1.0).trajectories
    short = {name: 6 for name in ("LTHI", "LTIB")}
    paths = []
    for k, path in enumerate(whole):
        xyz = path.xyz.copy()
        xyz[short.get(path.name, len(xyz)) :] = np.nan
        paths.append(MarkerTrajectory.measured(f"*{k + 1}", xyz))
    tracks = Trajectories(tuple(paths), whole.rate, first_frame=31)
    found = label(tracks, learn_template(whole))
    unsure = found.__class__(**{name: getattr(found, name) for name in found.__slots__} | {
        "state": tuple("unsure" if name in short else one for name, one in zip(found.names, found.state, strict=True))
    })  # fmt: skip
    figures = label_figures(tracks, unsure, tracks, whole.names, ())
    assert proposed(figures, tracks, tracks) == {(f"*{whole.names.index(name) + 1}", name) for name in short}
    joined = Trajectories(tuple(replace(path, name=f"track{path.name[1:]}") for path in paths), whole.rate, 31)
    assert proposed(figures, tracks, joined) == {(f"track{whole.names.index(name) + 1}", name) for name in short}
    assert not proposed(figures, tracks, tracks.select([path.name for path in paths if path.origin.all()]))


def proposed(figures, before, now):
    """Track and name that are proposed when some trajectories have become others."""
    document = SimpleNamespace(
        records={"label": SimpleNamespace(figures=figures, findings=())}, marker_set=None, head="",
        editing=SimpleNamespace(trajectories=before), now=SimpleNamespace(trajectories=now),
    )  # fmt: skip
    return {(one.track, one.name) for one in labels(document).proposals if one.state == "unsure"}
