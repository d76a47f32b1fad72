"""Gait against two others: OpenSim's inverse kinematics and dynamics, and pins in the bones.

1. `opensim_gait`: a walk on a treadmill, processed by OpenSim with a planar model of ten degrees of freedom, whose
   joint centres, segment masses and hinge of the knee were scaled to the subject. Ours are the same markers: knee and
   ankle markers, which only the standing trial wears, ride on the clusters of thigh and shank, and their axes stand in
   place of the wands. Definitions differ, so that each curve is compared with its mean difference (`offset`) and
   without.
2. `bone_truth`: a walk with pins in femur and tibia and four skin markers on each segment (Cereatti et al. 2017). The
   knee's angles (Grood and Suntay 1983) from least squares poses of the skin clusters, against those of the pins. The
   clusters are laid upon the bones by their first ten frames. `together` is how far skin moves the mean of a cluster's
   markers over the bone, `apart` how far each moves besides, which alone turns the cluster, and `misfit` what the
   cluster shows of it. `sd` is what is stated: apart by `APART` of `--tissue-mm` on each axis.

    python studies/gait_references.py [--tissue-mm 5]
"""

from __future__ import annotations

import argparse
import os
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from kinemark.data.array_types import Floats
from kinemark.data.laboratory_axes import level_axes
from kinemark.data.subject_measures import LETTER, SIDES, LegMeasures, SubjectMeasures
from kinemark.gait import Contact, Physical, Reaction, with_static_offsets
from kinemark.gait.gait_trial import Inputs, gait_of
from kinemark.gait.uncertainty import APART
from kinemark.io.trial import read_trial
from kinemark.kinematics import body_pose, knee_motion, rotation_covariance
from kinemark.kinematics.pose import Template, carry, cluster_template
from kinemark.signal.filters import butterworth

DATA = Path(os.environ.get("KINEMARK_DATA", "data")) / "mocap3d"
UP = np.array([0.0, 1.0, 0.0])
MASS_KG = 72.6
"""Of the subject, as the model was scaled; the plates carry 72.9."""
DIAMETER_MM = 14.0
"""Of the markers; assumed."""
FROM_FILE = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
"""Columns are x forward, y to the left, z up in the bones' axes x forward, y up, z to the right."""
STILL = 10
"""First frames, by which the clusters are laid upon the bones."""
CUTOFF_HZ = 6.0
"""Of markers and forces; as OpenSim's own results were filtered."""
COMPARED = (
    ("hip flexion", "HipAngles", "hip_flexion", 1.0), ("knee flexion", "KneeAngles", "knee_angle", -1.0),
    ("ankle dorsiflexion", "AnkleAngles", "ankle_angle", 1.0),
)  # fmt: skip
MOMENTS = (
    ("hip extension", "HipMoment", "hip_flexion", -1.0), ("knee extension", "KneeMoment", "knee_angle", 1.0),
    ("ankle plantarflexion", "AnkleMoment", "ankle_angle", -1.0),
)  # fmt: skip


def markers(name: str) -> tuple[dict[str, Floats], float]:
    """(F, 3) mm by name, z up, and frames a second."""
    found = read_trial(DATA / "opensim_gait" / name).trajectories
    turn = level_axes(UP)
    return {path.name: path.xyz @ turn for path in found}, found.rate


def storage(name: str) -> dict[str, Floats]:
    """(N) by column of an OpenSim table."""
    lines = (DATA / "opensim_gait" / name).read_text(encoding="utf-8").splitlines()
    end = next(k for k, line in enumerate(lines) if line.strip() == "endheader")
    rows = np.array([line.split() for line in lines[end + 2 :] if line.strip()], float)
    return dict(zip(lines[end + 1].split(), rows.T, strict=False))


def model_points(given: dict[str, Floats], carried: dict[str, Floats]) -> dict[str, Floats]:
    """The gait model's markers; axes of knee and ankle stand in place of the wands."""
    out = {"LASI": given["L.ASIS"], "RASI": given["R.ASIS"], "SACR": given["V.Sacral"]}
    for letter in LETTER.values():
        knee, ankle = (carried[f"{letter}.{name}.Lat"] for name in ("Knee", "Ankle"))
        out |= {letter + "KNE": knee, letter + "ANK": ankle, letter + "HEE": given[f"{letter}.Heel"]}
        out |= {letter + wand: 2 * lateral - carried[f"{letter}.{joint}.Med"]
                for wand, lateral, joint in (("THI", knee, "Knee"), ("TIB", ankle, "Ankle"))}  # fmt: skip
        out[letter + "TOE"] = (given[f"{letter}.Toe.Lat"] + given[f"{letter}.Toe.Med"]) / 2
    return out


