"""What limits the accuracy of a recording: what residuals show, the ranking, and the page."""

import json
from dataclasses import replace

import numpy as np
import pytest

from kinemark.apps.commands.analysis import sensitivity as sensitivity_command
from kinemark.data import Cloud, Detections, KinemarkError, MarkerTrajectory, Rig, Tracks, Trajectories
from kinemark.engine.editing.files import open_editing
from kinemark.engine.error_budget import error_budget
from kinemark.engine.session import Session
from kinemark.findings.sensitivity_figures import sensitivity_figures
from kinemark.io.records import save
from kinemark.io.rig_toml import write_rig_toml
from kinemark.report.sensitivity_page import sensitivity_page
from kinemark.sensitivity import ErrorBudget, SampledFrames, gather, gather_named, rank, segments, typical
from support.captures import ring
from support.error_budget import RATE, dance, moved_cameras, recorded, shown_by
from support.findings import kinds
from support.schema import check_findings
from support.shared import shared_data
from support.studies import figures, printed


def without_similarity(move, xyz):
    x, y, z = (xyz - xyz.mean(0)).T
    o = np.zeros_like(x)
    turns = [np.stack(v, -1).ravel() for v in ((o, -z, y), (z, o, -x), (-y, x, o), (x, y, z))]
    G = np.stack([*turns, *(np.tile(axis, len(xyz)) for axis in np.eye(3))], 1)
    return move - (G @ np.linalg.lstsq(G, move.ravel(), rcond=None)[0]).reshape(-1, 3)


def test_noise_alone_is_found_as_noise():
    rig = ring(5)
    found = shown_by(rig, recorded(rig, noise=0.15))
    assert found.noise_px == pytest.approx(0.15, rel=0.05)
    assert found.calibration_px < 0.02 and found.lens_px < 0.03


def test_a_wrong_calibration_is_found_as_one():
    """Its effect on the points, but for a turn, a shift and a scale of them all, is that of the truth."""
    rig = ring(5)
    xyz = dance()
    there = recorded(rig, moved_cameras(rig), noise=0.1, xyz=xyz)
    found = shown_by(rig, there)
    assert found.noise_px == pytest.approx(0.1, rel=0.1)
    assert found.calibration_px > 3 * found.lens_px
    off = (recorded(rig, moved_cameras(rig), noise=1e-9, xyz=xyz).xyz - xyz).reshape(-1, 3)[found.used]
    true = without_similarity(off, xyz.reshape(-1, 3)[found.used])
    size = np.sqrt((found.calibration[found.used] ** 2).mean())
    assert size == pytest.approx(np.sqrt((true**2).mean()), rel=0.25)
    assert np.corrcoef(found.calibration[found.used].ravel(), true.ravel())[0, 1] > 0.8


def test_a_lens_that_is_not_described_is_found_as_one():
    """What no change of a camera explains; the three kinds of error together are all that was put in."""
    rig = ring(5)
    xyz = dance(frames=400)
    there = recorded(rig, noise=0.05, xyz=xyz, bend=lambda uv: 0.3 * np.sin(uv / 20.0))
    found = shown_by(rig, there)
    assert found.lens_px > 2 * found.calibration_px and found.lens_px > 2 * 0.05
    parts = found.noise_px**2 + found.lens_px**2 + found.calibration_px**2
    assert parts == pytest.approx(0.05**2 + 0.3**2 / 2, rel=0.2)
    off = recorded(rig, noise=1e-9, xyz=xyz, bend=lambda uv: 0.3 * np.sin(uv / 20.0)).xyz - xyz
    both = (found.lens + found.calibration)[found.used].ravel()
    assert np.corrcoef(both, off.reshape(-1, 3)[found.used].ravel())[0, 1] > 0.6


