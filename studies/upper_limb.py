"""Joint angles of the upper limb on three real recordings, against other software and against bone.

1. `ulema_hand_to_head`: a hand goes to the head, with the joint angles of ULEMA (Jaspers et al. 2011). Its landmarks
   give our ISB model; so do its marker clusters with our own templates from its static trial; the seven points nearest
   to those of UM²AS give the thesis' model. The glenohumeral centre is found again from its functional trial.
2. `bone_truth`: a left arm mimics eating, with pins in scapula and humerus (Cereatti et al. 2017). The landmarks are
   calibrated in the first frames and carried by the skin markers; bone shows where they really are.
3. `arm_box_lift_gaps`: 51 markers with real gaps. Bare landmarks against landmarks that clusters carry.

Run: python studies/upper_limb.py
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from recordings import recording
from scipy.spatial.transform import Rotation

from kinemark.data import Angles, Trajectories
from kinemark.data import MarkerTrajectory as MarkerPath
from kinemark.data.array_types import Floats
from kinemark.io.c3d import read_c3d
from kinemark.io.mat5 import read_mat5
from kinemark.io.model_toml import load_model
from kinemark.kinematics import (
    Centre,
    Cluster,
    Model,
    Template,
    body_pose,
    estimated_sd,
    joint_angles,
    joint_centre,
    named_angles,
    rotation_covariance,
    segment_axes,
    static_template,
    with_marker_sd,
)
from kinemark.kinematics.chain import chosen, picked, points_of

ULEMA = "mocap3d/ulema_hand_to_head"
BONE = "mocap3d/bone_truth/dataSample_S2M_eating.mat"
BOX = "mocap3d/arm_box_lift_gaps/Vicon.c3d"

CLUSTERS = (
    Cluster("thorax", ("ST1", "ST2", "ST3"), ("C7", "T8", "IJ", "PX")),
    Cluster("scapula", ("LACR1", "LACR2", "LACR3"), ("GH",)),
    Cluster("upper arm", ("LUA1", "LUA2", "LUA3", "LUA4"), ("EL", "EM")),
    Cluster("forearm", ("LLA1", "LLA2", "LLA3", "LLA4"), ("RS", "US")),
    Cluster("hand", ("LH1", "LH2", "LH3"), ("MC3", "MCP2", "MCP3", "MCP5")),
)
"""ULEMA's clusters and the landmarks that its recording has fixed to each."""
THEIRS = {
    "LElbowFlExt": ("isb_upper_limb", "elbow", 0),
    "LElbowProSupination": ("isb_upper_limb", "elbow", 2),
    "LElevationplaneH1": ("isb_upper_limb", "shoulder", 0),
    "LShoulderElevationH1": ("isb_upper_limb", "shoulder", 1),
    "LShoulderRotationH1": ("isb_upper_limb", "shoulder", 2),
    "LScapProRetraction": ("isb_shoulder", "scapula", 0),
    "LScapRotation": ("isb_shoulder", "scapula", 1),
    "LScapTilting": ("isb_shoulder", "scapula", 2),
    "LWristFlExt": ("isb_upper_limb", "wrist", 0),
    "LWristDeviation": ("isb_upper_limb", "wrist", 1),
}
"""ULEMA's angle: our model, joint and turn."""
SEVEN = {"ACR1": "C7", "ACR2": "LAC", "ARM3": "LGH", "ELB4": "LEL", "WRU5": "LUS", "WRR6": "LRS", "MC37": "LMCP3"}
"""For each marker of UM²AS the point of ULEMA's that is nearest to it; 1 and 2 serve the shoulder alone."""


def main() -> None:
    ulema(recording(ULEMA))
    bone_truth(recording(BONE))
    box_lift(recording(BOX))


