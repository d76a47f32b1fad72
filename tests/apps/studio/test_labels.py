"""Names that are not sure are proposed for the tracks that they are of."""

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
    document = SimpleNamespace(
        records={"label": SimpleNamespace(figures=figures, findings=())}, marker_set=None, head="",
        now=SimpleNamespace(trajectories=tracks),
    )  # fmt: skip
    proposed = {(one.track, one.name) for one in labels(document).proposals if one.state == "unsure"}
    assert proposed == {(f"*{whole.names.index(name) + 1}", name) for name in short}