def template(static: dict[str, Floats]) -> Template:
    """Thighs and shanks, with what they carry."""
    clusters = []
    for letter in LETTER.values():
        for body, joint in (("Thigh", "Knee"), ("Shank", "Ankle")):
            names = tuple(f"{letter}.{body}.{place}" for place in ("Upper", "Front", "Rear"))
            points = tuple(f"{letter}.{joint}.{end}" for end in ("Lat", "Med"))
            xyz, ends = (np.array([static[name] for name in each]) for each in (names, points))
            clusters.append(cluster_template(letter + body, names, xyz, points, ends))
    return Template(tuple(clusters))


def measures(static: dict[str, Floats]) -> SubjectMeasures:
    """Of the standing trial."""

    def between(a: str, b: str) -> float:
        return float(np.nanmean(np.linalg.norm(static[a] - static[b], axis=1)))

    legs = [
        LegMeasures(between(f"{x}.ASIS", f"{x}.Ankle.Med"), between(f"{x}.Knee.Lat", f"{x}.Knee.Med") - DIAMETER_MM,
                    between(f"{x}.Ankle.Lat", f"{x}.Ankle.Med") - DIAMETER_MM)
        for x in LETTER.values()
    ]  # fmt: skip
    return SubjectMeasures(legs[0], legs[1], mass_kg=MASS_KG, marker_diameter_mm=DIAMETER_MM)


def reactions(time: Floats) -> tuple[tuple[Reaction, ...], tuple[Contact, ...]]:
    """The belts' reactions at times (F) s, and the contacts on them."""
    table, turn = storage("subject01_walk_grf.mot"), level_axes(UP)
    plates, found = [], []
    for k, (side, before) in enumerate((("right", ""), ("left", "1_"))):
        columns = [f"{before}ground_{what}_{axis}" for what in ("force_v", "force_p", "torque_")
                   for axis in "xyz"]  # fmt: skip
        columns = [name.replace("_v_", "_v").replace("_p_", "_p").replace("torque__", "torque_") for name in columns]
        own = np.array([np.interp(time, table["time"], table[name]) for name in columns]).T
        force, centre, free = (own[:, 3 * j : 3 * j + 3] @ turn for j in range(3))
        loaded = force[:, 2] > 20.0
        corners = np.full((4, 3), np.nan)
        plates.append(Reaction(np.where(loaded[:, None], force, 0.0), np.where(loaded[:, None], 1000 * centre, np.nan),
                               np.where(loaded[:, None], free, 0.0), loaded, corners,
                               np.zeros(len(loaded), np.bool_)))  # fmt: skip
        edges = np.flatnonzero(np.diff(np.concatenate([[0], loaded.astype(int), [0]])))
        found += [Contact(k, int(a), int(b), side, "", 0.0) for a, b in edges.reshape(-1, 2)]  # type: ignore[arg-type]
    return tuple(plates), tuple(found)


def opensim() -> None:
    """Table 1."""
    static, _ = markers("subject01_static.trc")
    walk, rate = markers("subject01_walk.trc")
    known = template(static)
    own = measures(static)
    stood = model_points(static, static)
    own = with_static_offsets(own, stood, flat_foot=True)
    points = model_points(walk, carry(walk, known))
    points = {name: butterworth(xyz, rate=rate, cutoff_hz=CUTOFF_HZ, order=2) for name, xyz in points.items()}
    time = np.arange(len(points["LASI"])) / rate
    plates, found = reactions(time)
    given = Inputs(points, own, plates, found, rate)
    result = gait_of(given, Physical().mechanics)
    print(f"opensim_gait: {len(time)} frames at {rate:.0f} Hz, both sides; ours less OpenSim's")
    print(f"  {'angle, deg':26s}{'range':>9s}{'offset':>9s}{'RMS without it':>16s}{'correlation':>13s}")
    for title, name, theirs, sign in COMPARED:
        row(title, name, theirs, sign, 1.0, result, storage("subject01_walk_IK.mot"), 1)
    print(f"  {'moment, N·m/kg':26s}{'range':>9s}{'offset':>9s}{'RMS without it':>16s}{'correlation':>13s}")
    for title, name, theirs, sign in MOMENTS:
        row(title, name, theirs + "_{}_moment", sign, 1 / MASS_KG, result, storage("subject01_walk_ID.sto"), 3)
    for mm in (-30.0, 30.0):
        legs = [replace(own.leg(side), hip_shift_mm=(mm, 0.0, 0.0)) for side in SIDES]
        moved = given._replace(measures=replace(own, left=legs[0], right=legs[1]))
        print(f"  with the hips {mm:+.0f} mm forward:")
        row(*MOMENTS[0][:2], MOMENTS[0][2] + "_{}_moment", -1.0, 1 / MASS_KG,
            gait_of(moved, Physical().mechanics), storage("subject01_walk_ID.sto"), 3)  # fmt: skip


