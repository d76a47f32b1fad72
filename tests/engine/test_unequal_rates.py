"""Cameras of other rates than the frames, in a session: films of other numbers of images, on real recordings too."""

import numpy as np
import pytest
import scipy

from kinemark.calibrate.reference_marker import reference_shift
from kinemark.data import KinemarkError
from kinemark.detect import detect
from kinemark.engine.session import Session
from kinemark.geometry import fit_dlt, from_dlt
from kinemark.io.rig_toml import write_rig_toml
from support.laboratory import ring
from support.shared import shared_data

MARKERS, STORED_HZ = 24, 100.0

SESSION = """\
name = "films"
rate_hz = 100.0
volume_mm = {volume}
{times}
[calibration]
file = "dlt.csv"
length_unit = "mm"
[[trials]]
name = "run"
detections = "run.csv"
"""


def test_films_of_other_speeds_meet_in_the_frames(tmp_path):
    """Each film's beginning and speed are found by the stored coordinates; the session then gives these again."""
    folder = shared_data("cameras/kinemat_running_3cam")
    marks = [np.loadtxt(folder / f"r1cam{c}.cal") for c in (1, 2, 3)]
    films = [np.loadtxt(folder / f"r1cam{c}.raw").reshape(-1, MARKERS + 3, 2) for c in (1, 2, 3)]
    L = np.array([fit_dlt(np.loadtxt(folder / "calframe.txt"), m[:6]) for m in marks])
    stored = scipy.io.loadmat(folder / "result.mat")["H"].reshape(-1, MARKERS + 3, 5)[:, :MARKERS, :3]
    still = [
        film - reference_shift(m[None, 6:], film[None, :, MARKERS:], tolerance=10.0)[0][:, None]
        for film, m in zip(films, marks, strict=True)
    ]
    first, slope = np.array([line_of_time(*each) for each in zip(still, [stored] * 3, from_dlt(L), strict=True)]).T
    np.savetxt(tmp_path / "dlt.csv", L.T, delimiter=",")
    rows = ["camera,frame,u_px,v_px,marker"]
    rows += [
        f"cam{c},{k},{u},{v},m{m}"
        for c, film in enumerate(still, 1)
        for k, image in enumerate(film[:, :MARKERS])
        for m, (u, v) in enumerate(image)
    ]
    (tmp_path / "run.csv").write_text("\n".join(rows))
    volume = [stored.min((0, 1)).tolist(), stored.max((0, 1)).tolist()]
    rates, delays = STORED_HZ * slope, -1000 * first / slope / STORED_HZ
    said = [", ".join(f"cam{c} = {one:.4f}" for c, one in enumerate(each, 1)) for each in (rates, delays)]
    off = {}
    for times in ("", f"[cameras]\nrates_hz = {{ {said[0]} }}\ndelays_ms = {{ {said[1]} }}"):
        (tmp_path / "session.toml").write_text(SESSION.format(volume=volume, times=times))
        trial = Session.open(tmp_path).run()["run"].trajectories
        xyz = np.array([trial[f"m{m}"].xyz for m in range(MARKERS)]).swapaxes(0, 1)
        n = min(len(xyz), len(stored)) - 5
        off[bool(times)] = np.linalg.norm(xyz[5:n] - stored[5:n], axis=-1).mean(), len(xyz)
    assert off[True][0] < 2.2 < 50 < off[False][0]  # mm; the stored ones were smoothed
    assert abs(off[True][1] - len(stored)) <= 2 and off[False][1] == max(map(len, films))


def line_of_time(film, stored, P):
    """Image of the film at stored frame 0, and images of the film to a stored frame, where they agree best."""
    fine = np.linspace(0, len(film) - 1, 20 * len(film))
    images = scipy.interpolate.CubicSpline(np.arange(len(film)), film[:, :MARKERS])(fine)
    x = np.concatenate([stored, np.ones((*stored.shape[:2], 1))], -1) @ P.T
    off = np.linalg.norm(images - (x[..., :2] / x[..., 2:])[:, None], axis=-1).mean(-1)
    return np.polyfit(np.arange(len(stored)), fine[off.argmin(1)], 1)[::-1]


class Film:
    """n dark images with one bright disc each."""

    def __init__(self, n):
        self.n_frames = n

    def v_offset(self, f):
        """No fields."""
        return 0.0

    def batches(self, size):
        """All of them, at most `size` at a time (n, H, W)."""
        y, x = np.mgrid[:40, :60]
        image = np.where((x - 30) ** 2 + (y - 20) ** 2 < 16, 200, 10).astype(np.uint8)
        for first in range(0, self.n_frames, size):
            yield np.repeat(image[None], min(size, self.n_frames - first), axis=0)


def test_films_of_other_lengths_are_detected_where_they_may_be():
    films = [Film(50), Film(60)]
    found = detect(films, cameras=("a", "b"), rate=50.0, equal_lengths=False)
    assert found.counts.sum(1).tolist() == [50, 60]
    assert (found.n_frames, found.counts[0, 50:].any()) == (60, False)
    with pytest.raises(KinemarkError, match=r"a 50, b 60.*rates_hz in \[cameras\]"):
        detect(films, cameras=("a", "b"), rate=50.0)
    lost = detect([Film(59), Film(60)], cameras=("a", "b"), rate=50.0)  # one image in sixty: it lost it, or stopped
    assert lost.counts.sum(1).tolist() == [59, 60]


def test_a_slip_of_the_decimal_point_is_refused(tmp_path):
    write_rig_toml(tmp_path / "rig.toml", ring(2))
    names = ring(2).names
    (tmp_path / "run.csv").write_text(f"camera,frame,u_px,v_px,marker\n{names[0]},0,1,1,m\n{names[1]},0,1,1,m\n")
    said = SESSION.format(volume="[[-1, -1, -1], [1, 1, 1]]", times=f"[cameras]\nrates_hz = {{ {names[1]} = 0.0001 }}")
    (tmp_path / "session.toml").write_text(said.replace('"dlt.csv"\nlength_unit = "mm"', '"rig.toml"'))
    with pytest.raises(KinemarkError, match="within 100 times"):
        Session.open(tmp_path).run()
