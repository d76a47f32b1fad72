"""Names that are not sure are proposed for the tracks that they are of."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("fastapi", reason="the studio's dependencies are absent: pip install 'kinemark[studio]'")

from kinemark.apps.studio.labels import labels
from kinemark.data import KinemarkError, MarkerTrajectory, Trajectories, Trial
from kinemark.findings.labels import label_figures
from kinemark.io.marker_sets import read_marker_set
from kinemark.io.trial import write_trial
from kinemark.label import label, learn_template
from support.named_sessions import walk
from support.studio import Studio, file_in
from support.walked import clean, without


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
        records={"label": SimpleNamespace(figures=figures, findings=())}, marker_set=None, head="", trial=object(),
        editing=SimpleNamespace(trajectories=before), now=SimpleNamespace(trajectories=now),
    )  # fmt: skip
    return {(one.track, one.name) for one in labels(document).proposals if one.state == "unsure"}


def test_names_of_a_file_without_a_session_are_proposed_when_they_are_asked_for(tmp_path, monkeypatch):
    """Not before; by the file that tells them; and of a track that was changed since no longer."""
    from kinemark.apps.studio import labels as module
    from kinemark.engine.naming.proposed_names import ProposedName, ProposedNames

    asked = []

    def found(path, tracks):
        asked.append((path.name, tracks.names))
        return ProposedNames("walk0.c3d", {"*4": ProposedName("LTOE", 0.995, "RTOE", True)}, ("LTOE", "RTOE"))

    monkeypatch.setattr(module, "propose_names", found)
    studio = Studio(file_in(tmp_path))
    before = studio.page.get(f"{studio.trial}/labels").json()
    assert (before["proposals"], before["can_ask"], before["by"], asked) == ([], True, "", [])
    after = studio.page.get(f"{studio.trial}/labels?ask=true").json()
    (one,) = after["proposals"]
    assert (one["track"], one["name"], one["state"], after["by"]) == ("*4", "LTOE", "sure", "walk0.c3d")
    assert (before["known"], after["known"]) == ([], ["LTOE", "RTOE"]), "though no track has them"
    assert studio.page.get(f"{studio.trial}/labels").json() == after and len(asked) == 1 and asked[0][0] == "walk.c3d"
    studio.act(kind="claim", track="*4", name=one["name"])
    named = studio.page.get(f"{studio.trial}/labels").json()
    assert named["proposals"] == [] and not named["can_ask"]
    monkeypatch.setattr(module, "propose_names", lambda *_: ProposedNames("", {}))
    none = studio.page.get(f"{studio.trial}/labels?ask=true").json()
    assert none["by"] == "" and "none of the templates" in none["words"]


def test_left_and_right_of_a_file_are_exchanged_by_how_its_markers_are_called(tmp_path):
    """It has no marker set that says so."""
    studio = Studio(file_in(tmp_path))
    before = paths_of(studio)
    assert studio.page.get(studio.trial).json()["pairs"] == [["LKNE", "RKNE"]]
    assert studio.act(kind="sides").status == 200
    after = paths_of(studio)
    assert np.array_equal(after["LKNE"], before["RKNE"]) and np.array_equal(after["RKNE"], before["LKNE"])
    studio.act(kind="claim", track="RKNE", name=None)
    assert studio.page.get(studio.trial).json()["pairs"] == [] and studio.act(kind="sides").status >= 400


def test_left_and_right_are_exchanged_in_a_stretch_that_has_only_one_of_both(tmp_path):
    whole = clean(markers=12).frames(0, 60)
    left, right = next((n, "R" + n[1:]) for n in whole.names if n[0] == "L" and "R" + n[1:] in whole.names)
    write_trial(Trial("walk", without(whole, whole.names.index(right), 10, 30)), tmp_path / "walk.c3d")
    studio = Studio(tmp_path / "walk.c3d")
    first, before = studio.page.get(studio.trial).json()["first_frame"], paths_of(studio)
    assert studio.act(kind="sides", first=first + 15, last=first + 25).status == 200
    after, at = paths_of(studio), slice(15, 26)
    assert np.array_equal(after[right][at], before[left][at]) and np.isnan(after[left][at]).all()
    assert np.array_equal(after[left][26:], before[left][26:]) and np.isnan(after[right][10:15]).all()


def paths_of(studio):
    """xyz by name, as the page gets them."""
    answer = studio.page.get(f"{studio.trial}/paths?column=xyz")
    about = json.loads(answer.headers["x-kinemark-paths"])
    xyz = np.frombuffer(answer.body, np.float32).reshape(len(about["names"]), about["n_frames"], 3)
    return dict(zip(about["names"], xyz, strict=True))


def test_a_link_is_stretched_within_a_segment_and_bends_over_a_joint():
    """Hips and thighs of a walker change their distance and are right; a knee that is another's is not."""
    whole = walk(1, 1100.0, 0.8, 1.0).trajectories
    exchanged = {"LKNE": "RKNE", "RKNE": "LKNE"}
    wrong = Trajectories(
        tuple(replace(path, xyz=_half(path, whole[exchanged.get(path.name, path.name)])) for path in whole),
        whole.rate,
        1,
    )
    assert set(_states(whole).values()) == {"steady", "bends"}
    assert {link for link, state in _states(whole).items() if state == "bends"} == {("LASI", "LTHI"), ("RASI", "RTHI")}
    assert {state for link, state in _states(wrong).items() if "LKNE" in link} == {"stretched"}
    assert set(_states(whole.frames(0, 5)).values()) == {"unknown"}


