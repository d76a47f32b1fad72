"""UM²AS's files of a session, made from what its screens keep: by the functions of the command line, bit for bit.

They lie in `results/um2as` of the session, where the commands `kinemark um2as …` read them too:

    box.msr box.cp1 … box.rf1 …       from the control balls that were pointed at
    feeding.da1 …                     from the answers of whoever digitised the trial `feeding`
    feeding.tdc feeding-13.tdc …      places by all cameras, or by cameras 1 and 3
    feeding.shd feeding.elb …         angles

`made.json` beside the files keeps, of each that a screen wrote, a key of its content and keys of all that the session
then said and it depends on. A file that is not as a screen wrote it, as those of the command line, tells nothing. By
it the menu knows which of them are out of date.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np

from ...data import KinemarkError, Rig
from ...data.array_types import Floats
from ...geometry import to_dlt
from ...io.files import read_json, write_json
from ...io.um2as import ENDINGS, read_da, read_msr, write_cp, write_da, write_msr, write_rf
from ..calibration.from_known_points import is_cp
from ..digitising.control_balls import ControlBalls, snapped
from ..digitising.open_digitising import OpenDigitising
from ..keys import digest, file_key
from ..session import Session
from .flow import angles_files, calibrate_file, coordinates_files

MADE = "made.json"
ASPECT, CALIBRATION, MARK, THRESHOLD, START = (
    "The aspect ratio", "The calibration", "The reference marker", "The threshold", "The start-up information",
)  # fmt: skip
OF_BALLS = (ASPECT, CALIBRATION, THRESHOLD)
"""What `.cp` files depend on besides the files that they are made of."""
OF_MARK = (ASPECT, MARK)
"""The same of `.rf` files."""
OF_MARKERS = (ASPECT, CALIBRATION, MARK, THRESHOLD, START)
"""The same of `.da` files: other cameras propose by the calibration."""


def basis(session: Session, trial: str, of: Sequence[str]) -> dict[str, str]:
    """Keys of what a session says of these things, by their words."""
    s, entry = session.settings, session.trial(trial).entry
    c, root = s.calibration, session.root
    named = (c.file, c.control_points and c.control_points.points, c.control_frame and c.control_frame.rods)
    files = file_key(*(root / path for path in named if path))
    said: dict[str, Any] = {
        ASPECT: s.cameras.aspect_ratio or 1.0,
        CALIBRATION: (c.model_copy(update={"reference_marker": None}), files),
        MARK: c.reference_marker,
        THRESHOLD: (s.detect, s.detect_cameras),
        START: (s.digitise, entry.every, entry.frames),
    }
    return {words: digest(said[words]) for words in of}


def remember(folder: Path, files: Sequence[Path], made_of: Mapping[str, str]) -> None:
    """Keep what files in this folder were made of, which a screen has just written."""
    known = read_json(folder / MADE) | {path.name: {"file": file_key(path), "of": dict(made_of)} for path in files}
    write_json(folder / MADE, known)


def changed(folder: Path, files: Sequence[Path], now: Mapping[str, str]) -> str:
    """What of it is otherwise now, in words; empty where nothing is, or nothing is known."""
    known = read_json(folder / MADE)
    for path in files:
        one = known.get(path.name)
        if one is None or one["file"] != file_key(path):
            continue
        if other := [words for words, key in now.items() if one["of"].get(words) != key]:
            return f"{other[0]} was changed since: do it again."
    return ""


FOLDER = "um2as"
"""Of the files, below the session's results."""
BOX = "box"
"""What the calibration's files are called where no file of measured places gives a name."""
SAME_MM = 1e-6
"""Places of a file and of a session that differ by no more are the same; below what files can say, by definition."""


