"""A joint's centre from motion: the point that stays fixed in both bodies (Ehrig et al. 2006, SCoRE).

With the poses (R₁, t₁) and (R₂, t₂) of two clusters in every frame, the centre is c₁ in the first and c₂ in the second:

    R₁ c₁ + t₁ = R₂ c₂ + t₂   for all frames, or   [R₁ −R₂] (c₁, c₂) = t₂ − t₁                          (1)

solved by least squares. The least singular value of the stacked matrix, over √F, says how much the joint was turned
about its least used axis: a hinge leaves the place along its axis open, and (1) is then refused. The covariance
s² (AᵀA)⁻¹ (2) takes the residuals of all frames as independent; slow errors such as skin make it too small.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data import KinemarkError, Trajectories
from ..data.array_types import Floats
from ..data.models import Cluster, Model
from .chain import picked
from .pose import ClusterTemplate, Pose, Template, body_pose, cluster_template

LEAST_TURN = 0.05
"""Of the least singular value over √F; about 6° of standard deviation about the least used axis; chosen."""


class JointCentre(NamedTuple):
    """A centre in both bodies.

    Attributes:
        first, second: (3) mm in the axes of each template.
        cov: (6, 6) mm² of both.
        residual: mm, RMS distance between the two where the bodies have them.
    """

    first: Floats
    second: Floats
    cov: Floats
    residual: float


def joint_centre(first: Pose, second: Pose) -> JointCentre:
    """The centre (1) between two bodies from their poses over F frames.

    Raises:
        KinemarkError: fewer than ten frames have both, or the joint hardly turned about some axis.
    """
    known = np.isfinite(first.R).all((1, 2)) & np.isfinite(second.R).all((1, 2))
    n = int(known.sum())
    if n < 10:
        raise KinemarkError(f"{n} frames have both bodies, wanted 10 or more to find a joint's centre.")
    A = np.concatenate([first.R[known], -second.R[known]], -1).reshape(-1, 6)
    b = (second.t - first.t)[known].reshape(-1)
    U, S, Vt = np.linalg.svd(A, full_matrices=False)
    if S[-1] / np.sqrt(n) < LEAST_TURN:
        raise KinemarkError(
            "The joint turned too little about one of its axes to show its centre. Record circling and swinging in "
            "all directions."
        )
    c = Vt.T @ ((U.T @ b) / S)  # (1)
    residual = A @ c - b
    cov = Vt.T @ np.diag(S**-2.0) @ Vt * (residual @ residual) / (len(b) - 6)  # (2)
    return JointCentre(c[:3], c[3:], cov, float(np.sqrt(residual @ residual / n)))


def static_template(static: Trajectories, model: Model, *, functional: Trajectories | None = None) -> Template:
    """Templates of a model's clusters with the points that they carry.

    Args:
        static: a trial in which clusters and points are seen together.
        model: its clusters and centres.
        functional: the motion that shows the centres; needed where the model has some.

    Raises:
        KinemarkError: a marker or point is absent, a cluster is never whole, or a centre cannot be found.
    """
    if not model.clusters:
        raise KinemarkError(f"The model {model.name!r} has no clusters, so that it needs no static trial.")
    found = {cluster.name: _template(static, model, cluster) for cluster in model.clusters}
    for centre in model.centres:
        if functional is None:
            raise KinemarkError(f"The model {model.name!r} finds {centre.name} from motion. Give that trial as well.")
        one, two = (_pose(functional, model, found[name]) for name in centre.between)
        place = joint_centre(one, two).second
        body = found[centre.between[1]]
        found[body.name] = ClusterTemplate(
            body.name, body.markers, body.xyz, (*body.points, centre.name), np.vstack([body.local, place])
        )
    return Template(tuple(found.values()))


def _template(static: Trajectories, model: Model, cluster: Cluster) -> ClusterTemplate:
    xyz = picked(static, cluster.markers, model).xyz
    carried = picked(static, cluster.points, model).xyz.reshape(-1, static.n_frames, 3)
    return cluster_template(cluster.name, cluster.markers, xyz, cluster.points, carried)


def _pose(trial: Trajectories, model: Model, cluster: ClusterTemplate) -> Pose:
    return body_pose(cluster.xyz, picked(trial, cluster.markers, model).xyz)
