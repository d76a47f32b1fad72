"""The one place of words: every kind has some, they hold for any value, and nothing else depends on them."""

import json
import re
from string import Formatter
from typing import get_args

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinemark.data import KINDS, SEVERITIES, Finding, make_finding
from kinemark.fill.filled_gap import GapState
from kinemark.io.notes import FileNote, Kind, file_note_text
from kinemark.report.page import page
from kinemark.report.terminal_summary import summary
from kinemark.report.words import (
    SOURCE_ADVICE,
    WORDS,
    advice_of,
    evidence_text,
    headline_of,
    open_gap_text,
    sentences_of,
    text_of,
    with_words,
)
from kinemark.report.words.reasons import EVIDENCE
from kinemark.report.words.template import Words, fill, listed, shown
from kinemark.sensitivity.ranked_sources import Evidence
from support.captures import capture, judge, ring, walk
from support.findings import found

RESERVED = {"kind", "severity", "cameras", "markers", "frames"}
NUMBERS = st.one_of(st.none(), st.floats(-1e12, 1e12), st.just(0.0), st.integers(-(10**12), 10**12))
NAMES = st.text(max_size=12)


def value(name, unit, draw):
    """Any value of a unit."""
    one = {"text": st.one_of(st.none(), NAMES), "flag": st.booleans()}.get(unit, NUMBERS)
    if unit == "count":
        one = st.one_of(st.none(), st.integers(0, 10**12))
    return tuple(draw(st.lists(one, max_size=20))) if name.endswith("_list") else draw(one)


@st.composite
def findings(draw, kind):
    """Any finding of a kind."""
    declared = KINDS[kind]
    names = st.lists(NAMES, max_size=10)
    spans = st.lists(st.tuples(st.integers(0, 10**9), st.integers(0, 10**9)), max_size=6)
    values = {name: value(name, unit, draw) for name, unit in declared.values.items()}
    severity = draw(st.sampled_from(SEVERITIES))
    return make_finding(kind, severity=severity, cameras=draw(names), markers=draw(names), frames=draw(spans), **values)


def test_every_kind_has_words_and_every_words_a_kind():
    assert set(WORDS) == set(KINDS)
    assert not any(RESERVED & set(kind.values) for kind in KINDS.values())


def test_a_source_of_error_says_how_it_is_known():
    assert set(EVIDENCE) == set(get_args(Evidence))
    for source, evidence in zip(SOURCE_ADVICE, EVIDENCE, strict=False):
        row = {"source": source, "mm": 5.0, "evidence": evidence}
        assert evidence_text(row) and with_words([row]) == [row | {"evidence_text": evidence_text(row)}]
    assert evidence_text({"evidence": "usual_placement", "mm": 5.000000001}) == "assumed, 5 mm along each axis"
    assert evidence_text({"evidence": "usual_placement", "mm": None})


@pytest.mark.parametrize("kind", get_args(Kind))
def test_a_note_on_a_file_names_what_it_is_about(kind):
    values = {"rate_hz": 333.0, "stored_rate_hz": 500.0, "seconds": 0.25}
    text = file_note_text(FileNote(kind, "signals", ("a", "b"), values))
    assert "signals a, b" in text and text.endswith(".") and "{" not in text
    assert ("333 to 500 Hz" in text) == (kind == "resampled") and ("0.25 s" in text) == (kind == "cut")
    assert file_note_text(FileNote("read", "no rate stated.")) == "in the source: no rate stated."


@pytest.mark.parametrize("kind", KINDS)
def test_words_hold_for_any_values_and_survive_the_way_through_json(kind):
    @settings(max_examples=30)
    @given(found=findings(kind))
    def law(found):
        again = Finding.of(json.loads(json.dumps(found.as_dict(), allow_nan=False)))
        assert again == found
        text, advice = text_of(found), advice_of(found)
        assert text and (text_of(again), advice_of(again)) == (text, advice)

    law()


@pytest.mark.parametrize("kind", KINDS)
def test_no_place_is_left_unfilled_and_sentences_end(kind):
    declared = KINDS[kind]
    plain = {"text": "x", "flag": True, "count": 3}
    values = {
        name: (plain.get(unit, 1.5),) * 2 if name.endswith("_list") else plain.get(unit, 1.5)
        for name, unit in declared.values.items()
    }
    one = make_finding(kind, cameras=["a", "b"], markers=["m", "n"], frames=[(1, 2)], **values)
    for text in (text_of(one), advice_of(one)):
        assert not re.search(r"[{}|]|None|nan", text)
        assert text == "" or text[-1] in ".?" or kind in HEADLINES
        assert "  " not in text and text.strip() == text


