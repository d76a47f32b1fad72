"""Long recordings are detected by processes of their own: nothing but the time differs."""

import os
import signal
from dataclasses import dataclass, fields

import numpy as np
import pytest

from kinemark.data import KinemarkError
from kinemark.data.masks import Masks
from kinemark.detect import Centroids, KissScanning, camera_process, detect, detect_recording
from kinemark.detect.camera_process import _CameraProcess
from kinemark.io.images import open_images
from kinemark.io.video import write_video

NAMES = ("left", "mid", "right")


@pytest.fixture
def sources(tmp_path):
    """Videos of three cameras, 40 frames, a few bright discs that move and meet."""
    made = []
    for c, name in enumerate(NAMES):
        v, u = np.mgrid[:90, :120]
        frames = np.full((40, 90, 120), 20, np.uint8)
        for f, image in enumerate(frames):
            for x, y in ((20 + f, 30 + c), (70 - f, 33), (90, 70)):
                np.maximum(image, (20 + 200 * np.clip(5 - np.hypot(u - x, v - y), 0, 1)).astype(np.uint8), out=image)
        write_video(tmp_path / f"{name}.mkv", frames, rate=50.0)
        made.append(open_images(tmp_path / f"{name}.mkv"))
    return made


@pytest.fixture
def started(monkeypatch):
    """Processes whatever the length; those that were started."""
    started = []
    begin = _CameraProcess.__init__
    monkeypatch.setattr(detect_recording, "PROCESSES_FROM", 0)
    monkeypatch.setattr(_CameraProcess, "__init__", lambda self: (begin(self), started.append(self._process))[0])
    yield started
    assert all(process.poll() is not None for process in started), "a process is left"


def same(one, other):
    """The same columns, to the bit."""
    for field in fields(one):
        np.testing.assert_array_equal(getattr(one, field.name), getattr(other, field.name))


@pytest.mark.parametrize("method", [None, Centroids(threshold=60), KissScanning()], ids=["learned", "stated", "kiss"])
def test_they_find_what_threads_find(sources, started, monkeypatch, method):
    masks = Masks(("left",), np.array([[120, 90]]), ((np.array([[80, 60], [100, 60], [100, 80], [80, 80.0]]),),))
    done = []
    told = {"cameras": NAMES, "rate": 50.0, "method": method, "masks": masks, "of_cameras": {"mid": Centroids()}}
    found = detect(sources, **told, threads=2, progress=done.append)
    assert len(started) == 2 and done == sorted(done) and done[-1] == 120
    monkeypatch.setattr(detect_recording, "PROCESSES_FROM", 10**9)
    same(found, detect(sources, **told, threads=2))
    assert len(started) == 2


def test_what_keeps_its_images_or_is_short_or_alone_stays_in_this_process(sources, started, monkeypatch):
    @dataclass
    class InMemory:
        images: np.ndarray

        @property
        def n_frames(self):
            return len(self.images)

        def batches(self, n):
            return (self.images[k : k + n] for k in range(0, len(self.images), n))

        def v_offset(self, f):
            return 0.0

    held = [InMemory(np.concatenate(list(source.batches(16)))) for source in sources]
    found = detect(held, cameras=NAMES, rate=50.0, threads=2)
    same(found, detect(sources, cameras=NAMES, rate=50.0, threads=1))
    monkeypatch.setattr(detect_recording, "PROCESSES_FROM", 121)
    same(found, detect(sources, cameras=NAMES, rate=50.0, threads=2))
    assert not started


def test_errors_are_those_of_the_camera(sources, started):
    sources[1].paths[0].write_bytes(sources[1].paths[0].read_bytes()[:3000])
    with pytest.raises(KinemarkError) as here:
        detect(sources, cameras=NAMES, rate=50.0, threads=1)
    with pytest.raises(KinemarkError) as there:
        detect(sources, cameras=NAMES, rate=50.0, threads=2)
    assert str(there.value) == str(here.value) and "mid" in str(here.value)


def test_an_error_of_ours_says_where_it_was(sources, started):
    with pytest.raises(ValueError) as told:
        detect(sources, cameras=NAMES, rate=50.0, method="no method", threads=2)
    assert "detect_camera" in "".join(told.value.__notes__)


def test_who_stops_it_waits_for_no_camera(sources, started):
    def stop(done):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        detect(sources, cameras=NAMES, rate=50.0, threads=2, progress=stop)
    assert started


@pytest.mark.skipif(os.name == "nt", reason="signals are those of POSIX")
def test_a_process_that_dies_is_told_with_its_camera(sources, started):
    def kill(done):
        for process in started:
            os.kill(process.pid, signal.SIGKILL)

    with pytest.raises(KinemarkError, match=r"Camera \w+: the process .* ended .*--threads 1"):
        detect(sources, cameras=NAMES, rate=50.0, threads=2, progress=kill)


def test_a_process_that_does_not_end_is_stopped(sources, started, monkeypatch):
    monkeypatch.setattr(camera_process, "PATIENCE_S", 0.0)
    assert detect(sources, cameras=NAMES, rate=50.0, threads=2).counts.shape == (3, 40)