def test_disturbed_images_are_told_from_noise():
    """One image in twelve is off by 5 px, as of half hidden markers: no noise, no calibration, and as much in mm."""
    rig, xyz = ring(5), dance(frames=300)

    def hidden(uv):
        rng = np.random.default_rng(7)
        theta = rng.uniform(0, 2 * np.pi, uv.shape[:3])
        off = 5.0 * np.stack([np.cos(theta), np.sin(theta)], -1)
        return np.where(rng.random(uv.shape[:3])[..., None] < 1 / 12, off, 0.0)

    there = recorded(rig, noise=0.1, xyz=xyz, bend=hidden, hide=0.1)
    ranking = rank(rig, there, method=ErrorBudget(placement_mm=0.1))
    by = {source.name: source for source in ranking.sources}
    assert ranking.sources[0].name == "disturbed images"
    assert by["centroid noise"].px == pytest.approx(0.1, rel=0.15)
    assert by["disturbed images"].px == pytest.approx(5 / np.sqrt(2 * 12), rel=0.15)
    assert by["calibration"].px < 0.05
    off = there.xyz - xyz
    assert np.sqrt(np.nanmean(by["disturbed images"].mm ** 2)) == pytest.approx(np.sqrt(np.nanmean(off**2)), rel=0.1)


def test_ranks_change_with_what_is_wrong():
    rig = ring(5)
    clean, noisy = (rank(rig, recorded(rig, noise=sd)) for sd in (0.02, 3.0))
    assert clean.sources[0].name == "marker placement"
    assert noisy.sources[0].name == "centroid noise"
    careful = rank(rig, recorded(rig, moved_cameras(rig), noise=0.02), method=ErrorBudget(placement_mm=0.05))
    assert careful.sources[0].name == "calibration"


def test_sigma_of_noise_is_that_of_a_simulation():
    rig, xyz = ring(4), dance(frames=40)
    trials = np.array([recorded(rig, noise=0.2, xyz=xyz, seed=s, hide=0.0).xyz for s in range(60)])
    ranking = rank(rig, recorded(rig, noise=0.2, xyz=xyz, hide=0.0), method=ErrorBudget(centroid_sd=0.2))
    source = next(s for s in ranking.sources if s.name == "centroid noise")
    assert np.sqrt((source.mm**2).mean()) == pytest.approx(np.sqrt(trials.var(0).mean()), rel=0.05)
    line = trials[:, 1] - trials[:, 0]
    line /= np.linalg.norm(line, axis=-1, keepdims=True)
    turned = np.degrees(np.sqrt(((line - line.mean(0)) ** 2).sum(-1).mean() / 2))
    assert np.sqrt((source.deg[:, :2] ** 2).mean()) == pytest.approx(turned, rel=0.1)


def test_a_stated_calibration_counts_where_it_is_more():
    sd = np.array([2, 2, 0, 0, 0, 0, 0, 0, 0, 2e-4, 2e-4, 2e-4, 1, 1, 1.0])
    rig = Rig(tuple(replace(camera, cov=np.diag(sd**2)) for camera in ring(5)))
    ranking = rank(rig, recorded(rig, noise=0.05))
    source = next(s for s in ranking.sources if s.name == "calibration")
    assert source.evidence == "calibration_covariance"
    assert typical(source.mm) == pytest.approx(ranking.stated_mm) and ranking.stated_mm > ranking.shown_mm


def test_the_camera_that_stands_apart_is_missed_most():
    rig = ring(12)
    three = rig.select(["cam1", "cam2", "cam4"])  # 30° apart, and one at a right angle
    ranking = rank(three, recorded(three, hide=0.0))
    assert ranking.lost[0].camera == "cam4"
    for lost in ranking.lost:
        assert typical(lost.mm) > typical(lost.all_mm) and lost.gone == 0
    hidden = rank(three, recorded(three, hide=0.3))
    assert all(0.1 < lost.gone < 0.8 for lost in hidden.lost)


