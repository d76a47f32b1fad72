"""A session folder as a real laboratory would leave it, with the truth beside it.

    folder/session.toml            what everything is
    folder/rods.toml               the control frame as a surveyor measured it (or points.csv for other targets)
    folder/calib/{camera}.png      one image of it a camera
    folder/grid/{camera}/1.png …   a plane grid of dots near each camera, which shows its lens
    folder/wand/{camera}.mkv       or, calibrated with a wand: the wand waved about, and
    folder/lframe/{camera}.png     an L-frame on the floor, whose corner is the world's origin
    folder/walk01/{camera}.mkv     the trial, a video a camera
    folder/truth.npz               names, xyz, visibility and the rig that really took the images

Nothing else here says where a marker truly is: only the evaluation of a reconstruction reads `truth.npz`.
Images are written by functions that the caller hands in, so that this package depends on no file format.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import scipy
import tomlkit
from numpy.typing import NDArray

from ..data import KinemarkError, Rig, Rods
from ..data.array_types import Floats
from .observe import truth
from .optics import Optics
from .render import film, interlace, render
from .subjects import Subject
from .targets import control_frame, rods_subject, wand

WAND_MM = 500.0  # mm; a usual wand's length; chosen
WAND_SECONDS, WAND_RATE = 120.0, 1.25
"""s and Hz: slowly enough that neighbouring poses differ; chosen."""
ARMS_MM = (800.0, 600.0)  # mm; an L-frame's arms; chosen
BALL_MM = 25.0  # mm; diameter of the markers of wand and frame; chosen
GRID, GRID_MM, DOT_MM = (20, 15), 50.0, 12.0
"""Columns and rows at most, mm between dots, their diameter; chosen."""
GRID_SHARE, GRID_PX, GRID_TURN_DEG = 0.85, 24.0, 20.0
"""Of the image that the grid takes up, px that its dots are apart at least, and how far it is turned; chosen."""

Image = NDArray[np.uint8]
WriteFrames = Callable[[Path, Iterable[Image], float], None]
"""Writes images (H, W) to a video file at a rate in Hz."""
WriteImage = Callable[[Path, Image], None]
"""Writes one image (H, W) to a file."""


def write_session(
    folder: Path | str,
    subject: Subject,
    rig: Rig,
    *,
    write_frames: WriteFrames,
    write_image: WriteImage,
    name: str = "virtual laboratory",
    trial: str = "walk01",
    target: Rods | Subject | None = None,
    by_wand: bool = False,
    grid: bool = False,
    optics: Optics = Optics(),  # noqa: B008  frozen
    strobes: bool = False,
    interlaced: bool = False,
    suffix: str = ".mkv",
    seed: int = 0,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """A new session folder: a calibration image and a trial of every camera, `session.toml` and `truth.npz`.

    Args:
        folder: to make; it may exist if it is empty.
        subject: of the trial.
        rig: the cameras; its `volume` goes into the session.
        write_frames: writes a video; called as write_frames(path, images, rate).
        write_image: writes one image; called as write_image(path, image).
        name: of the session.
        trial: name of the trial and its folder.
        target: to calibrate with, rods or control points; by default the control frame of the rig's volume.
        by_wand: calibrate with a wand and an L-frame instead.
        grid: show a plane grid to each camera as well, so that its lens is measured: eight control points, or rods
            alone, hardly tell of it.
        optics: how bright, sharp and noisy the images are.
        strobes: whether the other cameras' lights are seen.
        interlaced: whether two frames of the subject are woven into one image, as in 50 Hz video.
        suffix: of the video files.
        seed: of all noise.
        progress: called with videos done and videos in all.

    Returns:
        The path of `session.toml`.

    Raises:
        KinemarkError: the folder holds something already, or cannot be made.
        ValueError: the trial's name cannot be a folder's.
    """
    folder = Path(folder)
    if not trial or Path(trial).name != trial or trial in (".", "..", "calib", "results"):
        raise ValueError(f"trial is {trial!r}, wanted a name that can be a folder of its own")
    _make_empty(folder, (trial, "wand", "lframe") if by_wand else (trial, "calib"))
    target = control_frame(rig.volume) if target is None else target
    if by_wand:
        write_wand(
            folder,
            rig,
            write_frames=write_frames,
            write_image=write_image,
            optics=optics,
            strobes=strobes,
            suffix=suffix,
            seed=seed,
        )
    else:
        write_calibration(folder, rig, target, write_image=write_image, optics=optics, strobes=strobes, seed=seed)
    for c, camera in enumerate(rig):
        images = film(camera, subject, optics=optics, strobes=_lights(rig, c, strobes), seed=seed + 1 + c)
        video = folder / trial / f"{camera.name}{suffix}"
        write_frames(video, interlace(images) if interlaced else images, subject.rate / (2 if interlaced else 1))
        if progress is not None:
            progress(c + 1, len(rig))
    _write_truth(folder / "truth.npz", rig, subject)
    way = _wand_way(suffix) if by_wand else _target_way(target)
    if grid:
        way |= write_grids(folder, rig, write_image=write_image, optics=optics, seed=seed)
    trials = {trial: f"{trial}/{{camera}}{suffix}"}
    _write_text(folder / "session.toml", _session_toml(subject, rig, name, trials, way, interlaced))
    return folder / "session.toml"


def write_calibration(
    folder: Path,
    rig: Rig,
    target: Rods | Subject,
    *,
    write_image: WriteImage,
    optics: Optics = Optics(),  # noqa: B008  frozen
    strobes: bool = False,
    seed: int = 0,
) -> None:
    """`rods.toml` or `points.csv` and `calib/{camera}.png` in an existing folder."""
    if isinstance(target, Rods):
        _write_text(folder / "rods.toml", rods_toml(target))
    else:
        _write_text(folder / "points.csv", "\n".join(points_csv(target, rig)) + "\n")
    balls = rods_subject(target) if isinstance(target, Rods) else target
    rng = np.random.default_rng(seed)
    for c, camera in enumerate(rig):
        lights = _lights(rig, c, strobes)
        image = render(camera, balls.xyz[:, 0], balls.radius_mm, optics=optics, strobes=lights, rng=rng)
        write_image(folder / "calib" / f"{camera.name}.png", image)


def write_wand(
    folder: Path,
    rig: Rig,
    *,
    write_frames: WriteFrames,
    write_image: WriteImage,
    optics: Optics = Optics(),  # noqa: B008  frozen
    strobes: bool = False,
    suffix: str = ".mkv",
    seed: int = 0,
) -> None:
    """`wand/{camera}.mkv` and `lframe/{camera}.png` in an existing folder."""
    waved = wand(
        (0.0, WAND_MM), duration_s=WAND_SECONDS, rate=WAND_RATE, seed=seed, volume=rig.volume, radius_mm=BALL_MM / 2
    )
    up = BALL_MM / 2
    balls = np.array([[0, 0, up], [ARMS_MM[0], 0, up], [0, ARMS_MM[1], up]])
    rng = np.random.default_rng(seed)
    for c, camera in enumerate(rig):
        lights = _lights(rig, c, strobes)
        images = film(camera, waved, optics=optics, strobes=lights, seed=seed + 101 + c)
        write_frames(folder / "wand" / f"{camera.name}{suffix}", images, WAND_RATE)
        image = render(camera, balls, np.full(3, BALL_MM / 2), optics=optics, strobes=lights, rng=rng)
        write_image(folder / "lframe" / f"{camera.name}.png", image)


def write_grids(
    folder: Path,
    rig: Rig,
    *,
    write_image: WriteImage,
    optics: Optics = Optics(),  # noqa: B008  frozen
    seed: int = 0,
) -> dict[str, Any]:
    """`grid/{camera}/1.png` … in an existing folder; returns what `[calibration]` says of it.

    All cameras have the same grid, of as many dots as the smallest image can show apart. It hangs before each camera,
    so near that it takes up most of the image: facing it, and turned by `GRID_TURN_DEG` about two axes, as one view
    does not determine the centre of the lens.
    """
    room = GRID_SHARE * np.array([camera.size for camera in rig]).min(0)
    columns, rows = (int(n) for n in np.clip(room // GRID_PX, 5, GRID))
    row, column = np.mgrid[:rows, :columns].reshape(2, -1)
    wide = GRID_MM * np.array([columns - 1, rows - 1])
    flat = GRID_MM * np.stack([column, row, 0 * row], -1) - np.append(wide / 2, 0)
    rng = np.random.default_rng(seed)
    for camera in rig:
        (folder / "grid" / camera.name).mkdir(parents=True)
        away = float((wide * camera.K[[0, 1], [0, 1]] / (GRID_SHARE * np.array(camera.size))).max())
        for n, turn in enumerate(((0, 0, 0), (GRID_TURN_DEG, 0, 0), (0, GRID_TURN_DEG, 0)), 1):
            here = scipy.spatial.transform.Rotation.from_euler("xyz", turn, degrees=True).apply(flat) + np.array(
                [0, 0, away]
            )
            xyz = camera.centre + here @ camera.R
            image = render(camera, xyz, np.full(len(xyz), DOT_MM / 2), optics=optics, rng=rng)
            write_image(folder / "grid" / camera.name / f"{n}.png", image)
    return {"linearisation": {"grid": [columns, rows], "pitch_mm": GRID_MM, "images": "grid/{camera}/*.png"}}


def rods_toml(rods: Rods) -> str:
    """Text of `rods.toml`: units, marker_diameter and one [[rod]] a rod, a marker a line."""
    document = tomlkit.document()
    document.update({"units": "mm", "marker_diameter": float(rods.marker_diameter)})
    document.add(tomlkit.nl())
    document["rod"] = tables = tomlkit.aot()
    for name, xyz in zip(rods.names, rods.xyz.tolist(), strict=True):
        markers = tomlkit.array().multiline(True)
        markers.extend(xyz)
        tables.append(tomlkit.item({"name": name, "markers": markers}))
    return tomlkit.dumps(document)


def points_csv(target: Subject, rig: Rig) -> Iterator[str]:
    """Lines of `points.csv`: name and place of every control point, and the pixel where an operator points at it.

    Pointing is to the nearest pixel, and the cells of a camera that does not see the point are empty.
    """
    yield ",".join(["name", "x_mm", "y_mm", "z_mm", *(f"{c}_{axis}_px" for c in rig.names for axis in "uv")])
    sight = truth(rig, target)
    for m, name in enumerate(target.names):
        seen = zip(sight.uv[:, m, 0], sight.visible[:, m, 0], strict=True)
        pointed = [f"{p:.0f}" if visible > 0.5 else "" for uv, visible in seen for p in uv]
        yield ",".join([name, *(repr(x) for x in target.xyz[m, 0].tolist()), *pointed])


def _session_toml(
    subject: Subject, rig: Rig, name: str, trials: Mapping[str, str], way: Mapping[str, Any], interlaced: bool
) -> str:
    """Text of `session.toml`, with the images of each trial and `way` as what `[calibration]` says."""
    document = tomlkit.document()
    document.update({"name": name, "rate_hz": float(subject.rate)})
    if np.isfinite(rig.volume).all():
        document["volume_mm"] = rig.volume.tolist()
    document.add(tomlkit.nl())
    document["cameras"] = {"names": list(rig.names), "interlaced": interlaced}
    document.add(tomlkit.nl())
    document["calibration"] = calibration = tomlkit.table()
    for key, said in way.items():
        calibration[key] = tomlkit.inline_table()
        calibration[key].update(said)
    document.add(tomlkit.nl())
    document["trials"] = tables = tomlkit.aot()
    for trial, images in trials.items():
        tables.append(tomlkit.item({"name": trial, "images": images}))
    return tomlkit.dumps(document)


def _target_way(target: Rods | Subject) -> dict[str, Any]:
    """What `[calibration]` says of rods, whose file says how large the markers are, or of control points."""
    if isinstance(target, Rods):
        return {"control_frame": {"rods": "rods.toml", "images": "calib/{camera}.png"}}
    across = 2 * float(np.mean(target.radius_mm))
    return {"control_points": {"points": "points.csv", "images": "calib/{camera}.png", "marker_diameter_mm": across}}


def _wand_way(suffix: str) -> dict[str, Any]:
    """What `[calibration]` says of a wand and an L-frame."""
    wand_images, arms = f"wand/{{camera}}{suffix}", list(ARMS_MM)
    return {
        "wand": {"lengths_mm": [WAND_MM], "images": wand_images, "marker_diameter_mm": BALL_MM},
        "l_frame": {"arms_mm": arms, "height_mm": BALL_MM / 2, "images": "lframe/{camera}.png"},
    }


def _lights(rig: Rig, c: int, strobes: bool) -> Floats | None:
    """(C − 1, 3) mm the other cameras' lights."""
    return np.delete(rig.centres, c, axis=0) if strobes else None


