"""A walking body whose segments, joints and markers are those of the conventional gait model, as functions of time.

    hip     in the pelvis where the model's regression has it, moved by `hip_error_mm`                       (1)
    thigh   pelvis · Rᵧ(−flexion) Rₓ(∓adduction) R_z(±external rotation),   shank at the knee likewise        (2)
    shank   the same turned by the torsion about its own z: the axis of the ankle                             (3)
    KNE, ANK  half a width and a marker beside the joint's centre along its axis; THI, TIB in the plane of axis and
            segment, turned back by the wand's angle                                                          (4)
    KAX, KD1, KD2  of a device with its apex at KNE, the first along the axis outwards; KNM, MED at the inner ends of
            the axes
    clusters  of four markers on a plate on each segment that `plated` names, PV1 to 4, and TH, SK and FT after L or R
    foot    its sole's line from toe to heel; TOE hangs on the ankle by two angles, as the model sees no third     (5)

The feet carry the body by turns, so that the pelvis moves over the foot that stands (`gait.stride_of_soles`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache

import numpy as np

from ..data.array_types import Floats
from ..data.model_markers import STATIC_MARKERS
from ..data.subject_measures import LETTER, SIDES, TO_THE_LEFT, LegMeasures, Side, SubjectMeasures
from ..gait.hip_centre import davis
from ..gait.lower_limb import FOOT_SEQUENCE, Leg, LowerLimbs
from ..gait.segments import Segment, relative, upright
from ..kinematics import principal, turned
from .gait import ANKLE, GRID, HIP, KNEE, TILT, Stride, curve, pelvis_path, stride_of_soles

ANKLE_MM = 70.0
"""Height of the ankle's centre above the sole's line of markers; chosen."""
TOE_MM = (120.0, -12.0)
"""TOE before and to the inside of the ankle's centre, mm; chosen."""
FOOT_MM = 175.0
"""From TOE to HEE, mm; chosen."""
TOE_OUT_DEG = 7.0
"""Of the sole's line; chosen."""
PELVIS_DEPTH_MM = 150.0
"""From the front points to the sacrum; chosen."""
WAND_MM = 90.0
"""How far THI and TIB stand out; chosen."""
ROD_MM = 100.0
"""Of a knee alignment device, from its apex to its markers; chosen."""
BEGIN = 0.1
"""Of the left leg's stride, at the time 0; chosen."""
GLIDE_DEG = 60.0
"""Of knee flexion, at which a glide is as long as stated; by definition."""
PLATES = {
    "pelvis": np.array([[-150.0, 60, 20], [-150, -60, 20], [-155, 0, 80], [-145, 10, -30]]),
    "thigh": np.array([[30.0, 80, 250], [-50, 75, 240], [40, 85, 150], [-40, 70, 130]]),
    "shank": np.array([[20.0, 60, 250], [-50, 55, 240], [25, 62, 160], [-45, 50, 150]]),
    "foot": np.array([[20.0, 30, 40], [20, -30, 60], [25, 25, 110], [40, -20, 120]]),
}
"""(4, 3) mm of a cluster's markers in the left segment; chosen, of the size of plates that are worn."""
ZERO = np.zeros(3)
"""No displacement, mm; by definition."""


