"""Small sessions on disk."""

from kinemark.io.detections_csv import write_detections_csv
from kinemark.io.records import save
from kinemark.io.rig_toml import write_rig_toml
from support.laboratory import observe, ring
from support.motions import swarm

POINTS = swarm(n=5, frames=20)


def folder_of(path, n_cameras=3, more=""):
    """A session of one trial, with more in its file."""
    rig = ring(n_cameras)
    detections, _ = observe(rig, POINTS, noise=0.1)
    save(path / "one.h5", detections)
    write_rig_toml(path / "rig.toml", rig)
    head = 'name = "choice"\n[calibration]\nfile = "rig.toml"\n[[trials]]\nname = "one"\ndetections = "one.h5"\n'
    (path / "session.toml").write_text(head + more)
    return path, rig, detections


OF_FILE = """\
name = "test"
rate_hz = 100.0
[calibration]
file = "rig.toml"
[[trials]]
name = "one"
detections = "one.csv"
"""


def session_of_points(path, points):
    """A session of a trial's detections as CSV of four cameras that see these points, and a ready-made calibration."""
    rig = ring(4)
    write_rig_toml(path / "rig.toml", rig)
    write_detections_csv(path / "one.csv", observe(rig, points, noise=0.1)[0])
    (path / "session.toml").write_text(OF_FILE)
    return path