def ulema(folder: Path) -> None:
    """Our angles against ULEMA's."""
    trial, static, circling = (read_c3d(folder / f"{n}.c3d").trajectories for n in ("HTH1", "calMARKERS", "GHr"))
    theirs = ulema_angles(folder / "HTH1.csv")
    ours = {n: joint_angles(trial, model=load_model(n, side="left")) for n in ("isb_upper_limb", "isb_shoulder")}
    whole = load_model("isb_upper_limb", side="left")
    clustered = replace(whole, clusters=CLUSTERS)
    own = joint_angles(trial, model=clustered, template=static_template(static, clustered))
    seven = um2as(trial)
    print("ulema_hand_to_head: 993 frames; r, offset and RMS after the offset, deg, against ULEMA")
    print(f"  {'ULEMA':22s} {'range':>6s}   {'from its landmarks':>26s}   {'from clusters, our template':>28s}")
    for name, (model, joint, turn) in THEIRS.items():
        a, b = ours[model][joint][:, turn], theirs[name]
        row = f"  {name:22s} {np.ptp(b):6.1f}   {_agreement(a, b):>26s}"
        print(row + (f"   {_agreement(own[joint][:, turn], b):>28s}" if model == "isb_upper_limb" else ""))
    for name, turn in (("LElbowFlExt", 0), ("LElbowProSupination", 2)):
        print(f"  UM2AS model {name:22s} {_agreement(seven['elbow'][:, turn], theirs[name])}")
    print(f"  estimated error of its markers: {_median_sd(trial):.5f} mm (the paths were smoothed)")
    _centre(trial, static, circling, clustered, ours["isb_upper_limb"])


def ulema_angles(path: Path) -> dict[str, Floats]:
    """Angles by name, deg, of the first table of ULEMA's CSV, which has one row an angle and covers every frame."""
    found: dict[str, Floats] = {}
    for line in path.read_text(encoding="latin1").splitlines()[1:]:
        name, *cells = line.split("\t")
        if not name:
            return found
        found[name] = np.array([float(cell) for cell in cells if cell.strip()])
    return found


def um2as(trial: Trajectories) -> Angles:
    """The thesis' angles from the points nearest to its markers."""
    paths = tuple(replace(trial[source], name=name) for name, source in SEVEN.items())
    return joint_angles(replace(trial, paths=paths), model=load_model("um2as", side="left"))


def _agreement(a: Floats, b: Floats) -> str:
    """r, mean difference, and RMS of the rest."""
    both = np.isfinite(a) & np.isfinite(b)
    d = np.remainder(a[both] - b[both] + 180, 360) - 180
    return f"r {np.corrcoef(a[both], b[both])[0, 1]:8.5f}  {d.mean():7.2f}  {d.std():6.3f}"


def _median_sd(trial: Trajectories) -> float:
    return float(np.nanmedian([estimated_sd(path.xyz) for path in trial]))


def _centre(trial: Trajectories, static: Trajectories, circling: Trajectories, model: Model, known: Angles) -> None:
    """The glenohumeral centre from the functional trial, beside ULEMA's."""
    bare = tuple(replace(c, points=tuple(p for p in c.points if p != "GH")) for c in model.clusters)
    found = replace(model, clusters=bare, centres=(Centre("GH", ("upper arm", "scapula")),))
    template = static_template(static, found, functional=circling)
    poses = [
        body_pose(template[name].xyz, picked(circling, template[name].markers, found).xyz)
        for name in ("upper arm", "scapula")
    ]
    centre = joint_centre(*poses)
    stored = static_template(static, model)["scapula"]
    apart = np.linalg.norm(template["scapula"].local[-1] - stored.local[-1])
    d = joint_angles(trial, model=found, template=template)["elbow"][:, 0] - known["elbow"][:, 0]
    print(
        f"  glenohumeral centre from GHr: residual {centre.residual:.1f} mm, stated SD up to "
        f"{np.sqrt(np.diag(centre.cov)).max():.2f} mm, {apart:.1f} mm from ULEMA's; elbow flexion moves by "
        f"{d.mean():.2f} +- {d.std():.2f} deg"
    )


def eating() -> Model:
    """Humerus in scapula of a left arm, from the landmarks that the recording gives."""
    shoulder = load_model("isb_shoulder", side="left")
    segments = tuple(s for s in shoulder.segments if s.name != "thorax")
    joints = tuple(j for j in shoulder.joints if j.name == "glenohumeral")
    clusters = (
        Cluster("scapula", tuple(f"S{k}" for k in range(1, 9)), ("AA", "TS", "AI")),
        Cluster("humerus", tuple(f"H{k}" for k in range(1, 8)), ("GH", "EL", "EM")),
    )
    return replace(shoulder, name="eating", segments=segments, joints=joints, clusters=clusters, links=())


