"""A scene of the virtual laboratory as a session on disk."""

from __future__ import annotations

import pathlib
import shutil
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from ..data import KinemarkError, MarkerTrajectory, Rig, Trajectories, Trial
from ..io.c3d import read_c3d, write_c3d
from ..io.images import write_png
from ..io.video import write_video
from ..synth import (
    Optics,
    Subject,
    arm,
    calibration_box,
    circle_over_cylinder,
    elbow_flexion,
    from_trajectories,
    ring,
    tilted_rectangle,
    walking,
    write_session,
)
from .progress import Progress, silent

Motion = Literal["walk", "feeding", "drinking", "circle", "rectangle", "flexion"]


@dataclass(frozen=True, slots=True)
class Scene:
    """What is simulated.

    Attributes:
        motion: a walk with 15 markers, an arm with 7 that feeds or drinks, or one of Swamidas' three motions.
        c3d: a C3D file whose markers move instead.
        cameras: how many, in a ring.
        seconds: how long; of a C3D file, at most.
        rate_hz: frames (fields, if interlaced) a second; a C3D file has its own.
        focal_px: focal length.
        size_px: width and height of the images.
        barrel: lens distortion k1; negative bends outwards.
        noise: standard deviation of grey levels.
        interlaced: whether two fields are woven into one image.
        strobes: whether opposite cameras' lights are seen.
        calibration: what the cameras are calibrated with: a control frame (the eight balls of a box for other motions
            than the walk, and a plane grid for the lenses, which eight balls do not show), or a wand and an L-frame,
            for the walk.
        seed: of all that is random.
    """

    motion: Motion = "walk"
    c3d: pathlib.Path | None = None
    cameras: int = 6
    seconds: float = 2.0
    rate_hz: float = 50.0
    focal_px: float = 770.0
    size_px: tuple[int, int] = (752, 582)
    barrel: float = -0.1
    noise: float = 2.0
    interlaced: bool = False
    strobes: bool = False
    calibration: Literal["control_frame", "wand"] = "control_frame"
    seed: int = 1

    def check(self) -> None:
        """Refuse what cannot be simulated.

        Raises:
            KinemarkError: a number is not positive, or a single camera is asked for.
        """
        wanted = {"seconds": self.seconds, "rate_hz": self.rate_hz, "focal_px": self.focal_px}
        if wrong := [f"{name} is {value}" for name, value in wanted.items() if not value > 0]:
            raise KinemarkError(f"{', '.join(wrong)}, wanted more than 0.")
        if min(self.size_px) < 16:
            raise KinemarkError(f"size_px is {self.size_px}, wanted at least 16 each.")
        if not 0 <= self.noise < np.inf:
            raise KinemarkError(f"noise is {self.noise}, wanted 0 or more grey levels.")
        if self.calibration == "wand" and (self.motion != "walk" or self.c3d is not None or self.interlaced):
            raise KinemarkError("calibration is 'wand', which goes with the walk and whole frames. Leave one out.")
        if self.cameras < 2:
            raise KinemarkError(f"cameras is {self.cameras}, and a point in space needs two.")

    def figures(self) -> dict[str, Any]:
        """What is simulated, for a machine."""
        return {**asdict(self), "c3d": None if self.c3d is None else str(self.c3d)}

    def subject(self) -> Subject:
        """The markers and limbs that move.

        Raises:
            KinemarkError: the C3D file has no markers.
        """
        if self.c3d is not None:
            trajectories = read_c3d(self.c3d).trajectories
            if not len(trajectories):
                raise KinemarkError(f"{self.c3d} has no markers. Name a file that has.")
            return from_trajectories(_first_seconds(trajectories, self.seconds))
        timing: dict[str, Any] = {"duration_s": self.seconds, "rate": self.rate_hz}
        makers: dict[Motion, Callable[[], Subject]] = {
            "walk": lambda: walking(**timing, seed=self.seed, speed_mm_s=WALKING_SPEED, wobble_mm=1.0),
            "feeding": lambda: arm("feeding", **timing),
            "drinking": lambda: arm("drinking", **timing),
            "circle": lambda: circle_over_cylinder(**timing),
            "rectangle": lambda: tilted_rectangle(**timing),
            "flexion": lambda: elbow_flexion(**timing),
        }
        return makers[self.motion]()

    def rig(self, subject: Subject) -> Rig:
        """Cameras all round: about the walkway of 2.4 × 1.4 × 2 m, or as near as another subject needs."""
        options: dict[str, Any] = {
            "focal_px": self.focal_px,
            "size": self.size_px,
            "distortion": (self.barrel, 0.0, 0.0, 0.0, 0.0),
        }
        if self.motion == "walk" and self.c3d is None:
            return ring(self.cameras, **options)
        low, high = np.nanmin(subject.xyz, axis=(0, 1)) - 150, np.nanmax(subject.xyz, axis=(0, 1)) + 150
        centre, reach = (low + high) / 2, float(np.linalg.norm(high - low))
        away = max(1.5 * reach, 1200.0)
        heights = (centre[2] + 0.2 * away, centre[2] + 0.5 * away)
        return ring(self.cameras, radius=away, height=heights, target=centre, volume=[low, high], **options)