HEADLINES = {kind for kind in KINDS if kind.startswith(("gaps_filled", "nothing_to", "no_marker_s", "angles_"))} | {
    "grid_partly_used",
    "grid_image_unused",
}
"""Titles, and those that end with the message of an error."""


def test_places_of_templates_are_declared():
    for kind, words in WORDS.items():
        for template in (words.text, words.advice):
            names = [name for _, name, _, _ in Formatter().parse(template) if name] if isinstance(template, str) else []
            about = {"cameras", "Cameras", "camera_names", "markers", "Markers", "marker_names"}
            about |= {"first_frame", "last_frame", "frames"}
            assert set(names) <= about | set(KINDS[kind].values)


@pytest.mark.parametrize(
    ("n", "text"),
    [
        (1, "1 gap stayed open, for the reason in the table."),
        (2, "2 gaps stayed open, for the reasons in the table."),
        (0, "0 gaps stayed open, for the reasons in the table."),
    ],
)
def test_one_is_singular(n, text):
    assert text_of(make_finding("gaps_open", gaps=n)) == text


@pytest.mark.parametrize(
    ("frames", "text"),
    [([(5, 5)], "(frame 5)"), ([(5, 9)], "(frames 5–9)"), ([(5, 9), (12, 12)], "(frames 5–9, 12)")],
)
def test_frames_are_singular_and_plural(frames, text):
    one = make_finding("gait_spikes_left_out", trial="walk", markers=["A"], frames=frames, samples=1, most_mm=40.0)
    assert text in text_of(one)


def test_single_frames_in_view_are_no_spans():
    values = {"complete_share": 0.468, "shown": None, "filled_share": 0.0, "gaps": 0, "longest_s": None}
    text = text_of(make_finding("completeness", frames=[(1, 1), (12, 12), (25, 90)], **values))
    assert text.startswith("While the subject was in view (frames 1, 12, 25–90), 46.8")


def test_missing_samples_beside_no_gaps_are_no_contradiction():
    values = {"shown": None, "filled_share": 0.0, "gaps": 0, "longest_s": None}
    some = text_of(make_finding("completeness", frames=[(1, 50)], complete_share=0.952, **values))
    assert some.endswith("no gaps left between a marker's first and last sample.")
    every = text_of(make_finding("completeness", frames=[(1, 50)], complete_share=1.0, **values))
    assert every.endswith("no gaps left.")


def test_what_the_body_did_not_change_is_not_said():
    nothing = dict.fromkeys(("found", "renamed", "joined", "put_aside", "ghosts"), 0)

    def said(**counts):
        return text_of(make_finding("second_pass_by_body", markers=["A"], frames=[(3, 4)], **nothing | counts))

    assert said(found=24) == (
        "By the distances of the named body, 24 points were found that the tracker had missed: A; frames 3–4."
    )
    assert ", 1 point joins a marker and 2 tracks were taken for ghosts: A" in said(found=1, joined=1, ghosts=2)


def test_lists_are_singular_and_plural_and_long_ones_are_cut():
    def missing(*names):
        one = make_finding("markers_never_seen", markers=names)
        return text_of(one), advice_of(one)

    assert missing("A") == (
        "No position in any frame: marker A.",
        "A position needs two cameras that see it: it may have been out of view or hidden, not worn, or not labelled. "
        "Turn cameras, or take it out of the marker set.",
    )
    assert missing("A", "B")[0] == "No position in any frame: markers A, B."
    assert missing(*"ABCDEFGH")[0] == "No position in any frame: markers A, B, C, D, E, F and 2 more."
    assert "that see them: they may" in missing("A", "B")[1]
    assert listed(list("abc"), 2) == "a, b and 1 more"


