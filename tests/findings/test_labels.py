"""What is said of the names of a trial's markers."""

from dataclasses import replace

import numpy as np

from kinemark.data.finding import Finding
from kinemark.findings.labels import displaced_finding, label_figures, label_findings
from kinemark.label import Labels, named
from kinemark.report.words import text_of
from kinemark.synth import walking, with_markers


def surely(names):
    """Labels all of which are sure."""
    n = len(names)
    return Labels(tuple(names), np.ones(n), ("sure",) * n, (None,) * n, np.full(n, 9.0), 1.0, 1.0)


def test_a_named_marker_beside_its_place_is_a_finding_and_one_without_name_is_none():
    tracks = with_markers(walking(duration_s=0.1, rate=50.0, seed=1), 15, seed=1).trajectories
    labels = replace(surely(tracks.names), displaced=(("LTIB", 24.4), ("NOBODY", 31.0)))
    nothing_else = {"switches": [], "ghosts_removed": 0}
    figures = label_figures(tracks, labels, named(tracks, labels), tracks.names, ("known.c3d",)) | nothing_else
    [found] = label_findings(figures, labels, template=True)
    assert (found.kind, found.severity, found.markers) == ("markers_displaced", "amber", ("LTIB",))
    assert text_of(found) == "A named marker sits beside its place in the template: LTIB by 24\u00a0mm."
    figures = label_figures(tracks, surely(tracks.names), tracks, tracks.names, ()) | nothing_else
    assert label_findings(figures, labels, template=True) == ()


def test_words_survive_what_is_not_known():
    text = text_of(displaced_finding([{"name": "A{", "off_mm": float("nan")}, {"name": "B", "off_mm": None}]))
    assert text.endswith("A{ by –, B by –.")
    assert text_of(Finding.of(displaced_finding([]).as_dict())).endswith("template: –.")
