"""Small sessions on disk."""

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
