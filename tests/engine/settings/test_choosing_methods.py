"""Every method from matching to tracking can be chosen in Python, in session.toml and on the command line.

The parameters have the same names and the same defaults everywhere, those of the documents.
"""

import json
import subprocess
import sys
from dataclasses import fields, replace

import pytest

from kinemark.apps.commands.listings import methods
from kinemark.data import KinemarkError, same
from kinemark.engine.session import Session
from kinemark.engine.settings import STAGES, methods_figures, methods_text
from kinemark.engine.settings.method_tables import SETTABLE, method_of
from kinemark.match import match
from kinemark.reconstruct import reconstruct
from kinemark.track import matches_itself, track
from kinemark.track.simultaneous import track_detections
from support.sessions import folder_of

NAMED = {
    "match": {
        "epipolar_triplets": ("search_band", "search_radius", "candidates", "pairs", "pair_band"),
        "kiss_triplets": ("search_band", "search_radius", "candidates", "priority", "all_duals"),
        "nearest_epipolar": ("cameras", "search_band"),
    },
    "reconstruct": {
        "least_squares": ("centroid_sd", "model_sd", "degrees_of_freedom"),
        "camera_pairs": ("outlier_ratio",),
    },
    "track": {
        "simultaneous": ("gate", "process_noise", "max_coasting", "max_gap", "max_sd"),
        "former_two_cameras": ("window", "n_markers", "max_residual", "min_fields"),
        "extrapolation_ladder": ("gate", "max_coasting", "min_points"),
        "kiss_tracking": ("search_radius", "max_distance", "max_gap", "min_points", "volume"),
        "swamidas": ("measurement_sd", "jerk", "velocity_share", "segment_tolerance", "links", "lengths"),
        "distance_only": ("initiate_from", "max_coasting"),
    },
}
"""What the documents name, of each method in a session file."""


def test_every_method_has_a_name_in_session_files_and_its_parameters_are_the_documents():
    for stage, kinds in NAMED.items():
        assert set(STAGES[stage]) == set(kinds)
        for name, wanted in kinds.items():
            assert set(wanted) <= {field.name for field in fields(STAGES[stage][name].kind)}


def test_the_list_of_methods_says_what_the_dataclasses_say():
    for stage, figures in methods_figures().items():
        for name, told in figures["methods"].items():
            method = STAGES[stage].make(name, **({"markers": ("A",)} if stage == "digitise" else {}))
            records = {"static", "model", "limbs", "learned", "hyper"}  # of filling and tracking: no text says these
            plain = [
                field.name for field in fields(method) if stage not in ("fill", "track") or field.name not in records
            ]
            defaults = {name: p["default"] for name, p in told["parameters"].items() if not p.get("required")}
            assert list(told["parameters"]) == plain
            assert defaults == {name: getattr(method, name) for name in plain if name in defaults}
    assert "search_radius  40.0   mm      above 0" in methods_text("track")
    with pytest.raises(KinemarkError, match="did you mean 'track'"):
        methods_text("trak")


FORMER = [
    (stage, name, p.former, p.name)
    for stage, kinds in SETTABLE.items()
    for name, declared in kinds.items()
    for p in declared.parameters
    if p.former
]


@pytest.mark.parametrize(("stage", "name", "former", "now"), FORMER)
def test_who_uses_the_former_name_of_a_parameter_is_told_the_new_one(stage, name, former, now):
    assert former not in {field.name for field in fields(STAGES[stage][name].kind)}
    with pytest.raises(ValueError, match=f"'{former}' of {name} is now called '{now}'"):
        method_of(stage, {"method": name, former: 1})


def by_hand(detections, rig, settings):
    """The tracks as a caller of the library makes them."""
    if matches_itself(settings.track):
        return track_detections(detections, rig, method=settings.track)
    matches = match(detections, rig, method=settings.match)
    return track(reconstruct(matches, detections, rig, method=settings.reconstruct), method=settings.track)