STILL = 60
"""Frames at the beginning, 0.2 s, in which the landmarks are calibrated."""


def bones(path: Path) -> tuple[Trajectories, Trajectories]:
    """Skin markers, and landmarks as bone carries them, both in the laboratory, mm, 300 Hz.

    The file has the skin markers in the axes of the bone: a marker is R p + t in the laboratory.
    """
    trial = read_mat5(path)["dataSample_S2M_eating"]["subj01"]["trial01"]
    skin, bone = [], []
    for body, letter in (("L_scapula", "S"), ("L_humerus", "H")):
        part = trial[body]
        R, t = part["gRa"].reshape(-1, 3, 3), part["gta"]
        for k, p in enumerate(part["mrk"].values(), 1):
            skin.append(MarkerPath.measured(f"{letter}{k}", np.einsum("fij,fj->fi", R, p) + t))
        for name, p in part["ALs"].items():
            bone.append(MarkerPath.measured(name.replace("GHC", "GH"), np.einsum("fij,j->fi", R, p.ravel()) + t))
    return Trajectories(tuple(skin), 300.0), Trajectories(tuple(bone), 300.0)


def bone_truth(path: Path) -> None:
    """Angles from skin markers against those of the bones, with the SD predicted."""
    skin, bone = bones(path)
    model = eating()
    template = static_template(first_frames(skin, bone), model)
    true = joint_angles(thinned(bone), model=replace(model, clusters=()))
    trembling = joint_angles(thinned(with_marker_sd(skin)), model=model, template=template)
    misfit, sd = cluster_misfit(skin, model)
    deforming = joint_angles(thinned(misfit), model=model, template=template)
    n = true.deg.shape[1]
    print(f"\nbone_truth, eating: {n} frames, every third of {skin.n_frames} at 300 Hz; glenohumeral joint, deg")
    print(f"  misfit of the clusters to their templates: scapula {sd[0]:.1f}, humerus {sd[1]:.1f} mm a marker and axis")
    print(f"  rotation from bone, RMS deg: {segment_errors(thinned(skin), thinned(bone), model, template)}")
    free = ~(true.locked[0] | deforming.locked[0])
    print(f"  the arm hangs in gimbal lock in {n - free.sum()} frames; the others:")
    head = ("range of bone", "mean error", "SD of error", "RMS", "SD: trembling", "SD: misfit", "within 2 SD of misfit")
    print("  " + " " * 28 + "  ".join(head))
    for j, t, motion in named_angles(model):
        y, s, q = true.deg[j, free, t], deforming.sd[j, free, t], trembling.sd[j, free, t]
        e = np.remainder(deforming.deg[j, free, t] - y + 180, 360) - 180
        values = (np.ptp(y), e.mean(), e.std(), np.sqrt((e**2).mean()), np.median(q), np.median(s))
        cells = [f"{v:{len(h)}.3f}" for v, h in zip(values, head, strict=False)]
        print(f"  {motion.positive:28s}" + "  ".join(cells) + f"  {100 * np.mean(np.abs(e) < 2 * s):20.0f}%")


def segment_errors(skin: Trajectories, bone: Trajectories, model: Model, template: Template) -> str:
    """How far each segment's axes are turned from those of its bone, RMS, and what its cluster's misfit predicts."""
    bare = replace(model, clusters=())
    found = segment_axes(points_of(chosen(skin, model, template)), model, template)
    true = segment_axes(points_of(bone), bare)
    words = []
    for body in template.clusters:
        off = np.linalg.norm(
            Rotation.from_matrix(found[body.name] @ true[body.name].transpose(0, 2, 1)).as_rotvec(degrees=True), axis=1
        )
        pose = body_pose(body.xyz, picked(skin, body.markers, model).xyz)
        predicted = np.sqrt(np.trace(rotation_covariance(body.xyz, pose, pose.residual), axis1=1, axis2=2))
        words.append(f"{body.name} {_rms(off):.1f} (predicted {_rms(predicted):.1f})")
    return ", ".join(words)


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))


