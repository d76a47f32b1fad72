"""Kinemark: marker-based optical motion capture, from camera images to 3D trajectories.

The stages, each `stage(data, …, method=Method(…)) -> data`:

    rig = read_rig_toml("rig.toml")
    seen = detect([open_images(f"walk/{c}.mkv") for c in rig.names], cameras=rig.names, rate=50.0)
    trajectories = to_trajectories(track_detections(seen, rig), rig)
    filled, gaps = fill(trajectories)
    write_c3d("walk.c3d", Trial("walk", filled))

A whole session with its report: `from kinemark.engine.session import Session`.
"""

from .calibrate import (
    ControlPoints,
    Dlt,
    Linearisation,
    Wand,
    calibrate_control_frame,
    calibrate_control_points,
    calibrate_points,
    calibrate_sticks,
    calibrate_wand,
    linearise,
    predicted_covariance,
)
from .data import (
    Analog,
    AngleModel,
    Angles,
    Camera,
    Cloud,
    Detections,
    Events,
    ForcePlate,
    KinemarkError,
    MarkerSet,
    MarkerTrajectory,
    Matches,
    Origin,
    Rig,
    Rods,
    Signal,
    Signals,
    Tracks,
    Trajectories,
    Trial,
    Validity,
)
from .detect import Centroids, KissNearest, KissScanning, Masks, detect, learn_masks, propose
from .fill import Auto, Filled, FilledGap, fill, place_absent, trim_edges
from .geometry import project, refine, triangulate, undistort
from .io.c3d import read_c3d, write_c3d
from .io.detections_csv import read_detections_csv, write_detections_csv
from .io.dlt_csv import read_dlt_csv, write_dlt_csv
from .io.images import open_images
from .io.model_toml import load_model
from .io.records import load, save
from .io.rig_toml import read_rig_toml, write_rig_toml
from .io.tdf import read_tdf
from .io.trajectories_csv import read_trajectories_csv, write_trajectories_csv
from .io.trc import read_trc, write_trc
from .io.trial import read_trial, write_trial
from .kinematics import InverseCosines, SignedAngles, joint_angles
from .match import EpipolarTriplets, KissTriplets, NearestEpipolar, match
from .reconstruct import CameraPairs, LeastSquares, reconstruct
from .synth.score import score
from .track import DistanceOnly, ExtrapolationLadder, KissTracking, Swamidas, to_trajectories, track
from .track.simultaneous import (
    FormerTwoCameras,
    Simultaneous,
    ambiguous_decisions,
    diagnose,
    diagnose_tracks,
    track_detections,
    track_simultaneously,
)
from .version import __version__

__all__ = [
    "Analog",
    "AngleModel",
    "Angles",
    "Auto",
    "Camera",
    "CameraPairs",
    "Centroids",
    "Cloud",
    "ControlPoints",
    "Detections",
    "DistanceOnly",
    "Dlt",
    "EpipolarTriplets",
    "Events",
    "ExtrapolationLadder",
    "Filled",
    "FilledGap",
    "ForcePlate",
    "FormerTwoCameras",
    "InverseCosines",
    "KinemarkError",
    "KissNearest",
    "KissScanning",
    "KissTracking",
    "KissTriplets",
    "LeastSquares",
    "Linearisation",
    "MarkerSet",
    "MarkerTrajectory",
    "Masks",
    "Matches",
    "NearestEpipolar",
    "Origin",
    "Rig",
    "Rods",
    "Signal",
    "Signals",
    "SignedAngles",
    "Simultaneous",
    "Swamidas",
    "Tracks",
    "Trajectories",
    "Trial",
    "Validity",
    "Wand",
    "__version__",
    "ambiguous_decisions",
    "calibrate_control_frame",
    "calibrate_control_points",
    "calibrate_points",
    "calibrate_sticks",
    "calibrate_wand",
    "detect",
    "diagnose",
    "diagnose_tracks",
    "fill",
    "joint_angles",
    "learn_masks",
    "linearise",
    "load",
    "load_model",
    "match",
    "open_images",
    "place_absent",
    "predicted_covariance",
    "project",
    "propose",
    "read_c3d",
    "read_detections_csv",
    "read_dlt_csv",
    "read_rig_toml",
    "read_tdf",
    "read_trajectories_csv",
    "read_trc",
    "read_trial",
    "reconstruct",
    "refine",
    "save",
    "score",
    "to_trajectories",
    "track",
    "track_detections",
    "track_simultaneously",
    "triangulate",
    "trim_edges",
    "undistort",
    "write_c3d",
    "write_detections_csv",
    "write_dlt_csv",
    "write_rig_toml",
    "write_trajectories_csv",
    "write_trc",
    "write_trial",
]
