"""What a gait model knows of a subject besides the markers."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from .errors import KinemarkError

Side = Literal["left", "right"]
SIDES: tuple[Side, Side] = ("left", "right")
LETTER = {"left": "L", "right": "R"}
"""With which a marker's name begins; conventional."""
TO_THE_LEFT = {"left": 1.0, "right": -1.0}
"""1 where lateral is to the left, −1 where it is to the right."""
LENGTHS_MM = {"leg_mm": (200.0, 1500.0), "knee_mm": (30.0, 250.0), "ankle_mm": (20.0, 200.0)}
"""What a person's measures can be, mm; chosen, from a toddler to the tallest: beyond them a unit is wrong."""
LEAST_KG, MOST_KG = 2.0, 400.0
"""What a person's mass can be, kg; chosen likewise."""


@dataclass(frozen=True, slots=True)
class LegMeasures:
    """One leg.

    Attributes:
        leg_mm: from the front of the pelvis to the medial ankle, standing.
        knee_mm, ankle_mm: widths across the epicondyles and the malleoli.
        trochanter_mm: from the front of the pelvis back to the greater trochanter; None: from the length of the leg.
        thigh_wand_deg, shank_wand_deg: by how much the wand's marker is turned outwards from the axis of the knee or
            the ankle, about the segment.
        torsion_deg: of the shank, the ankle's axis outwards from the knee's.
        sole_mm: by how much the sole is thicker below the heel than below the toes.
        plantar_offset_deg, rotation_offset_deg: of the foot to the line from ankle to toe; None: from a static trial.
        hip_mm: of the hip in the pelvis, forward, left and up from the middle of its front points; None: by regression.
        hip_sd_mm: standard uncertainty of each; None: as of a regression.
        hip_shift_mm: of the hip from where the regression, or `hip_mm`, has it.

    Raises:
        KinemarkError: a length is none that a person can have.
    """

    leg_mm: float
    knee_mm: float
    ankle_mm: float
    trochanter_mm: float | None = None
    thigh_wand_deg: float = 0.0
    shank_wand_deg: float = 0.0
    torsion_deg: float = 0.0
    sole_mm: float = 0.0
    plantar_offset_deg: float | None = None
    rotation_offset_deg: float | None = None
    hip_mm: tuple[float, float, float] | None = None
    hip_sd_mm: tuple[float, float, float] | None = None
    hip_shift_mm: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        for name, (low, high) in LENGTHS_MM.items():
            value = getattr(self, name)
            if not low <= value <= high:
                raise KinemarkError(
                    f"{name} of a leg is {value:g}, wanted {low:g} to {high:g} mm. Give the measure in millimetres."
                )

    @property
    def hip_to_trochanter_mm(self) -> float:
        """As measured, else 0.1288 times the leg's length less 48.56 mm (Davis et al. 1991)."""
        return self.trochanter_mm if self.trochanter_mm is not None else 0.1288 * self.leg_mm - 48.56


@dataclass(frozen=True, slots=True)
class ArmMeasures:
    """One arm.

    Attributes:
        shoulder_mm: from the marker on the acromion down to the joint centre.
        elbow_mm, wrist_mm: widths. hand_mm: thickness.

    Raises:
        KinemarkError: a length is none that a person can have.
    """

    shoulder_mm: float
    elbow_mm: float
    wrist_mm: float
    hand_mm: float

    def __post_init__(self) -> None:
        for name in ("shoulder_mm", "elbow_mm", "wrist_mm", "hand_mm"):
            value = getattr(self, name)
            if not 5 <= value <= 250:
                raise KinemarkError(f"{name} of an arm is {value:g}, wanted 5 to 250 mm. Give it in millimetres.")


@dataclass(frozen=True, slots=True)
class SubjectMeasures:
    """A subject.

    Attributes:
        left, right: the legs.
        mass_kg: of the body; None where unknown, which leaves moments without a mass to divide by.
        height_mm: None where unknown.
        asis_mm: between the front points of the pelvis; None: as the markers have it.
        marker_diameter_mm: from the skin to the middle of a marker is half of it.
        left_arm, right_arm: None where unknown, which leaves arms without angles.
        head_offset_deg: by how much the plane of the head's markers is tilted, from a static trial.

    Raises:
        KinemarkError: the mass or the diameter is none.
    """

    left: LegMeasures
    right: LegMeasures
    mass_kg: float | None = None
    height_mm: float | None = None
    asis_mm: float | None = None
    marker_diameter_mm: float = 14.0
    left_arm: ArmMeasures | None = None
    right_arm: ArmMeasures | None = None
    head_offset_deg: float = 0.0

    def __post_init__(self) -> None:
        if self.mass_kg is not None and not LEAST_KG <= self.mass_kg <= MOST_KG:
            raise KinemarkError(f"mass_kg is {self.mass_kg:g}, wanted {LEAST_KG:g} to {MOST_KG:g} kg.")
        if not 0 <= self.marker_diameter_mm <= 60:
            raise KinemarkError(f"marker_diameter_mm is {self.marker_diameter_mm:g}, wanted 0 to 60 mm.")

    def leg(self, side: Side) -> LegMeasures:
        """Of one side."""
        return self.left if side == "left" else self.right

    def with_leg(self, side: Side, leg: LegMeasures) -> SubjectMeasures:
        """The measures with another leg of one side."""
        return replace(self, left=leg) if side == "left" else replace(self, right=leg)

    def arm(self, side: Side) -> ArmMeasures | None:
        """Of one side."""
        return self.left_arm if side == "left" else self.right_arm

    @property
    def mean_leg_mm(self) -> float:
        """Mean length of the legs."""
        return float(np.mean([self.left.leg_mm, self.right.leg_mm]))