def test_values_are_written_in_their_unit():
    nbsp = "\u00a0"
    assert shown(0.123456, "mm") == f"0.12{nbsp}mm" and shown(1234.5, "mm") == f"1{nbsp}234{nbsp}mm"
    assert shown(0.5, "share") == f"50.0{nbsp}%" and shown(None, "share") == "–"
    assert shown((1.0, 2.25), "px", "1") == f"1.0, 2.2{nbsp}px"
    assert shown(1940.0, "parts") == f"1{nbsp}900" and shown(0.123, "deg") == "0.12°"
    one = make_finding("precision_low", sd_mm=3.0)
    assert fill("{sd_mm:.3g} {sd_mm:is|are} {{x}}", one) == f"3{nbsp}mm are {{x}}"
    with pytest.raises(KeyError):
        fill("{no_such}", one)


def test_undeclared_findings_are_refused():
    with pytest.raises(ValueError, match="no kind of finding"):
        make_finding("no_such_kind")
    with pytest.raises(ValueError, match=r"wanted \['gaps'\]"):
        make_finding("gaps_open")
    with pytest.raises(ValueError, match="wanted"):
        make_finding("no_frames", gaps=1)


# Nothing depends on the words


def doubtful():
    """A trial with findings of several kinds and severities."""
    rig = ring()
    xyz = walk(markers=4, frames=100)
    xyz[1, 20:60] = float("nan")
    noted = [make_finding("camera_moved", cameras=["cam2"], frames=[(3, 99)])]
    return rig, capture(rig, xyz), noted


def test_other_words_change_no_verdict_no_figure_and_no_finding(monkeypatch):
    rig, records, noted = doubtful()
    before = judge(rig, records, findings=noted)
    for kind in WORDS:
        monkeypatch.setitem(WORDS, kind, Words("frame rate left out 12 mm good", "camera cam1"))
    after = judge(rig, records, findings=noted)
    assert unworded(before) == unworded(after)
    assert before["findings"] != after["findings"] and after["verdict"]["headline"] == "frame rate left out 12 mm good"
    assert "frame rate left out 12 mm good" in summary(after)
    assert "frame rate left out 12 mm good" in page(quality=after, rig=rig, **records)


def unworded(figures):
    """The same without words."""
    if isinstance(figures, list):
        return [unworded(item) for item in figures]
    if isinstance(figures, dict):
        words = ("text", "advice", "headline", "sentences")
        return {key: unworded(item) for key, item in figures.items() if key not in words}
    return figures


def test_words_are_added_once_and_never_read_back():
    rig, records, noted = doubtful()
    figures = judge(rig, records, findings=noted)
    assert with_words(figures) == figures and with_words(unworded(figures)) == figures
    stale = json.loads(json.dumps(figures))
    for one in stale["findings"]:
        one["text"] = "stale"
    assert with_words(stale) == figures and "stale" not in summary(stale)
    assert found(stale, "camera_moved") == noted
    assert figures["verdict"]["headline"] == headline_of(figures["verdict"])
    assert figures["verdict"]["sentences"] == sentences_of(figures["verdict"])


def test_each_state_of_an_open_gap_says_why():
    gap = {"candidates_mm": {"linear": 31.04, "body": 40.0}, "expected_mm": 31.04, "reason": "needs six samples"}
    gap |= {"sd_max_mm": 716.0, "jump_mm": 33.04, "sides_mm": 150.2}
    said = {state: open_gap_text(gap | {"state": state}, 20.0) for state in get_args(GapState)}
    assert said["above_limit"] == (
        "the best method (linear) is expected to be off by 31.0 mm, more than the limit of 20 mm"
    )
    assert said["not_predicted"] == "needs six samples" and "no hold-out gap" in said["no_hold_out"]
    assert "716.0 mm, contradicts the error expected, 31.0 mm" in said["sd_contradicts"]
    assert "jumps by 33.0 mm" in said["jump_contradicts"]
    assert "lies 150 mm apart on its body" in said["sides_contradict"]
    assert said["filled"] == "–" and len(set(said.values())) == len(said)


@pytest.mark.parametrize("cause", ["noise", "smoothing", "placement", "hip centre", "widths", "soft tissue", "plates"])
def test_what_makes_an_angle_uncertain_is_told_without_terms_of_statistics(cause):
    said = text_of(make_finding("gait_deviations", knee_deg=3.8, cause=cause, variance_share=0.5))
    assert "variance" not in said and not said.endswith(f"is {cause}.")


def test_words_point_to_where_things_are_wherever_they_are_read():
    """On the page of a session and in the terminal nothing stood "below"."""
    for kind, words in WORDS.items():
        said = [part for part in words if isinstance(part, str)]
        assert not [one for one in said if " below." in one or "points below" in one], kind
