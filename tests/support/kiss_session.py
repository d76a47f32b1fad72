"""The gait session of KISS, section 5.2, as a session on disk: fifteen markers, six cameras, 80 fields of 50 Hz.

Its tracks are made by the paper's own methods, and are in pieces, with ghosts among them, as the paper's were.
"""

from kinemark.data import Trial
from kinemark.io.c3d import write_c3d
from kinemark.io.records import save
from kinemark.io.rig_toml import write_rig_toml
from kinemark.synth import observe, ring, walking

SETTINGS = """name = "KISS, section 5.2"
marker_set = "kiss-15"

[calibration]
file = "rig.toml"

[match]
method = "kiss_triplets"
all_duals = true

[track]
method = "kiss_tracking"

[label]
template = ["earlier.c3d"]

[[trials]]
name = "walk01"
detections = "walk01.h5"
"""


def kiss_session(folder, seed=1):
    """The session, not yet run, and its subject; an earlier trial of the same person is there with names."""
    rig = ring(6, size=(752, 291), focal_px=(770.0, 385.0))  # the lines of a field lie two pixels apart
    subject = walking(duration_s=1.6, rate=50.0)
    seen = observe(rig, subject, noise_px=0.2, false_per_frame=0.1, merge_px=3.0, least_visible=0.4, seed=seed)
    write_rig_toml(folder / "rig.toml", rig)
    save(folder / "walk01.h5", seen.detections)
    earlier = walking(duration_s=1.6, rate=50.0, seed=9, phase=0.8)
    write_c3d(folder / "earlier.c3d", Trial("earlier", earlier.trajectories))
    (folder / "session.toml").write_text(SETTINGS, "utf-8")
    return subject
