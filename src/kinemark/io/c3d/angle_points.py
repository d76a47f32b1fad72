"""Joint angles among the points of a C3D file, as Plug-in Gait stores its own: listed in POINT:ANGLES, in degrees.

Each joint is a point whose three coordinates are its angles in the order of its sequence; a second point, its name with
` SD`, holds their standard deviations.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...data import Angles, KinemarkError, MarkerTrajectory, Trial
from .document import C3D, with_parameters
from .parameters import Parameter
from .storing import blank_document
from .tables import with_text

SD = " SD"


def with_angles(trial: Trial, angles: Angles) -> Trial:
    """The trial with the angles among its points, ready for `write_c3d`; points of the same names are replaced.

    Raises:
        KinemarkError: the angles have another number of frames than the trial, or a marker has the name of a joint.
    """
    trajectories = trial.trajectories
    if angles.deg.shape[1] != trajectories.n_frames:
        raise KinemarkError(f"The angles have {angles.deg.shape[1]} frames and the trial {trajectories.n_frames}.")
    doc = trial.source if isinstance(trial.source, C3D) else blank_document()
    had = doc.texts("POINT", "ANGLES")
    new = [*angles.joints, *(name + SD for name in angles.joints)]
    if taken := [name for name in new if name in trajectories.names and name not in had]:
        raise KinemarkError(f"The trial has a marker called {', '.join(taken)}, as a joint is. Rename the joint.")
    values = np.concatenate([angles.deg, angles.sd])
    values[~np.isfinite(values)] = np.nan
    paths = tuple(MarkerTrajectory.measured(name, xyz) for name, xyz in zip(new, values, strict=True))
    kept = tuple(path for path in trajectories if path.name not in new)
    listed = [name for name in had if name not in new] + new
    doc = with_text(doc, "POINT", "ANGLES", listed, [-1] * len(listed), ())
    doc = with_parameters(doc, "POINT", [Parameter.text("ANGLE_UNITS", "deg")])
    return replace(trial, trajectories=replace(trajectories, paths=kept + paths), source=doc)
