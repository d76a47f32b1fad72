"""Two cameras that film markers, one of them dim, and what is none: a session in which detection is tried."""

import numpy as np

from kinemark.io.rig_toml import write_rig_toml
from kinemark.io.video import write_video
from support.laboratory import ring

SIZE, FRAMES = (240, 180), 20
V, U = np.mgrid[: SIZE[1], : SIZE[0]]
SESSION = """# of the knee study
name = "tried" # by hand
rate_hz = 100.0
[calibration]
file = "rig.toml"
{more}
[[trials]]
name = "one"
images = "{{camera}}.mkv" # raw
{frames}
"""


def scene(f, *, dim=45.0, bar=True):
    """Three markers that move, one of them dim; a long bar, a speck, a lamp, and a spot at the edge; noise."""
    rng = np.random.default_rng(f)
    out = 12.0 + rng.normal(0, 1.0, U.shape)
    for u, v, r, light in ((60 + 2 * f, 50, 4, 200), (120, 60 + f, 4, 190), (180 - f, 120, 4, dim), (0, 90, 4, 200)):
        out += light * np.clip(r + 0.5 - np.hypot(U - u, V - v), 0, 1)
    out[20:23, 100:140] += 180 if bar else 0
    out[150, 30] = 250
    out[140:170, 190:225] += 150
    return out.clip(0, 255).astype(np.uint8)


def session_in(folder, more="", frames="", *, size=SIZE, **options):
    write_rig_toml(folder / "rig.toml", ring(2, size=size))
    for c in range(2):
        write_video(folder / f"c{c}.mkv", np.stack([scene(f + 100 * c, **options) for f in range(FRAMES)]), 100.0)
    (folder / "session.toml").write_text(SESSION.format(more=more, frames=frames), "utf-8")
    return folder
