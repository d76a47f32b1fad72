"""Laws of planned cameras: what is predicted is what a simulated session shows, and a better plan is better."""

import json
from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import KinemarkError, Rig, make_finding
from kinemark.engine.camera_plan import camera_plan
from kinemark.engine.plan_settings import PlanSettings
from kinemark.io.rig_toml import read_rig_toml, write_rig_toml
from kinemark.planning import Planning, Room, Sensor, plan_cameras, predict, walks
from kinemark.planning.sight import run_together
from kinemark.report.words import headline_of, with_words
from kinemark.synth import look_at, observe, ring
from kinemark.synth.score import score
from kinemark.track.simultaneous import track_detections

BOX = np.array([[0.0, 0.0, 0.0], [2000.0, 1200.0, 1800.0]])
ROOM = Room(BOX, (1800.0, 2400.0), (2000.0, 2000.0))
FEW = Room(BOX, (2000.0, 2000.0), (2000.0, 2000.0))
"""One height and one distance: few candidates, for speed."""


@pytest.fixture(scope="module")
def plan():
    return plan_cameras(ROOM, Sensor(), Planning(cameras=4))


def rms(sd):
    return float(np.sqrt(3 * np.nanmean(sd**2)))


def simulated(rig, room, *, diameter_mm, noise_px, seed):
    """Error in 3D and share found of the markers of a simulated session that is tracked."""
    body = walks(room, diameter_mm=diameter_mm, frames=100)[0]
    across = np.nanmedian([c.K[0, 0] * diameter_mm / np.linalg.norm(body.xyz - c.centre, axis=-1) for c in rig])
    seen = observe(rig, body, noise_px=noise_px, merge_px=float(across), seed=seed)
    found = score(track_detections(seen.detections, rig), body.xyz)
    return found.rmse, found.recall


@pytest.mark.parametrize(
    ("rig", "diameter", "noise"),
    [
        (ring(5, radius=3500.0, target=(1000.0, 600.0, 850.0), start_deg=20.0, focal_px=1500.0), 14.0, 0.2),
        (ring(3, radius=3000.0, target=(1000.0, 600.0, 850.0), sweep_deg=150.0), 10.0, 0.1),
        (None, 14.0, 0.1),
    ],
)
def test_a_simulated_session_is_as_exact_and_as_complete_as_predicted(plan, rig, diameter, noise):
    rig = rig or plan.rig
    sizes = {"diameter_mm": diameter, "least_px": 0.0, "centroid_sd": noise}
    body = predict(rig, ROOM, walks(ROOM, diameter_mm=diameter), **sizes).body
    error, found = simulated(rig, ROOM, diameter_mm=diameter, noise_px=noise, seed=3)
    assert rms(body.sd) == pytest.approx(error, rel=0.15)
    assert body.share(2) == pytest.approx(found, abs=0.04)


def test_a_plan_is_better_than_a_ring_of_as_many(plan):
    around = ring(4, radius=2800.0, height=(1800.0, 2400.0), target=(1000.0, 600.0, 900.0))
    other = predict(around, ROOM, walks(ROOM, diameter_mm=14.0), diameter_mm=14.0, least_px=2.5, centroid_sd=0.1)
    planned = plan.prediction.body
    assert planned.share(2) >= other.body.share(2) and planned.share(3) > other.body.share(3)


def test_one_more_camera_brings_what_the_plan_says_of_it(plan):
    before, after = plan.prediction.body, plan.with_following.body
    assert after.share(3) >= before.share(3) and np.nanmedian(after.sd) < np.nanmedian(before.sd)
    more = Rig((*plan.rig, replace(plan.following, name="more")))
    again = predict(more, ROOM, walks(ROOM, diameter_mm=14.0), diameter_mm=14.0, least_px=2.5, centroid_sd=0.1)
    assert np.allclose(again.body.sd, after.sd, equal_nan=True)


def test_cameras_stand_where_they_may():
    walls = np.array([[-2100.0, -900.0], [4100.0, 9000.0]])
    room = Room(BOX, (1500.0, 2500.0), (1000.0, 2000.0), walls)
    rig = plan_cameras(room, Sensor(), Planning(cameras=4, subject_mm=0)).rig
    at = rig.centres
    assert ((at[:, :2] >= walls[0]) & (at[:, :2] <= walls[1])).all()
    assert ((at[:, 2] >= 1500) & (at[:, 2] <= 2500)).all()
    outside = np.maximum(np.maximum(BOX[0, :2] - at[:, :2], at[:, :2] - BOX[1, :2]), 0.0)
    assert ((np.hypot(*outside.T) > 999.9) & (np.hypot(*outside.T) < 2000.1)).all()
    assert np.allclose([camera.R[1, 2] <= 0 for camera in rig], True)  # upright


def test_cameras_that_stand_already_stay_and_count():
    stands = look_at("cam2", (4000.0, 600.0, 2000.0), (1000.0, 600.0, 900.0))
    alone = plan_cameras(FEW, Sensor(), Planning(cameras=3), given=Rig((stands,)))
    assert alone.rig[0] is stands and alone.rig.names == ("cam2", "cam1", "cam3") and alone.given == 1
    assert np.linalg.norm(alone.rig.centres[1:] - stands.centre, axis=1).min() > 400
    judged = plan_cameras(FEW, Sensor(), Planning(cameras=3), given=alone.rig)
    assert judged.rig.names == alone.rig.names and judged.following is not None