def _write_truth(path: Path, rig: Rig, subject: Subject) -> None:
    """The markers and their visibility, and the rig as arrays, in the layout of the `Rig` and `Sight` records."""
    sight = truth(rig, subject)
    columns = {
        "names": np.array(subject.names),
        "rate": np.array(subject.rate),
        "xyz": subject.xyz,
        "radius_mm": subject.radius_mm,
        "links": subject.links,
        "uv": sight.uv,
        "visible": sight.visible,
        "cameras": np.array(rig.names),
        "size": np.array([camera.size for camera in rig]),
        "K": np.array([camera.K for camera in rig]),
        "distortion": np.array([camera.distortion for camera in rig]),
        "R": np.array([camera.R for camera in rig]),
        "t": np.array([camera.t for camera in rig]),
    }
    if subject.angles is not None:
        columns |= {"joints": np.array(subject.angles.joints), "angles_deg": subject.angles.deg}
    with _beside(path).open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **columns)
    _beside(path).replace(path)


def _make_empty(folder: Path, parts: tuple[str, ...]) -> None:
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise KinemarkError(f"{folder} exists already and nothing in it is overwritten. Name a new folder.")
    try:
        for part in parts:
            (folder / part).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise KinemarkError(f"{folder} cannot be made: {error}. Choose a place that you may write to.") from error


def _write_text(path: Path, text: str) -> None:
    """All or nothing."""
    _beside(path).write_text(text, encoding="utf-8")
    _beside(path).replace(path)


def _beside(path: Path) -> Path:
    return path.with_name(f".{path.name}.part")