@pytest.mark.parametrize("stage", ["match", "reconstruct", "track"])
def test_python_toml_and_command_line_are_one(tmp_path, stage):
    """The same method with a parameter of its own, in all three ways, gives the same tracks."""
    odd = {
        "match": {"epipolar_triplets": "pair_band = 0.7", "kiss_triplets": "all_duals = true"},
        "reconstruct": {"camera_pairs": "outlier_ratio = 3.0", "least_squares": "model_sd = 0.2"},
        "track": {
            "kiss_tracking": "search_radius = 25.0",
            "swamidas": "jerk = 5000.0",
            "distance_only": 'initiate_from = "any"',
        },
    }
    for k, (name, parameter) in enumerate(odd[stage].items()):
        other = "" if stage == "track" else '[track]\nmethod = "extrapolation_ladder"\n'
        (tmp_path / f"{k}").mkdir()
        folder, rig, detections = folder_of(
            tmp_path / f"{k}", more=f'{other}[{stage}]\nmethod = "{name}"\n{parameter}\n'
        )
        written = Session.open(folder)
        (folder / "session.toml").write_text((folder / "session.toml").read_text().split(f"[{stage}]")[0])
        key, value = parameter.split(" = ")
        given = Session.open(folder, overrides=[f"{stage}.method={name}", f"{stage}.{key}={value.strip(chr(34))}"])
        assert given.settings == written.settings
        assert type(getattr(given.settings, stage)) is STAGES[stage][name].kind
        assert getattr(getattr(given.settings, stage), key) != getattr(STAGES[stage].make(name), key)
    from_session = given.run(to="track")["one"].tracks
    assert same(from_session, by_hand(detections, rig, given.settings))


def test_a_method_given_leaves_the_files_parameters_of_another_aside(tmp_path):
    folder, *_ = folder_of(tmp_path, more='[track]\nmethod = "kiss_tracking"\nsearch_radius = 25.0\nmin_points = 4\n')
    opened = lambda *given: Session.open(folder, overrides=given).settings.track  # noqa: E731
    assert opened("track.method=swamidas") == STAGES["track"].make("swamidas")
    assert opened("track.min_points=6") == replace(opened(), min_points=6)
    assert opened("track.method=kiss_tracking", "track.min_points=6") == replace(opened(), min_points=6)
    assert opened("track.method=swamidas", "track.links=[[0, 1]]").links == ((0, 1),)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("track", "wanted stage.parameter=value"),
        ("track.method", "wanted stage.parameter=value"),
        ("track.=3", "wanted stage.parameter=value"),
        ("track.method=", "wanted stage.parameter=value"),
        ("trak.method=swamidas", "did you mean 'track'"),
        ("rate_hz.x=100", "is no stage"),
        ("track.method=swamida", "did you mean 'swamidas'"),
        ("track.serch_radius=3", "is not a parameter of simultaneous"),
        ("track.gate=wide", "track.gate"),
        ("match.search_band=3", "would do nothing"),
    ],
)
def test_what_cannot_be_set_is_explained(tmp_path, given, said):
    folder, *_ = folder_of(tmp_path)
    with pytest.raises(KinemarkError, match=said.replace(".", r"\.")):
        Session.open(folder, overrides=[given])


def test_the_former_method_is_chosen_with_two_cameras(tmp_path):
    folder, rig, detections = folder_of(tmp_path, n_cameras=2)
    given = Session.open(folder, overrides=["track.method=former_two_cameras", "track.window=20"])
    assert given.settings.track.window == 20
    assert same(given.run(to="track")["one"].tracks, by_hand(detections, rig, given.settings))


def test_methods_are_chosen_by_command(tmp_path):
    folder, *_ = folder_of(tmp_path, n_cameras=2)
    own = ["track.method=distance_only", "match.method=nearest_epipolar", "match.search_band=1.5"]
    options = [part for text in own for part in ("--set", text)]
    command = [sys.executable, "-m", "kinemark", "run", str(folder), "--json", *options]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    steps = {step["stage"]: step for step in json.loads(done.stdout)["one"]["steps"]}
    assert (steps["track"]["method"], steps["match"]["method"]) == ("DistanceOnly", "NearestEpipolar")
    assert steps["match"]["parameters"]["search_band"] == 1.5


def test_the_methods_are_listed_by_command(capsys):
    methods("match", json=True)
    assert set(json.loads(capsys.readouterr().out)["match"]["methods"]) == set(NAMED["match"])
    methods()
    assert 'method = "kiss_tracking"' in capsys.readouterr().out