def _first_seconds(trajectories: Trajectories, seconds: float) -> Trajectories:
    """The beginning of a recording."""
    stop = max(round(seconds * trajectories.rate), 1)
    paths = tuple(MarkerTrajectory.measured(path.name, path.xyz[:stop]) for path in trajectories)
    return Trajectories(paths, trajectories.rate)


def _earlier_trial(scene: Scene) -> Subject | None:
    """Another motion of the same subject, as it was recorded and named on another day; None where nobody is simulated
    who has several markers."""
    timing: dict[str, Any] = {"duration_s": 2.0, "rate": scene.rate_hz}
    if scene.c3d is not None or scene.motion not in NAMING:
        return None
    if scene.motion == "walk":
        return walking(**timing, seed=scene.seed + 1000, speed_mm_s=1100.0, wobble_mm=1.0, phase=0.3)
    return arm("drinking" if scene.motion == "feeding" else "feeding", **timing)


def _write_naming(folder: pathlib.Path, scene: Scene) -> None:
    """An earlier trial of the subject, named, and what `session.toml` says so that markers are named by it."""
    subject = _earlier_trial(scene)
    if subject is None:
        return
    write_c3d(folder / EARLIER, Trial(EARLIER.removesuffix(".c3d"), subject.trajectories))
    file = folder / "session.toml"
    file.write_text(NAMING[scene.motion] + file.read_text("utf-8") + STAGES[scene.motion], "utf-8")


EARLIER = "earlier.c3d"
"""Of the earlier trial."""
NAMING = {"walk": 'marker_set = "kiss-15"\n'} | dict.fromkeys(("feeding", "drinking"), 'marker_set = "um2as-7"\n')
"""What a session's file says of the markers, by motion."""
LABELLED = f"""
[label]
template = ["{EARLIER}"]

[fill]
"""
STAGES = {"walk": LABELLED} | dict.fromkeys(("feeding", "drinking"), LABELLED + '\n[angles]\nmodel = "um2as"\n')
"""What it says of naming, filling and joint angles."""
WALKING_SPEED = 850.0
"""mm/s; slow enough for two seconds, with the feet before and behind, to stay within the 2.4 m of the volume.
Chosen."""


def simulate(folder: pathlib.Path, *, scene: Scene | None = None, progress: Progress = silent) -> pathlib.Path:
    """A new session folder with rendered images, something to calibrate with, and the exact truth.

    Args:
        folder: to make; it may exist if it is empty.
        scene: what is simulated.
        progress: called with each video.

    Returns:
        The path of its `session.toml`.

    Raises:
        KinemarkError: the folder holds something already.
    """
    scene = scene or Scene()
    scene.check()
    subject = scene.subject()
    rig = scene.rig(subject)
    box = scene.motion != "walk" or scene.c3d is not None
    side = (rig.volume[1] - rig.volume[0]).max()
    corner = rig.volume.mean(0) - side / 2
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise KinemarkError(f"{folder} exists already and nothing in it is overwritten. Name a new folder.")
    part = folder.absolute().with_name(f".{folder.absolute().name}.part")
    shutil.rmtree(part, ignore_errors=True)  # of a simulation that was cut off
    try:
        write_session(
            part,
            subject,
            rig,
            write_frames=write_video,
            write_image=write_png,
            name=f"simulated {scene.c3d.stem if scene.c3d else scene.motion}",
            trial="walk01" if not box else "trial01",
            target=calibration_box(side, corner=corner) if box else None,
            by_wand=scene.calibration == "wand",
            grid=box and scene.barrel != 0,
            optics=Optics(read_noise=scene.noise),
            strobes=scene.strobes,
            interlaced=scene.interlaced,
            seed=scene.seed,
            progress=lambda done, total: progress("simulate", done, total),
        )
        _write_naming(part, scene)
        if folder.exists():
            folder.rmdir()
        part.rename(folder)
    finally:
        shutil.rmtree(part, ignore_errors=True)
    return folder / "session.toml"