def test_two_cameras_have_nothing_to_lose():
    rig = ring(4).select(["cam1", "cam2"])
    ranking = rank(rig, recorded(rig, hide=0.0))
    assert ranking.lost == ()
    told = sensitivity_figures(ranking, session="s", trial="t")
    assert next(r for r in told["ranking"] if r["source"] == "centroid noise")["evidence"] == "usual_noise"
    assert kinds(told)[-1] == "two_cameras_no_loss" and told["verdict"]["statements"][-1] == told["findings"][-1]
    assert "<html" in sensitivity_page(figures=told, ranking=ranking, rig=rig)


def test_segments_are_markers_that_keep_their_distance():
    rig = ring(5)
    there = recorded(rig, noise=0.02)
    assert segments(there) == [(0, 1), (2, 3), (4, 5), (6, 7)]
    one = SampledFrames(there.names[:1], there.xyz[:1], there.uv[:1], there.time_s)
    ranking = rank(rig, one)
    assert ranking.angles == () and ranking.unit == "mm"
    told = json.loads(json.dumps(sensitivity_figures(ranking, session="s", trial="t")))
    assert told["total"]["deg"] is None
    assert "no angles" in sensitivity_page(figures=told, ranking=ranking, rig=rig)


def test_a_mean_makes_only_noise_smaller():
    rig = ring(5)
    ranking = rank(rig, recorded(rig, noise=1.0), method=ErrorBudget(placement_mm=0.5))
    by = {s.name: s for s in ranking.sources}
    one, many = ranking.total("mm"), ranking.total("mm", cycles=100)
    assert (many < one)[np.isfinite(one)].all()
    fixed = np.sqrt(
        by["calibration"].mm ** 2
        + by["lens model"].mm ** 2
        + by["marker placement"].mm ** 2
        + by["disturbed images"].mm ** 2
    )
    assert (many >= 0.999999 * fixed)[np.isfinite(fixed)].all() and np.isfinite(fixed).any()


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    """A session of detections, run, with a name that needs care in a page."""
    folder = tmp_path_factory.mktemp("s")
    rig = ring(4)
    write_rig_toml(folder / "rig.toml", rig)
    uv = recorded(rig, xyz=dance(frames=60), hide=0.0, noise=0.1).uv
    counts = np.full((4, 60), 8)
    rows = uv.transpose(2, 1, 0, 3).reshape(-1, 2)
    save(folder / "d.h5", Detections.build(rig.names, RATE, counts, rows))
    lines = ['name = "<b>Müller & Söhne</b>"', "[calibration]", 'file = "rig.toml"']
    lines += ["[[trials]]", 'name = "walk01"', 'detections = "d.h5"']
    (folder / "session.toml").write_text("\n".join(lines), "utf-8")
    return folder


def test_the_command_ranks_a_session(session, capsys):
    sensitivity_command(session, placement_mm=3.0)
    said = capsys.readouterr().out
    assert "marker placement" in said and "centroid noise" in said and "sensitivity.html" in said
    with pytest.raises(KinemarkError, match="placement_mm is -3"):
        sensitivity_command(session, placement_mm=-3.0)
    with pytest.raises(KinemarkError, match="no trial"):
        sensitivity_command(session, trial="walk99")
    saved = json.loads((session / "results/walk01/sensitivity.json").read_text("utf-8"))
    check_findings(saved)
    assert saved["placement_mm"] == 3 and len(saved["ranking"]) == 5 and len(saved["lost"]) == 4
    assert sum(row["variance_share"] for row in saved["ranking"]) == pytest.approx(1)
    page = (session / "results/walk01/sensitivity.html").read_text("utf-8")
    assert "&lt;b&gt;Müller &amp; Söhne&lt;/b&gt;" in page and "<b>Müller" not in page


