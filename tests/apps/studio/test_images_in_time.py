"""Pictures of cameras that took their images at times of their own are those of the frame that is shown."""

import threading
from dataclasses import replace
from types import SimpleNamespace

import av
import pytest

pytest.importorskip("fastapi", reason="the studio's dependencies are absent: pip install 'kinemark[studio]'")

from kinemark.apps.studio.images import mosaic_of, mosaics_of
from kinemark.data import Rig, make_finding
from kinemark.engine.session import Session
from kinemark.io.rig_toml import write_rig_toml
from support.laboratory import ring
from support.numbered_video import HEIGHT, WIDTH, number, write_numbered

SETTINGS = """\
name = "late"
rate_hz = 50.0
[cameras]
{times}
[calibration]
file = "rig.toml"
[[trials]]
name = "one"
images = "one/{{camera}}.mkv"
"""
APART = make_finding("camera_started_apart", cameras=["c1"], images=4, delay_ms=80.0, state_ms=80.0)
DROPPED = make_finding("camera_dropped_images", cameras=["c1"], frames=[(9, 39)], dropped=2, images=2)
LATER = make_finding("camera_dropped_images", cameras=["c2"], frames=[(5, 39)], dropped=2, images=2)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder, rig = tmp_path_factory.mktemp("late"), ring(3)
    K = [[60.0, 0, WIDTH / 2], [0, 60.0, HEIGHT / 2], [0, 0, 1]]
    write_rig_toml(folder / "rig.toml", Rig(tuple(replace(one, size=[WIDTH, HEIGHT], K=K) for one in rig)))
    (folder / "one").mkdir()
    for name in rig.names:
        write_numbered(folder / "one" / f"{name}.mkv", 40)
    return folder


def document(folder, times="", findings=()):
    """The open trial, as far as its images need it."""
    (folder / "session.toml").write_text(SETTINGS.format(times=times))
    session = Session.open(folder)
    source = session.trial("one").source(session.calibrate().rig)
    inputs = SimpleNamespace(source=source, folder=folder / "results" / "one")
    track = SimpleNamespace(diagnostics=findings)
    return SimpleNamespace(inputs=inputs, records={"track": track}, kept={}, lock=threading.RLock())


def shown(document, n):
    mosaics = mosaics_of(document)
    whole = av.CodecContext.create("mjpeg", "r").decode(av.Packet(mosaics.jpeg(n)))[0].to_ndarray(format="gray")
    return [number(whole[t.y : t.y + t.height, t.x : t.x + t.width]) for t in mosaics.layout.tiles]


@pytest.mark.parametrize(
    ("times", "findings", "seen"),
    [
        ("", (), [20, 20, 20]),
        ("", (APART,), [20, 16, 20]),
        ("delays_ms = {c2 = 60.0}", (), [20, 20, 17]),
        ("delays_ms = {c2 = -29.0}", (APART,), [20, 16, 21]),
        ("", (DROPPED,), [20, 18, 20]),
        ("", (APART, LATER), [20, 16, 18]),
        ("rates_hz = {c0 = 25.0}", (), [10, 20, 20]),
        ("rates_hz = {c1 = 25.0}", (APART,), [20, 8, 20]),
    ],
)
def test_every_camera_is_shown_at_the_time_of_the_frame_by_what_is_said_or_was_found(folder, times, findings, seen):
    of = document(folder, times, findings)
    assert shown(of, 20) == seen
    mosaics_of(of).close()


def test_pictures_that_were_kept_of_other_times_are_not_shown_and_not_asked_for(folder):
    several = [document(folder), document(folder, "delays_ms = {c2 = 60.0}"), document(folder, findings=(APART,))]
    assert [shown(of, 30) for of in several] == [[30, 30, 30], [30, 30, 27], [30, 26, 30]]
    assert len({mosaic_of(of).images for of in several}) == 3, "by which browsers keep them"
    for of in several:
        mosaics_of(of).close()