def row(
    title: str, name: str, theirs: str, sign: float, unit: float, result: Any, table: dict[str, Floats], digits: int
) -> None:
    """One line of the table a side."""
    for side in SIDES:
        column = theirs.format(side[0]) if "{}" in theirs else f"{theirs}_{side[0]}"
        y, true = result.signals[LETTER[side] + name].values[:, 0], sign * unit * table[column]
        both = np.isfinite(y) & np.isfinite(true)
        off = (y - true)[both]
        values = np.ptp(true), off.mean(), off.std()
        cells = "".join(f"{v:{w}.{digits}f}" for v, w in zip(values, (9, 9, 16), strict=True))
        print(f"  {side + ' ' + title:26s}{cells}{np.corrcoef(y[both], true[both])[0, 1]:13.3f}")


def rms(values: Floats) -> float:
    """Of all that is known."""
    return float(np.sqrt(np.nanmean(values**2)))


def bones(tissue_mm: float) -> None:
    """Table 2."""
    path = DATA / "bone_truth" / "dataSample_OTTAWA_walking.mat"
    trial = scipy.io.loadmat(path, squeeze_me=True, struct_as_record=False)["dataSample_OTTAWA_walking"].subj01.trial01
    true, skin, covariance, misfit, moved = {}, {}, {}, {}, {}
    for name in ("R_thigh", "R_shank"):
        part = getattr(trial, name)
        R, t = part.gRa.reshape(-1, 3, 3) @ FROM_FILE, part.gta
        own = np.array([getattr(part.mrk, f"M0{k}") for k in range(1, 5)]) @ FROM_FILE  # in the axes of the bone
        shape = own[:, :STILL].mean(1)
        xyz = np.einsum("fij,kfj->kfi", R, own) + t
        pose = body_pose(shape, xyz)
        true[name], skin[name] = (R, t), (pose.R, pose.t)
        covariance[name] = rotation_covariance(shape, pose, APART * tissue_mm)
        off = own - shape[:, None]
        moved[name] = rms(off.mean(0)), rms(off - off.mean(0))
        misfit[name] = float(np.sqrt(np.nanmean(pose.residual**2)))
    ours, theirs = (knee_motion(*each["R_thigh"], *each["R_shank"], side="right") for each in (skin, true))
    print(f"\nbone_truth, walking: {len(ours.deg)} frames at 120 Hz; knee from skin less knee from pins, deg")
    print(
        f"  misfit of the clusters: thigh {misfit['R_thigh']:.1f}, shank {misfit['R_shank']:.1f} mm a marker and axis"
    )
    for name, (together, apart) in moved.items():
        print(f"  skin over the {name[2:]}: together {together:.1f}, apart {apart:.1f} mm RMS along an axis")
    print(f"  {'':14s}{'range':>8s}{'mean':>8s}{'SD':>8s}{'RMS':>8s}{'sd':>8s}{'within 2 sd':>13s}")
    total = covariance["R_thigh"] + covariance["R_shank"]
    for k, title in enumerate(("flexion", "adduction", "rotation")):
        off = np.remainder(ours.deg[:, k] - theirs.deg[:, k] + 180, 360) - 180
        axis = theirs.axes[:, k]
        sd = np.sqrt(np.einsum("fi,fij,fj->f", axis, total, axis))
        held = 100 * np.mean(np.abs(off) < 2 * sd)
        values = np.ptp(theirs.deg[:, k]), off.mean(), off.std(), np.sqrt(np.mean(off**2)), np.median(sd)
        print(f"  {title:14s}" + "".join(f"{v:8.1f}" for v in values) + f"{held:12.0f}%")


def main() -> None:
    """Both tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tissue-mm", type=float, default=5.0)
    given = parser.parse_args()
    if not DATA.is_dir():
        sys.exit("There are no recordings: set KINEMARK_DATA to their folder.")
    opensim()
    bones(given.tissue_mm)


if __name__ == "__main__":
    main()