def test_named_markers_of_the_same_recording(session, tmp_path):
    result = Session.open(session).run(["walk01"])["walk01"]
    names = Trajectories(tuple(MarkerTrajectory.measured(f"M{m}", p) for m, p in enumerate(dance(frames=60))), RATE)
    there = gather_named(names, result.tracks, result.detections, frames=50)
    assert there.names[0] == "M0" and there.seen.any(2).mean() > 0.99
    away = Trajectories(tuple(MarkerTrajectory.measured(p.name, p.xyz + 500) for p in names), RATE)
    with pytest.raises(KinemarkError, match="same world"):
        gather_named(away, result.tracks, result.detections, frames=50)
    with pytest.raises(KinemarkError, match="same recording"):
        gather_named(replace(names, rate=50.0), result.tracks, result.detections, frames=50)
    with pytest.raises(KinemarkError, match="wants the markers"):
        error_budget(session, model="um2as")
    (tmp_path / "x.trc").write_text("nothing")
    with pytest.raises(KinemarkError):
        error_budget(session, markers=tmp_path / "x.trc")


def test_a_trial_whose_markers_have_names_is_judged_by_them(session):
    """Before, a session that names its markers was told of *1 to *15, and a model wanted a file of the same names."""
    result = Session.open(session).run(["walk01"])["walk01"]
    before = error_budget(session).figures
    editing = open_editing(session / "walk01", by="me")
    one, *others = result.trajectories.names
    editing.claim(one, "LKNE")
    named = error_budget(session).figures
    editing.journal.undo()
    names = [row["marker"] for row in named["by_marker"]]
    assert "LKNE" in names and one not in names and set(others) <= set(names)
    assert named["total"]["mm"] == pytest.approx(before["total"]["mm"], rel=0.05)
    assert "LKNE" in (session / "results/walk01/sensitivity.html").read_text("utf-8")


def test_what_cannot_be_judged_is_refused():
    rig = ring(3)
    there = recorded(rig)
    with pytest.raises(KinemarkError, match="needs two cameras"):
        rank(rig.select(["cam1"]), SampledFrames(there.names, there.xyz, there.uv[:, :, :1], there.time_s))
    with pytest.raises(KinemarkError, match="Two cameras see 0 points"):
        rank(rig, SampledFrames(there.names, there.xyz, np.full_like(there.uv, np.nan), there.time_s))
    cloud = Cloud(RATE, np.zeros(11), np.zeros((0, 3)), np.zeros((0, 3, 3)), [], np.zeros((0, 3)))
    nothing = Detections.build(rig.names, RATE, np.zeros((3, 10)), np.zeros((0, 2)))
    with pytest.raises(KinemarkError, match="nothing to judge by"):
        gather(Tracks(cloud, np.zeros(0)), nothing, frames=5)
    for wrong in ({"placement_mm": -1}, {"cycles": 0}, {"centroid_sd": 0.0}, {"frames": 1}):
        with pytest.raises(ValueError, match=next(iter(wrong))):
            ErrorBudget(**wrong)


def test_the_study_of_the_thesis():
    """Its figures, from few samples; the chain to joint angles agrees with the simulation beside it."""
    shared_data("cameras/gait9_bts/gait9.tdf")
    text = printed("um2as_sensitivity", "--samples", 20_000)
    assert figures(text, "table 4.2 of the thesis by its equation 4.11:")[0] == 0.70
    right, wrong = figures(text, "13.0   right"), figures(text, "13.0   wrong by 0.5 px, anew")
    assert right[4] == pytest.approx(33.3, abs=0.3) and wrong[4] > right[4]
    assert "the same samples: True" in text
    for joint in ("shoulder flexion/extension", "elbow pronation/supination", "wrist flexion/extension"):
        frame, frame_found, mean, mean_found = figures(text, joint)[:4]
        assert frame_found == pytest.approx(frame, rel=0.1) and mean_found == pytest.approx(mean, rel=0.1)
    noise = figures(text, "centroid noise")
    assert 0.05 < noise[0] < 0.2 and 0.3 < noise[1] < 1.0