def test_limbs_hide_markers_from_cameras_on_one_side():
    """All of the empty volume is seen by four cameras to the left, and hardly a marker of the right leg."""
    left = ring(4, radius=3500.0, target=(1000.0, 600.0, 850.0), start_deg=60.0, sweep_deg=60.0, focal_px=900.0)
    found = predict(left, ROOM, walks(ROOM, diameter_mm=14.0), diameter_mm=14.0, least_px=2.5, centroid_sd=0.1)
    assert (found.volume.seen >= 2).mean() > 0.99
    views = dict(zip(found.body.names, np.split(found.body.views, 2, axis=1)[0], strict=True))
    inside = views["LKNE"] >= 0
    assert (views["LKNE"][inside] >= 2).all() and (views["RKNE"] < 2).all()
    back = dict(zip(found.body.names, np.split(found.body.views, 2, axis=1)[1], strict=True))
    assert (back["LKNE"] < 2).all() and (back["RKNE"][back["RKNE"] >= 0] >= 2).all()


def test_images_that_touch_do_not_count():
    uv = np.array([[[10.0, 10.0]], [[13.0, 10.0]], [[30.0, 10.0]], [[np.nan, np.nan]]])
    assert run_together(uv, np.full((4, 1), 4.0)).ravel().tolist() == [True, True, False, False]
    assert not run_together(uv, np.full((4, 1), 2.0)).any()


def test_a_marker_too_small_for_a_lens_is_not_measured():
    """Of 14 mm at 1300 px the image is 4 px across at 4.55 m."""
    rig = ring(4, radius=4550.0, target=(1000.0, 600.0, 900.0), height=(900.0,))
    few = {"diameter_mm": 14.0, "centroid_sd": 0.1}
    tall = predict(rig, ROOM, (), least_px=0.0, **few).volume.seen
    short = predict(rig, ROOM, (), least_px=4.0, **few).volume.seen
    assert (tall == 4).mean() > 0.9 and (short <= tall).all() and 1.5 < short.mean() < 2.5
    xyz = np.stack(np.meshgrid(*predict(rig, ROOM, (), least_px=0.0, **few).volume.axes, indexing="ij"), -1)
    near = np.linalg.norm(xyz[None] - rig.centres[:, None, None, None], axis=-1) <= 4550.0
    assert (short <= near.sum(0)).all()


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"volume_mm": (0, 0, 0, 0, 1000, 1000)}, "volume from"),
        ({"height_mm": (2000, 1000)}, "height of cameras"),
        ({"cameras": 1}, "2 to 32"),
        ({"focal_mm": 8.0}, "focal_mm together with pitch_um"),
        ({"focal_px": -5.0}, "focal length"),
        ({"marker_mm": 0.0}, "diameter_mm"),
        ({"marker_mm": 0.5}, "Use larger markers"),
        ({"walls_mm": (0, 0, 1000, 1000)}, "Let cameras be nearer"),
        ({"markers": 3000}, "at most 100 markers"),
        ({"volume_mm": (0, 0, 0, 100, 100, 5)}, "No marker of the walking subject"),
        ({"cameras": 32, "height_mm": (2000, 2000), "distance_mm": (1, 1), "volume_mm": (0, 0, 0, 50, 50, 50),
          "subject_mm": 0}, "There is place for"),
    ],
)  # fmt: skip
def test_what_cannot_be_planned_is_told(tmp_path, settings, said):
    few = {"height_mm": (2000.0, 2000.0), "distance_mm": (2000.0, 2000.0)}
    with pytest.raises(KinemarkError, match=said):
        camera_plan(tmp_path / "plan", settings=PlanSettings(**(few | settings)))
    assert not (tmp_path / "plan").exists()


def test_a_plan_is_written_as_rig_figures_and_page(tmp_path):
    settings = PlanSettings((0, 0, 0, 1500, 1000, 1500), 3, height_mm=(2000, 2000), distance_mm=(1800, 1800))
    steps = []
    found = camera_plan(tmp_path / "plan", settings=settings, progress=lambda *step: steps.append(step))
    assert len(steps) > 20 and steps[0][:2] == ("plan", 0) and steps[-1][1] < steps[-1][2], "a plan takes seconds"
    figures = json.loads((tmp_path / "plan/plan.json").read_text("utf-8"))
    rig = read_rig_toml(tmp_path / "plan/plan.toml")
    assert figures == json.loads(json.dumps(found.figures))
    assert [c["position_mm"] for c in figures["cameras"]] == [pytest.approx(c) for c in rig.centres.tolist()]
    assert np.array_equal(rig.volume, [[0, 0, 0], [1500, 1000, 1500]])
    page = (tmp_path / "plan/plan.html").read_text("utf-8")
    assert headline_of(figures["verdict"]).replace("'", "&#39;") in page and "cam3" in page
    assert (tmp_path / "plan/assets").is_dir() and len(page) < 100_000, "the drawing library lies beside the page"
    with pytest.raises(KinemarkError, match="would be overwritten"):
        camera_plan(tmp_path / "plan", settings=replace(settings, given=tmp_path / "plan/plan.toml"))
    write_rig_toml(tmp_path / "stands.toml", rig)
    more = camera_plan(tmp_path / "plan", settings=replace(settings, given=tmp_path / "stands.toml", cameras=4))
    assert [c["given"] for c in more.figures["cameras"]] == [True, True, True, False]


@pytest.mark.parametrize(("after", "said"), [(0.99, "One more camera would raise"), (0.97, "Three or more measure 97")])
def test_what_one_more_camera_brings_is_not_called_a_rise_where_it_is_none(after, said):
    found = make_finding(
        "plan_following", three_share=0.97, three_share_after=after,
        sd_median_mm=0.15, sd_median_after_mm=0.13,
    )  # fmt: skip
    assert said in with_words({"findings": [found.as_dict()]})["findings"][0]["text"]