@dataclass(frozen=True, slots=True, eq=False)
class WalkingBody:
    """A body that walks along x.

    Attributes:
        measures: of the subject, with torsions and wands.
        asis_mm: between the front points.
        speed_mm_s: of the pelvis on average.
        placement_mm: (3) by marker, how far it sits from its landmark, in the axes of its segment.
        plated: segments that wear a cluster, as "pelvis" and "left thigh". unworn: markers that only standing has.
        worn: markers that the standing trial has besides, of `STATIC_MARKERS`; with KAX it has no KNE.
        tissue_mm: likewise, how far skin has moved it over the bone; only while walking.
        hip_error_mm: (3) by side, how far the hip is from where the regression has it, in the pelvis.
        glide_mm: how far the shank glides forward on the thigh at `GLIDE_DEG` of knee flexion, and in proportion.
        path: of the pelvis; follows from the others.
    """

    measures: SubjectMeasures
    asis_mm: float = 240.0
    speed_mm_s: float = 1150.0
    worn: tuple[str, ...] = ()
    plated: tuple[str, ...] = ()
    unworn: tuple[str, ...] = ()
    placement_mm: Mapping[str, Floats] = field(default_factory=dict)
    tissue_mm: Mapping[str, Floats] = field(default_factory=dict)
    hip_error_mm: Mapping[Side, Floats] = field(default_factory=dict)
    glide_mm: float = 0.0
    path: Stride = field(init=False)

    def __post_init__(self) -> None:
        if unknown := [name for name in self.worn if name not in STATIC_MARKERS]:
            raise ValueError(f"worn has {', '.join(unknown)}, wanted some of {', '.join(STATIC_MARKERS)}")
        object.__setattr__(self, "path", self._path())

    @property
    def names(self) -> tuple[str, ...]:
        """Of its markers."""
        return tuple(self.markers(self.standing(1)))

    @property
    def period(self) -> float:
        """Of a stride, s."""
        return self.path.length / self.speed_mm_s

    def limbs(self, time: Floats) -> LowerLimbs:
        """True segments at times (F) s."""
        cycles = self.turn_of(time, "left")
        origin = pelvis_path(self.path, cycles, np.zeros(2))
        origin[:, 0] += self.path.length * (cycles[0] + cycles[-1]) / 2  # the same place at the same time
        return self._limbs(cycles, origin)

    def standing(self, n_frames: int) -> LowerLimbs:
        """True segments of the body that stands still."""
        R = np.broadcast_to(np.eye(3), (n_frames, 3, 3))
        legs = {side: self._leg(Segment(R, np.zeros((n_frames, 3))), side, np.zeros((7, n_frames))) for side in SIDES}
        up = np.array([0.0, 0.0, ANKLE_MM]) - legs["left"].ankle * (0, 0, 1)
        return _raised(LowerLimbs(Segment(R, np.zeros((n_frames, 3))), legs["left"], legs["right"]), up)

    def swinging(self, time: Floats) -> LowerLimbs:
        """True segments at times (F) s of the body that stands and swings its legs, as for a functional hip centre.

        Each leg in turn, the left first, half of the time each: forward and back, outward, and round.
        """
        n, done = len(time), (time - time[0]) / max(float(np.ptp(time)), 1e-9)
        wave = np.stack([np.full(n, 3.0), 3 * np.sin(2.1 * time), 4 * np.cos(1.7 * time)], -1)
        pelvis = Segment(turned(wave, FOOT_SEQUENCE), np.stack([0 * time, 20 * np.sin(time), 900 + 0 * time], -1))
        legs = {side: self._leg(pelvis, side, _swings(2 * done - k)) for k, side in enumerate(SIDES)}
        return LowerLimbs(pelvis, legs["left"], legs["right"])

    def turn_of(self, time: Floats, side: Side) -> Floats:
        """(F) strides of a leg from its own foot strike; whole at each."""
        return BEGIN + np.asarray(time) / self.period + (0.0 if side == "left" else 0.5)

    def markers(self, limbs: LowerLimbs, *, walking: bool = True) -> dict[str, Floats]:
        """(F, 3) mm by name."""
        r, m = self.measures.marker_diameter_mm / 2, self.measures
        pelvis, half = limbs.pelvis, self.asis_mm / 2
        found = {
            "LASI": pelvis.at(np.array([0.0, half, 0.0])), "RASI": pelvis.at(np.array([0.0, -half, 0.0])),
            "SACR": pelvis.at(np.array([-PELVIS_DEPTH_MM, 0.0, 0.0])),
        }  # fmt: skip
        found |= {f"PV{k + 1}": pelvis.at(at) for k, at in enumerate(PLATES["pelvis"]) if "pelvis" in self.plated}
        on = dict.fromkeys(found, pelvis.R)
        for side in SIDES:
            leg, own, s, letter = limbs.leg(side), m.leg(side), TO_THE_LEFT[side], LETTER[side]
            sites = {
                "KNE": (leg.knee + s * (own.knee_mm / 2 + r) * leg.thigh.R[..., 1], leg.thigh.R),
                "ANK": (leg.ankle + s * (own.ankle_mm / 2 + r) * leg.shank.R[..., 1], leg.shank.R),
                "THI": (_wand(leg.thigh, leg.hip, own.thigh_wand_deg, s), leg.thigh.R),
                "TIB": (_wand(leg.shank, leg.knee, own.shank_wand_deg, s), leg.shank.R),
                "TOE": (leg.foot.origin, leg.foot.R),
                "HEE": (leg.foot.origin + FOOT_MM * leg.foot.R[..., 2], leg.foot.R),
            }
            sites |= self._plate_sites(leg, side)
            if not walking:
                sites |= self._standing_sites(leg, side)
            found |= {letter + name: xyz for name, (xyz, _) in sites.items()}
            on |= {letter + name: R for name, (_, R) in sites.items()}
        moved_by = {name: self.placement_mm.get(name, ZERO) for name in found}
        if walking:
            moved_by = {name: by + self.tissue_mm.get(name, ZERO) for name, by in moved_by.items()}
        moved = {name: xyz + on[name] @ moved_by[name] for name, xyz in found.items()}
        unworn = self.unworn if walking else () if "KAX" not in self.worn else ("LKNE", "RKNE")
        return {name: xyz for name, xyz in moved.items() if name not in unworn}

    def _plate_sites(self, leg: Leg, side: Side) -> dict[str, tuple[Floats, Floats]]:
        """Places and axes of the markers of a leg's clusters."""
        out = {}
        for name, part in (("TH", "thigh"), ("SK", "shank"), ("FT", "foot")):
            segment: Segment = getattr(leg, part)
            for k, at in enumerate(PLATES[part] if f"{side} {part}" in self.plated else ()):
                out[f"{name}{k + 1}"] = (segment.at(at * (1.0, TO_THE_LEFT[side], 1.0)), segment.R)
        return out

    def _standing_sites(self, leg: Leg, side: Side) -> dict[str, tuple[Floats, Floats]]:
        """Places and axes of the markers that only the standing trial wears."""
        own, s, r = self.measures.leg(side), TO_THE_LEFT[side], self.measures.marker_diameter_mm / 2
        knee, ankle = own.knee_mm / 2 + r, own.ankle_mm / 2 + r
        apex = leg.knee + s * knee * leg.thigh.R[..., 1]
        rods = {name: apex + ROD_MM * leg.thigh.R @ way for name, way in _rods(s).items()}
        rods |= {"KNM": leg.knee - s * knee * leg.thigh.R[..., 1]}
        sites = {name: (xyz, leg.thigh.R) for name, xyz in rods.items()}
        sites |= {"MED": (leg.ankle - s * ankle * leg.shank.R[..., 1], leg.shank.R)}
        return {name: site for name, site in sites.items() if name in self.worn}

    def _path(self) -> Stride:
        cycles = np.arange(GRID) / GRID
        limbs = self._limbs(cycles, np.zeros((GRID, 3)))
        soles = []
        for side in SIDES:  # as with hips where the regression has them: else the leg whose hip is higher hardly treads
            foot, moved_by = limbs.leg(side).foot, limbs.pelvis.R @ self.hip_error_mm.get(side, ZERO)
            soles += [foot.origin - moved_by, foot.origin + FOOT_MM * foot.R[..., 2] - moved_by]
        return stride_of_soles(np.stack(soles))

    def _limbs(self, cycles: Floats, origin: Floats) -> LowerLimbs:
        """Where the left leg's stride is at `cycles` (F)."""
        wave = 2 * np.pi * cycles
        R = turned(
            np.stack([TILT + np.cos(2 * wave), 4.0 * np.cos(wave - 0.8), -5.0 * np.cos(wave)], -1), FOOT_SEQUENCE
        )
        pelvis = Segment(R, origin)
        left = self._leg(pelvis, "left", _leg_angles(cycles))
        return LowerLimbs(pelvis, left, self._leg(pelvis, "right", _leg_angles(cycles + 0.5)))

    def _leg(self, pelvis: Segment, side: Side, deg: Floats) -> Leg:
        """(1) to (5) from (7, F) deg: hip flexion, adduction, external rotation; knee flexion, adduction, external
        rotation; dorsiflexion."""
        own, s = self.measures.leg(side), TO_THE_LEFT[side]
        thigh_mm, shank_mm = _lengths(own)
        hip = pelvis.at(davis(self.measures, side, self.asis_mm) + self.hip_error_mm.get(side, ZERO))  # (1)
        flexion, adduction, external, knee_flexion, knee_adduction, knee_external, dorsiflexion = deg
        R = pelvis.R @ turned(np.stack([-flexion, -s * adduction, s * external], -1), FOOT_SEQUENCE)  # (2)
        thigh = Segment(R, hip - thigh_mm * R[..., 2])
        R = R @ turned(np.stack([knee_flexion, -s * knee_adduction, s * knee_external], -1), FOOT_SEQUENCE)
        glide = (self.glide_mm * knee_flexion / GLIDE_DEG)[..., None] * thigh.R[..., 0]
        at_knee = Segment(R, thigh.origin + glide - shank_mm * R[..., 2])
        shank = at_knee.turned_about_z(s * own.torsion_deg)  # (3)
        neutral = np.array([-TOE_MM[0], -s * TOE_MM[1], ANKLE_MM])  # from TOE to the ankle, in a shank that stands
        swing = turned(np.stack([-dorsiflexion, 0 * dorsiflexion, 0 * dorsiflexion], -1), "yxz")
        back = np.einsum("...ij,...j->...i", shank.R @ swing, neutral)
        bare = upright(shank.origin - back, back, shank.R[..., 1])
        return Leg(hip, thigh, shank, at_knee, Segment(bare.R @ _offsets(side), bare.origin), bare)  # (5)