@dataclass(frozen=True, slots=True)
class Um2asFiles:
    """The files of UM²AS of a session, and of one of its trials.

    Attributes:
        session: the session. trial: name of the trial.
    """

    session: Session
    trial: str

    @property
    def folder(self) -> Path:
        """Where they are."""
        return self.session.results / FOLDER

    @property
    def cameras(self) -> tuple[str, ...]:
        """In the order of the files' numbers; raises a KinemarkError where they are known by a calibration alone that
        cannot be read."""
        return self.session.camera_names

    @property
    def measured(self) -> Path | None:
        """The file of measured places that the session's control balls are from; None where there is no such."""
        try:
            xyz = self.balls.points.xyz
        except KinemarkError:
            return None
        return next((path for path in sorted(self.session.root.glob("*.msr")) if _holds(path, xyz)), None)

    @property
    def balls(self) -> ControlBalls:
        """The control balls; raises a KinemarkError where the session is calibrated another way."""
        return ControlBalls.of(self.session.root, self.session.settings)

    @property
    def box(self) -> str:
        """What the calibration's files are called."""
        file = self.session.settings.calibration.file
        if file is not None and is_cp(file):
            return file.stem
        return self.measured.stem if self.measured else BOX

    @property
    def square(self) -> Floats:
        """(2,) what u and v are multiplied by in the files, so that pixels are square (UM²AS eq. 4.2)."""
        return np.array([1.0, self.session.settings.cameras.aspect_ratio or 1.0])

    def numbered(self, stem: str, letters: str, cameras: Sequence[str] = ()) -> list[Path]:
        """The files of some cameras, of all where none are named: `box.cp1`, `box.cp2`, …"""
        chosen = cameras or self.cameras
        return [self.folder / f"{stem}.{letters}{self.cameras.index(name) + 1}" for name in chosen]

    def cps(self, cameras: Sequence[str] = ()) -> list[Path]:
        """Files of calibration parameters."""
        file = self.session.settings.calibration.file
        if file is None or not is_cp(file):
            return self.numbered(self.box, "cp", cameras)
        given = self.session.root / file
        return [given.with_suffix(path.suffix) for path in self.numbered(given.stem, "cp", cameras)]

    def rfs(self) -> list[Path]:
        """Files of the reference marker."""
        return self.numbered(self.box, "rf")

    def das(self, cameras: Sequence[str] = ()) -> list[Path]:
        """Files of digitised markers."""
        return self.numbered(self.trial, "da", cameras)

    def tdc(self, cameras: Sequence[str] = ()) -> Path:
        """The file of places; the numbers of the cameras are in its name where they are not all."""
        numbers = "".join(str(self.cameras.index(name) + 1) for name in cameras)
        some = f"-{numbers}" if cameras and len(cameras) < len(self.cameras) else ""
        return self.folder / f"{self.trial}{some}.tdc"

    def angle_files(self, tdc: Path) -> list[Path]:
        """Those of shoulder, elbow and wrist, beside the places."""
        return [tdc.with_suffix(ending) for ending in ENDINGS.values()]

    def parameters_changed(self) -> str:
        """Why files of the calibration have to be made again, in words; empty where they need not."""
        return changed(self.folder, self.cps(), basis(self.session, self.trial, OF_BALLS)) or changed(
            self.folder, self.rfs(), basis(self.session, self.trial, OF_MARK)
        )

    def markers_changed(self) -> str:
        """The same of the files of digitised markers."""
        return changed(self.folder, self.das(), basis(self.session, self.trial, OF_MARKERS))

    def process_parameters(self, made: date) -> list[Path]:
        """Process L Parameters: `.cp` of all cameras, and `.rf` of the reference marker where it was pointed at.

        Raises:
            KinemarkError: balls are still to be pointed at, or the calibration has no L parameters.
        """
        calibration = self.session.settings.calibration
        self.folder.mkdir(parents=True, exist_ok=True)
        if calibration.control_points is not None and calibration.control_points.images is not None:
            written = self._of_balls(made)
        elif calibration.file is not None and is_cp(calibration.file):
            written = []
        else:
            written = self._of_rig(self.session.calibrate().rig, made)
        remember(self.folder, written, basis(self.session, self.trial, OF_BALLS))
        marks = []
        for name, path in zip(self.cameras, self.rfs(), strict=True):
            if places := (calibration.reference_marker or {}).get(name):
                write_rf(path, np.array(places[0]) * self.square)
                marks.append(path)
        remember(self.folder, marks, basis(self.session, self.trial, OF_MARK))
        return [*written, *marks]

    def save_markers(self, opened: OpenDigitising) -> list[Path]:
        """Save Data: `.da` of all cameras.

        Raises:
            KinemarkError: frames of a camera are still to be digitised.
        """
        left = [
            f"{name} {opened.saved(name)} of {opened.n_frames}" for name in opened.names if not opened.finished(name)
        ]
        if left:
            raise KinemarkError(f"Saved frames: {', '.join(left)}. Digitise the others first.")
        self.folder.mkdir(parents=True, exist_ok=True)
        for path, name in zip(self.das(), self.cameras, strict=True):
            write_da(path, opened.uv[opened.task.rig.names.index(name)] * self.square)
        remember(self.folder, self.das(), basis(self.session, self.trial, OF_MARKERS))
        return self.das()

    def process_coordinates(self, cameras: Sequence[str]) -> Path:
        """Process Coordinates: `.tdc` by these cameras, all where none are named.

        Raises:
            KinemarkError: there are fewer than two, or a file is not there or does not belong.
        """
        if unknown := [name for name in cameras if name not in self.cameras]:
            raise KinemarkError(f"There is no camera {unknown[0]!r}; the session has {', '.join(self.cameras)}.")
        das = self.das(cameras)
        first = self.das()[0]
        markers = None if first in das else len(read_da(first))
        coordinates_files(self.cps(cameras), das, self.tdc(cameras), markers=markers)
        return self.tdc(cameras)

    def process_angles(self, tdc: Path, *, signed: bool) -> list[Path]:
        """Calculate Euler Angles: `.shd`, `.elb` and `.wst` beside a `.tdc`; raises a KinemarkError as it does."""
        angles_files(tdc, signed=signed)
        return self.angle_files(tdc)

    def _of_balls(self, made: date) -> list[Path]:
        """Of the balls' centroids, taken from the images anew: the session keeps them to a ten-thousandth of a px."""
        balls = self.balls
        uv, measured = centroids(balls), self.measured
        if measured is None:
            write_msr(self.folder / f"{BOX}.msr", balls.points.xyz)
            measured = self.folder / f"{BOX}.msr"
        for c, path in enumerate(self.cps()):
            calibrate_file(measured, path, uv[c] * self.square, made=made if c == 0 else None)
        return self.cps()

    def _of_rig(self, rig: Rig, made: date) -> list[Path]:
        if bent := [camera.name for camera in rig if np.any(camera.distortion)]:
            raise KinemarkError(
                f"L parameters have no lenses, and those of {', '.join(bent)} bend the image. Calibrate by control "
                "balls, or calculate by the session: Run, then Angles."
            )
        for c, (path, name) in enumerate(zip(self.cps(), self.cameras, strict=True)):
            P = np.diag([*self.square, 1.0]) @ rig.select([name]).P
            write_cp(path, to_dlt(P)[0], made=made if c == 0 else None)
        return self.cps()


def centroids(balls: ControlBalls) -> Floats:
    """(C, N, 2) px of the balls that were pointed at, NaN of those not seen.

    Raises:
        KinemarkError: some were not asked about yet.
    """
    points = balls.points
    for c, camera in enumerate(points.cameras):
        if left := [name for n, name in enumerate(points.names) if not points.asked[c, n]]:
            raise KinemarkError(f"{camera}: ball {', '.join(left)} is still to be pointed at, or said not to be seen.")
    uv = np.full(points.uv.shape, np.nan)
    for c, camera in enumerate(points.cameras):
        markers = balls.markers(camera)
        for n in np.flatnonzero(np.isfinite(points.uv[c]).all(1)):
            u, v = points.uv[c, n].tolist()
            uv[c, n] = snapped(markers, u, v)
    return uv


def _holds(path: Path, xyz: Floats) -> bool:
    try:
        found = read_msr(path)
    except KinemarkError:
        return False
    return found.shape == xyz.shape and bool(np.abs(found - xyz).max() <= SAME_MM)
