"""What limits the accuracy of a recording: each source of error alone, in mm of a marker and in degrees of an angle.

    centroid noise    N of `chain` eq. 1, of the views that each point really had, with the noise that residuals show
    disturbed images  markers partly hidden, run together or mistaken: points with residuals far beyond all others, as
                      `evidence` eq. 9; as if every image counted alike, which robust reconstruction does better than
    lens model        displacements that `evidence` eq. 5 finds, by their common part in two halves of the trial
    calibration       S Σ Sᵀ where the calibration states Σ, without a common turn and shift of the world; or, where
                      that is more or Σ is not stated, what `evidence` eq. 3 finds
    marker placement  as the user says, mm along each axis; the trial cannot tell

σ of a marker is √(trace / 3) in mm. Angles are those of a model where one is given, else the directions of `segments`.
Errors that markers share cancel in them. In a mean over n cycles the noise falls by √n (`chain` eq. 7), the rest stays.
Independent sources add by squares,

    σ² = Σ σ_i²                                                          (1)

A lost camera is another matter: nothing is wrong with it until it is gone. What the images are off by, noise and what
is common, then goes through the cameras that are left. It costs √(σ_c² − σ²) (2) at the points that two of the others
still see, and all other points.

Single frames in which cameras hardly determine a point would decide any mean. `typical` is the root mean square of
all but the largest twentieth, and what is called 95 % is where that begins.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..calibrate.quality import apart_from_frame, joint_of
from ..data import KinemarkError, Rig
from ..data.array_types import Bools, Floats
from ..data.method import Method, parameter
from .observed_errors import Gains, Shown, gains, shown
from .propagation import Kinematics, angle_jacobian
from .sample_frames import SampledFrames
from .segment_directions import segment_jacobian, segments

Unit = Literal["mm", "deg"]
Evidence = Literal[
    "given",
    "residual_scatter",
    "calibration_residuals",
    "usual_noise",
    "residuals_of_regions",
    "outlying_residuals",
    "residuals_of_cameras",
    "calibration_covariance",
    "usual_placement",
]

FEWEST = 10  # points to judge by; chosen
USUAL_PX = 0.2
"""A centroid's standard deviation where nothing tells of it; chosen."""
EVERY = 7
"""Points that are enough to fix the world by; chosen."""


@dataclass(frozen=True, slots=True)
class ErrorBudget(Method):
    """What limits the accuracy of a trial, source by source."""

    placement_mm: float = parameter(
        5.0, unit="mm", low=0,
        meaning="standard deviation, along each axis, of where a marker sits against its landmark",
    )  # fmt: skip
    cycles: int = parameter(6, unit="cycles", low=1, meaning="over how many a mean is taken")
    centroid_sd: float | None = parameter(
        None, unit="px", above=0, meaning="standard deviation of a centroid; None: as the residuals show it"
    )
    frames: int = parameter(
        400, unit="frames", low=2, meaning="at most so many of the recording are looked at, evenly spaced"
    )


@dataclass(frozen=True, slots=True, eq=False)
class ErrorSource:
    """One source of error, alone.

    Attributes:
        name: of the source.
        px: its standard deviation in an image, px; NaN where it is none of images.
        mm: (M, F) σ of a marker per axis, mm.
        deg: (F, A) σ of the angles, deg.
        averages: whether a mean over cycles makes it smaller.
        evidence: how it is known; words for it are in `report.words`.
    """

    name: str
    px: float
    mm: Floats
    deg: Floats
    averages: bool
    evidence: Evidence


@dataclass(frozen=True, slots=True, eq=False)
class LostCamera:
    """A camera that is lost.

    Attributes:
        camera: its name.
        mm, deg: σ of markers (M, F) and angles (F, A) without it.
        all_mm, all_deg: the same with it, where there is something left without it.
        gone: share of points that are lost with it.
    """

    camera: str
    mm: Floats
    deg: Floats
    all_mm: Floats
    all_deg: Floats
    gone: float

    def cost(self, which: Unit) -> float:
        """(2), typical."""
        after, before = typical(getattr(self, which)), typical(getattr(self, f"all_{which}"))
        return float(np.sqrt(max(after**2 - before**2, 0.0)))