@cache
def _offsets(side: Side) -> Floats:
    """(3, 3) from the line of ankle and toe to the sole's line, by the two angles that the model keeps; of any body."""
    s = TO_THE_LEFT[side]
    neutral = np.array([-TOE_MM[0], -s * TOE_MM[1], ANKLE_MM])
    out = np.radians(TOE_OUT_DEG)
    sole = np.array([-np.cos(out), -s * np.sin(out), 0.0])
    y = np.array([0.0, 1.0, 0.0])
    bare, stood = (upright(np.zeros(3), z, y).R for z in (neutral, sole))
    deg = principal(relative(bare, stood), FOOT_SEQUENCE) * (1, 1, 0)
    return turned(deg, FOOT_SEQUENCE)


def _leg_angles(cycles: Floats) -> Floats:
    """(7, F) deg at strides of that leg."""
    wave = 2 * np.pi * cycles
    return np.stack([
        curve(HIP, cycles), 1.0 + 5.5 * np.cos(wave - 1.3), 6.0 + 5.0 * np.cos(wave),
        curve(KNEE, cycles), 1.0 + 3.0 * np.cos(wave - 4.0), 2.0 + 6.0 * np.sin(wave),
        curve(ANKLE, cycles),
    ])  # fmt: skip


def _swings(done: Floats) -> Floats:
    """(7, F) deg while one leg swings, from 0 to 1 of its time: forward and back, outward, and two circles."""
    s = np.clip(done, 0.0, 1.0)
    first, second, third = (np.clip(3 * s - k, 0, 1) for k in range(3))
    flexion = 35 * np.sin(4 * np.pi * first) + 25 * np.sin(4 * np.pi * third)
    adduction = -30 * (1 - np.cos(4 * np.pi * second)) / 2 - 15 * (1 - np.cos(4 * np.pi * third))
    bend = 10 + 15 * np.abs(np.sin(4 * np.pi * first))
    rest = 0 * s
    return np.stack([flexion, adduction, 8 * np.sin(6 * np.pi * s), bend, rest, rest, rest])