def _half(path, other):
    middle = len(path.xyz) // 2
    return np.concatenate([path.xyz[:middle], other.xyz[middle:]])


def _states(tracks):
    document = SimpleNamespace(
        records={}, marker_set=read_marker_set("kiss-15"), head="", trial=object(),
        editing=SimpleNamespace(trajectories=tracks), now=SimpleNamespace(trajectories=tracks),
    )  # fmt: skip
    return {(one.a, one.b): one.state for one in labels(document).links}


def test_a_files_marker_set_is_the_one_whose_names_it_has(tmp_path):
    """It was forgotten with the studio, though the file says it by its names; of several the fullest is meant."""
    lower, full = (read_marker_set(f"plug-in-gait-{which}").names for which in ("lower", "full"))
    one_leg = [
        name for name in full if name[0] != "R"
    ]  # has most of the markers of smaller sets, which it does not wear
    for names, wanted in (lower, "plug-in-gait-lower"), (full, "plug-in-gait-full"), (lower[:5], None), (one_leg, None):
        there = [*names, "LTOP", "RTOP", "LTIP"]
        paths = tuple(MarkerTrajectory.measured(name, np.full((4, 3), float(k))) for k, name in enumerate(there))
        write_trial(Trial("walk", Trajectories(paths, 100.0)), file := tmp_path / f"{len(names)}.c3d")
        studio = Studio(file)
        shown = studio.page.get(studio.trial).json()
        assert (shown["marker_set"] and shown["marker_set"]["name"]) == wanted
        assert ["LTOP", "RTOP"] in shown["pairs"] and "LTIP" in shown["one_sided"], "those besides are still paired"


def test_a_marker_set_that_is_chosen_for_a_file_is_there_in_the_next_studio(tmp_path):
    """It was forgotten with the studio; sets of the laboratory's own, beside the file, could not be chosen at all."""
    (tmp_path / "mine.toml").write_text("[markers]\nLKNE = {}\nEXTRA = {}\n", encoding="utf-8")
    (tmp_path / "measures.toml").write_text("mass_kg = 70\n", encoding="utf-8")
    studio = Studio(file := file_in(tmp_path))
    sets = {one["name"]: one for one in studio.page.get(f"{studio.trial}/marker-sets").json()}
    assert sets["kiss-15"]["markers"] == 15 and sets["kiss-15"]["there"] == 2  # LKNE and RKNE
    assert not any(one["worn"] for one in sets.values())
    assert "mine.toml" in sets and "measures.toml" not in sets
    for name in ("kiss-15", None, "um2as-7", "mine.toml"):
        now = studio.page.post(f"{studio.trial}/marker-set", {"name": name}).json()
        assert [one["name"] for one in now if one["worn"]] == ([name] if name else [])
        shown = studio.page.get(studio.trial).json()["marker_set"]
        assert bool(shown) == bool(name)
        again = Studio(file)
        assert again.page.get(again.trial).json()["marker_set"] == shown
    assert studio.page.post(f"{studio.trial}/marker-set", {"name": "../secret.toml"}).status == 404
    (tmp_path / "mine.toml").unlink()
    again = Studio(file)
    assert again.page.get(again.trial).json()["marker_set"] is None, "its file is gone"
    for damaged in ('{"marker_set": ["mine.toml"]}', "[]", "{"):
        (tmp_path / "edits" / f"{file.stem}.json").write_text(damaged, encoding="utf-8")
        assert Studio(file).page.get(again.trial).status == 200


def test_a_marker_set_is_worn_where_nobody_may_write(tmp_path, monkeypatch):
    def refused(*_):
        raise KinemarkError("cannot be written")

    monkeypatch.setattr("kinemark.apps.studio.worn_sets.keep_choice", refused)
    studio = Studio(file_in(tmp_path))
    assert studio.page.post(f"{studio.trial}/marker-set", {"name": "kiss-15"}).status == 200
    assert studio.page.get(studio.trial).json()["marker_set"]["name"] == "kiss-15"