@dataclass(frozen=True, slots=True, eq=False)
class Ranking:
    """All that was found.

    Attributes:
        sources: the greatest first.
        lost: cameras, the one most missed first; empty where there are only two.
        angles: (A) what the angles are; markers: (M) names.
        by_model: whether the angles are those of a model.
        evidence: what the residuals show.
        stated_mm, shown_mm: σ of a marker by the calibration's own covariance, and by residuals; NaN where unknown.
        method: what was asked.
    """

    sources: tuple[ErrorSource, ...]
    lost: tuple[LostCamera, ...]
    angles: tuple[str, ...]
    markers: tuple[str, ...]
    by_model: bool
    evidence: Shown
    stated_mm: float
    shown_mm: float
    method: ErrorBudget

    @property
    def unit(self) -> Unit:
        """What is ranked by: degrees where there are angles."""
        return "deg" if self.angles else "mm"

    def total(self, which: Unit, *, without: str = "", cycles: int = 1) -> Floats:
        """(1) over all sources or all but one: (M, F) mm or (F, A) deg, of single frames or of means over cycles.

        Where residuals tell nothing, as with two cameras, what they would tell counts as nothing.
        """
        known = np.any([np.isfinite(getattr(s, which)) for s in self.sources], axis=0)
        parts = [getattr(s, which) ** 2 / (cycles if s.averages else 1) for s in self.sources if s.name != without]
        return np.where(known, np.sqrt(np.sum(np.nan_to_num(parts), axis=0)), np.nan)


def typical(values: Floats) -> float:
    """Root mean square of values (…) that are known, but for the largest twentieth; NaN where none is."""
    known = values[np.isfinite(values)]
    if not known.size:
        return float("nan")
    kept = known[known <= np.quantile(known, 0.95)]
    return float(np.sqrt((kept**2).mean()))


def rank(
    rig: Rig,
    there: SampledFrames,
    *,
    method: ErrorBudget = ErrorBudget(),
    angles: tuple[tuple[str, ...], Kinematics] | None = None,
) -> Ranking:
    """The sources of error of a recording, and what each camera's loss would cost.

    Args:
        rig: the cameras, C of them, with the covariance of their calibration where it is known.
        there: markers and their images.
        method: what is asked.
        angles: names (A) and the kinematics that gives them from all markers of `there`; segments' directions without.

    Raises:
        KinemarkError: fewer than two cameras, or hardly a marker that two see.
    """
    names, J = _angles(there, angles)
    work = _begun(rig, there, method, J)
    sources, stated, by_residuals = work.sources()
    unit = "deg" if names else "mm"
    sources.sort(key=lambda source: -np.nan_to_num(typical(getattr(source, unit))))
    lost = [work.lost(c) for c in range(len(rig))] if len(rig) > 2 else []
    lost.sort(key=lambda camera: -np.nan_to_num(camera.cost("mm"), nan=np.inf))
    ordered = (tuple(sources), tuple(lost), names, there.names, angles is not None)
    return Ranking(*ordered, work.found, stated, by_residuals, method)


def _begun(rig: Rig, there: SampledFrames, method: ErrorBudget, J: Floats) -> _Work:
    """The points that two cameras see, and what their residuals show.

    Raises:
        KinemarkError: as `rank`.
    """
    if len(rig) < 2:
        raise KinemarkError(f"A marker's place needs two cameras, and there is {len(rig)}. Calibrate another one.")
    seen, flat = there.seen.reshape(-1, len(rig)), there.xyz.reshape(-1, 3)
    two = (seen.sum(1) >= 2) & np.isfinite(flat).all(1)
    if two.sum() < FEWEST:
        raise KinemarkError(f"Two cameras see {two.sum()} points, and {FEWEST} are the fewest to judge by.")
    seen = seen & two[:, None]
    safe = np.where(two[:, None], flat, flat[two].mean(0))
    uv = np.where(seen[..., None], there.uv.reshape(*seen.shape, 2), np.nan)
    found = shown(rig, safe, uv, np.tile(there.time_s, len(there.xyz)))
    return _Work(rig, there.xyz.shape[:2], method, found, gains(rig, safe, seen), seen, safe, J)


