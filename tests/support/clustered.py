"""A virtual laboratory whose subject wears clusters of markers."""

from dataclasses import replace

from kinemark.data.subject_measures import LegMeasures, SubjectMeasures
from kinemark.gait.clusters import SEGMENTS
from kinemark.synth import WalkingBody, gait_laboratory

NAMES = {"pelvis": "PV", "thigh": "TH", "shank": "SK", "foot": "FT"}
LANDMARKS = (
    "LASI", "RASI", "SACR", *(side + name for side in "LR" for name in ("THI", "KNE", "TIB", "ANK", "HEE", "TOE"))
)  # fmt: skip
LEG = LegMeasures(leg_mm=860.0, knee_mm=101.0, ankle_mm=70.0, torsion_deg=17.0, thigh_wand_deg=6.0, shank_wand_deg=-4.0)
MEASURES = SubjectMeasures(LEG, replace(LEG, torsion_deg=9.0), mass_kg=64.0)


def clusters(segments=SEGMENTS):
    """Names of the virtual clusters' markers by segment."""
    letter = {name: "" if name == "pelvis" else name[0].upper() for name in segments}
    return {name: tuple(f"{letter[name]}{NAMES[name.split()[-1]]}{k}" for k in (1, 2, 3, 4)) for name in segments}


def laboratory(segments=SEGMENTS, *, unworn=LANDMARKS, seconds=2.2, **more):
    body = WalkingBody(MEASURES, plated=tuple(segments), unworn=unworn, worn=("KNM", "MED"), **more)
    return gait_laboratory(body, duration_s=seconds)


def called(trial, names):
    """With other names of markers."""
    paths = tuple(replace(p, name=names.get(p.name, p.name)) for p in trial.trajectories.paths)
    return replace(trial, trajectories=replace(trial.trajectories, paths=paths))