def _lengths(own: LegMeasures) -> tuple[float, float]:
    """Thigh and shank, mm, of a leg's length; chosen: the hip is 90 mm below the front of the pelvis."""
    between = own.leg_mm - 90.0 + 10.0
    return 0.5 * between, 0.5 * between


def _rods(s: float) -> dict[str, Floats]:
    """(3) directions of a knee alignment device's rods in the thigh."""
    half = np.sqrt(0.5)
    return {"KAX": s * np.eye(3)[1], "KD1": half * np.array([1.0, 0, 1]), "KD2": half * np.array([1.0, 0, -1])}


def _wand(segment: Segment, proximal: Floats, deg: float, s: float) -> Floats:
    """(F, 3) mm of a wand's marker half-way down a segment, turned outwards by `deg` (4)."""
    turn = segment.turned_about_z(s * deg)
    return (proximal + segment.origin) / 2 + s * WAND_MM * turn.R[..., 1]


def _raised(limbs: LowerLimbs, up: Floats) -> LowerLimbs:
    """All of it moved by (F, 3) mm."""

    def moved(segment: Segment) -> Segment:
        return Segment(segment.R, segment.origin + up)

    def leg(one: Leg) -> Leg:
        parts = (one.thigh, one.shank, one.shank_at_knee, one.foot, one.bare_foot)
        return Leg(one.hip + up, *(moved(part) for part in parts))

    return LowerLimbs(moved(limbs.pelvis), leg(limbs.left), leg(limbs.right))