def _angles(there: SampledFrames, angles: tuple[tuple[str, ...], Kinematics] | None) -> tuple[tuple[str, ...], Floats]:
    """Names (A) and J (F, A, M, 3) deg/mm of a model's angles, or of the two turns of each segment."""
    if angles is not None:
        return angles[0], angle_jacobian(angles[1], there.xyz)
    pairs = segments(there)
    names = tuple(f"{there.names[a]} – {there.names[b]}, turn {i}" for a, b in pairs for i in (1, 2))
    return names, segment_jacobian(there.xyz, pairs)


@dataclass(frozen=True, slots=True, eq=False)
class _Work:
    """What all sources are computed from: N = M · F points, seen (N, C) or not, and the angles' J (F, A, M, 3)."""

    rig: Rig
    shape: tuple[int, ...]
    method: ErrorBudget
    found: Shown
    gain: Gains
    seen: Bools
    xyz: Floats
    J: Floats

    def sources(self) -> tuple[list[ErrorSource], float, float]:
        """All of them, and σ mm of the calibration as stated and as shown."""
        noise, evidence = self.noise()
        calibration, stated, by_residuals = self.calibration(noise)
        lens = self.shifted("lens model", self.found.lens_px, self.found.lens, "residuals_of_regions")
        own = self.images("centroid noise", noise, self.gain, self.seen, evidence)
        return [own, lens, calibration, self.disturbed(), self.placement()], stated, by_residuals

    def noise(self) -> tuple[float, Evidence]:
        """Standard deviation of a centroid, px, and how it is known."""
        if self.method.centroid_sd is not None:
            return self.method.centroid_sd, "given"
        if np.isfinite(self.found.noise_px) and self.found.noise_px > 0:
            return self.found.noise_px, "residual_scatter"
        known = [camera.residual for camera in self.rig if camera.residual > 0]
        if known:
            return float(np.sqrt(np.mean(np.square(known)) / 2)), "calibration_residuals"
        return USUAL_PX, "usual_noise"

    def images(self, name: str, sd: float, gain: Gains, seen: Bools, evidence: Evidence) -> ErrorSource:
        """A source that is new in every image."""
        there = seen.sum(1) >= 2
        cov = sd**2 * np.einsum("ncij,nckj->nik", gain.H, gain.H)
        cov = np.where(there[:, None, None], cov, np.nan).reshape(*self.shape, 3, 3)
        deg2 = np.einsum("fami,mfij,famj->fa", self.J, np.nan_to_num(cov), self.J, optimize=True)
        deg = self.known(np.sqrt(np.maximum(deg2, 0)), there)
        return ErrorSource(name, sd, _sigma(cov), deg, True, evidence)

    def disturbed(self) -> ErrorSource:
        """Images that show something else than a whole marker; at the same phase of every cycle, so that it stays."""
        evidence: Evidence = "outlying_residuals"
        name, unit = "disturbed images", self.images("", 1.0, self.gain, self.seen, evidence)
        sd = np.sqrt(self.found.disturbed)
        if not self.found.freedom:
            return ErrorSource(
                name, float("nan"), np.full_like(unit.mm, np.nan), np.full_like(unit.deg, np.nan), False, evidence
            )
        H = self.gain.H * sd[:, None, None, None]
        each = self.images(name, 1.0, self.gain._replace(H=H), self.seen, evidence)
        views = self.seen.sum(1)
        px = float(np.sqrt((self.found.disturbed * views).sum() / max(views.sum(), 1)))
        return ErrorSource(name, px, each.mm, each.deg, False, evidence)

    def shifted(self, name: str, px: float, move: Floats, evidence: Evidence) -> ErrorSource:
        """A source found as displacements (N, 3) mm, each marker and place having its own."""
        at = np.where(self.found.placed[:, None], move, np.nan).reshape(*self.shape, 3)
        deg = np.abs(np.einsum("fami,mfi->fa", self.J, np.nan_to_num(at), optimize=True))
        mm = np.linalg.norm(at, axis=2) / np.sqrt(3)
        return ErrorSource(name, px, mm, self.known(deg, np.isfinite(at[..., 0]).ravel()), False, evidence)

    def calibration(self, noise: float) -> tuple[ErrorSource, float, float]:
        """By the covariance that the calibration states, or by residuals, whichever is more."""
        px, move = self.found.calibration_px, self.found.calibration
        by_residuals = self.shifted("calibration", px, move, "residuals_of_cameras")
        b = typical(by_residuals.mm)
        if not any(camera.cov.any() for camera in self.rig):
            return by_residuals, float("nan"), b
        stated = self.stated(noise)
        a = typical(stated.mm)
        return (by_residuals if b > a else stated), a, b

    def stated(self, noise: float) -> ErrorSource:
        """By the calibration's covariance."""
        there = self.seen.sum(1) >= 2
        joint = apart_from_frame(self.rig, joint_of(self.rig), self.xyz[there][::EVERY], centroid_sd=noise)
        by = -np.einsum("ncij,ncjk->nick", self.gain.H, self.gain.T).reshape(len(self.xyz), 3, -1)
        cov = np.where(there[:, None, None], by @ joint @ by.transpose(0, 2, 1), np.nan).reshape(*self.shape, 3, 3)
        spread = np.nan_to_num(by).reshape(*self.shape, 3, -1)
        S = np.einsum("fami,mfik->fak", self.J, spread, optimize=True)
        deg = np.sqrt(np.maximum(np.einsum("fak,kl,fal->fa", S, joint, S, optimize=True), 0))
        k = joint.shape[0] // len(self.rig)
        own = np.stack([joint[c * k : (c + 1) * k, c * k : (c + 1) * k] for c in range(len(self.rig))])
        px2 = np.einsum("ncik,ckl,ncil->n", self.gain.T, own, self.gain.T, optimize=True)
        px = float(np.sqrt(np.median(px2[there] / (2 * self.seen[there].sum(1)))))
        return ErrorSource("calibration", px, _sigma(cov), self.known(deg, there), False, "calibration_covariance")

    def placement(self) -> ErrorSource:
        """Of markers on the skin."""
        sd, there = self.method.placement_mm, self.seen.sum(1) >= 2
        deg = self.known(sd * np.sqrt((self.J**2).sum((2, 3))), there)
        mm = np.where(there, sd, np.nan).reshape(self.shape)
        return ErrorSource("marker placement", float("nan"), mm, deg, False, "usual_placement")

    def lost(self, c: int) -> LostCamera:
        """Without camera c, by (2)."""
        noise, _ = self.noise()
        sd = float(np.sqrt(noise**2 + self.found.lens_px**2 + self.found.calibration_px**2))
        seen = self.seen.copy()
        seen[:, c] = False
        after = self.images("", sd, gains(self.rig, self.xyz, seen), seen, "residual_scatter")
        before = self.images("", sd, self.gain, self.seen, "residual_scatter")
        all_mm = np.where(np.isfinite(after.mm), before.mm, np.nan)
        all_deg = np.where(np.isfinite(after.deg), before.deg, np.nan)
        gone = 1 - float((seen.sum(1) >= 2).sum()) / float((self.seen.sum(1) >= 2).sum())
        return LostCamera(self.rig.names[c], after.mm, after.deg, all_mm, all_deg, gone)

    def known(self, values: Floats, there: Bools) -> Floats:
        """Values (F, A), NaN where a marker of the angle is not there, of (N)."""
        needed = (np.nan_to_num(self.J, nan=1.0) != 0).any((0, 3))  # (A, M)
        absent = ~there.reshape(self.shape)  # (M, F)
        return np.where((absent.T.astype(np.int64) @ needed.T.astype(np.int64)) > 0, np.nan, values)


def _sigma(cov: Floats) -> Floats:
    return np.asarray(np.sqrt(np.trace(cov, axis1=-2, axis2=-1) / 3))