def thinned(trial: Trajectories) -> Trajectories:
    """Every third frame, 100 Hz."""
    paths = (MarkerPath.measured(p.name, p.xyz[::3], cov=p.cov[::3]) for p in trial)
    return Trajectories(tuple(paths), trial.rate / 3)


def first_frames(skin: Trajectories, bone: Trajectories) -> Trajectories:
    """Skin markers and landmarks while the arm is still: the static trial."""
    return replace(skin, paths=tuple(MarkerPath.measured(p.name, p.xyz[:STILL]) for p in (*skin, *bone)))


def cluster_misfit(skin: Trajectories, model: Model) -> tuple[Trajectories, list[float]]:
    """The markers with the misfit of their cluster in each frame as their SD, and its RMS in each cluster, mm."""
    paths, typical = [], []
    for cluster in model.clusters:
        xyz = picked(skin, cluster.markers, model).xyz
        shape = xyz[:, :STILL].mean(1)
        sd = body_pose(shape - shape.mean(0), xyz).residual
        typical.append(float(np.sqrt(np.mean(sd**2))))
        cov = sd[:, None, None] ** 2 * np.eye(3)
        paths += [replace(skin[name], cov=cov) for name in cluster.markers]
    return replace(skin, paths=tuple(paths)), typical


LIFT = {
    "PX": "XIPH",
    "IJ": "STER",
    "C7": "T1",
    "T8": "T10",
    "GH": "ACRO_tip",
    "EL": "EPICl",
    "EM": "EPICm",
    "RS": "STYLr",
    "US": "STYLu",
    "MC3": "WRIST",
    "MCP2": "INDEX",
    "MCP3": "LATH",
    "MCP5": "MEDH",
}
"""The marker of the recording that stands nearest to each landmark; the acromion for the glenohumeral centre."""
BODIES = (
    Cluster("arm", ("ARMl", "ARMm", "ARMp_up", "ARMp_do", "EPICl", "EPICm"), ("EL", "EM")),
    Cluster("forearm", ("LARMm", "LARM_elb", "LARM_ant", "STYLr", "STYLr_up", "STYLu"), ("RS", "US")),
    Cluster("hand", ("WRIST", "INDEX", "LASTC", "MEDH", "LATH"), ("MC3", "MCP2", "MCP3", "MCP5")),
)


def box_lift(path: Path) -> None:
    """Angles through real gaps, bare and carried by clusters, and how far the two are from each other."""
    trial = read_c3d(path).trajectories
    model = replace(load_model("isb_upper_limb"), aliases={name: (other,) for name, other in LIFT.items()})
    trial = with_marker_sd(trial)
    bare = joint_angles(trial, model=model)
    clustered = replace(model, clusters=BODIES)
    whole = joint_angles(trial, model=clustered, template=static_template(trial, clustered))
    print(f"\narm_box_lift_gaps: {trial.n_frames} frames; estimated error of a marker {_median_sd(trial):.3f} mm")
    head = ("frames, bare", "frames, clusters", "SD, bare", "SD, clusters", "RMS difference")
    print("  " + " " * 42 + "  ".join(head))
    for j, t, motion in named_angles(model):
        a, b = bare.deg[j, :, t], whole.deg[j, :, t]
        d = np.remainder(a - b + 180, 360) - 180
        sds = [np.nanmedian(angles.sd[j, :, t]) for angles in (bare, whole)]
        values = (np.isfinite(a).sum(), np.isfinite(b).sum(), *sds, np.sqrt(np.nanmean(d**2)))
        cells = [f"{v:{len(h)}.{0 if i < 2 else 3}f}" for i, (v, h) in enumerate(zip(values, head, strict=True))]
        print(f"  {(bare.joints[j] + ' ' + motion.positive):42s}" + "  ".join(cells))
    locks = ", ".join(f"{name} {lock.sum()}" for name, lock in zip(whole.joints, whole.locked, strict=True))
    print(f"  frames in gimbal lock: {locks}")


if __name__ == "__main__":
    main()
