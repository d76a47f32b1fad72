"""From markers to axes to joint angles, along any chain of segments, with the covariance that markers pass on.

A segment's first axis is the unit vector u along its vector or normal v₁; the second is made perpendicular to it,

    u = v₁ / |v₁|,   w = (v₂ − (u · v₂) u) / |…|                                                        (1)

and the third completes a right-handed set (2). A normal is a cross product of two vectors between points. With A the
axes as columns, a joint turns its child against its parent by

    R = A_parentᵀ A_child                                                                               (3)

which is the transpose of UM²AS A.25–A.27, where axes are rows. Angles are read from R as `sequences` says. To first
order their covariance is

    cov(angles) = Σ_m J_m cov(x_m) J_mᵀ,   J_m = ∂(angles)/∂(x_m)                                       (4)

over the markers m, whose errors are independent of each other; J by central differences, all markers and frames at
once. What a cluster carries depends on all its markers, so (4) goes through the pose of the cluster too. A left limb is
mirrored first: x → −x across the laboratory's sagittal plane, after which it is a right one (Wu et al. 2005).

Files have their floor along any two axes, and subjects face along any. Where a model leaves it to the trial, up is what
the file or the body shows, else the axis nearest to y of the segment that is measured against the laboratory, and
forward the level axis nearest to its x, both on the mean over the frames (5). ISB's segments have x forward and y up in
who stands, so that flexion stays flexion whichever way the subject sits.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..data import Angles, KinemarkError, Trajectories
from ..data.array_types import Floats
from ..data.models import AUTO, LABORATORY, Axis, Joint, Model, Segment
from ..data.nearest_word import some_names
from ..geometry import origin_near
from .pose import Template, carry
from .sequences import AngleMethod, SignedAngles, principal, read_angles

Points = Mapping[str, Floats]

FLAT = 1e-6
"""Sine of the angle between two vectors below which they have no normal: a micron on a metre; chosen."""
STEP = 1e-3
"""mm; of the central differences; chosen."""


def joint_angles(
    trajectories: Trajectories,
    *,
    model: Model,
    method: AngleMethod | None = None,
    template: Template | None = None,
) -> Angles:
    """The angles of all joints of a model, with their covariance and the frames in gimbal lock.

    Args:
        trajectories: of one trial; the covariance of its markers is passed on, NaN where it is unknown.
        model: the chain.
        method: how angles are read from rotations; `SignedAngles()` where none is given.
        template: of the model's clusters, from `pose.static_template`; without it, what clusters would carry is taken
            from the trial's own markers.

    Raises:
        KinemarkError: markers of the model are not in the trial.
    """
    method = method or SignedAngles()
    used = _near_origin(chosen(trajectories, model, template))
    model = in_room(model, complete(points_of(used), model, template))
    R = joint_matrices(points_of(used), model, template)
    read = [read_angles(R[j], joint, method) for j, joint in enumerate(model.joints)]
    deg, locked = np.array([d for d, _ in read]), np.array([flag for _, flag in read])
    C = propagated(used, model, template)
    plain = np.array([_principal(R[j], model, j) for j in range(len(model.joints))])
    slope = _mirrored(deg, plain)
    slope = slope * np.array([joint.signs for joint in model.joints])[:, None, :]
    deg = deg * np.array([joint.signs for joint in model.joints])[:, None, :]
    C = slope[..., :, None] * C * slope[..., None, :]
    sequences = tuple(joint.sequence for joint in model.joints)
    return Angles(tuple(joint.name for joint in model.joints), sequences, deg, C, trajectories.rate, locked)


def _near_origin(trajectories: Trajectories) -> Trajectories:
    """The same about their mean: angles do not depend on the origin, but far from it differences over `STEP` do."""
    origin = origin_near(trajectories.xyz)
    return replace(trajectories, paths=tuple(replace(path, xyz=path.xyz - origin) for path in trajectories))


def _principal(R: Floats, model: Model, j: int) -> Floats:
    joint = model.joints[j]
    return principal(R, joint.sequence, negative_middle=joint.middle == "negative")


def _mirrored(deg: Floats, plain: Floats) -> Floats:
    """−1 where an angle read is the negative of the principal one but for whole and half turns, else 1."""
    rest = np.remainder(deg - plain + 90, 180) - 90  # 0 where they go together
    return np.where(np.abs(rest) > 1e-6, -1.0, 1.0)


def chosen(trajectories: Trajectories, model: Model, template: Template | None = None) -> Trajectories:
    """The markers that a model stands on, under the model's names.

    A marker is looked for by its name, by its aliases, and by both after a subject's name and a colon.

    Raises:
        KinemarkError: one is not there, or a name fits several.
    """
    return picked(trajectories, wanted_markers(model, template), model)


def wanted_markers(model: Model, template: Template | None = None) -> tuple[str, ...]:
    """The markers that a model stands on, by its own names; see `chosen`."""
    wanted = list(model.markers)
    if template is not None:
        carried = template.points
        bodies = [body for body in template.clusters if carried & set(body.points)]
        wanted = [m for m in wanted if m not in carried] + [m for body in bodies for m in body.markers]
    return tuple(dict.fromkeys(wanted))


def picked(trajectories: Trajectories, names: tuple[str, ...], model: Model) -> Trajectories:
    """These markers of a model, under these names; see `chosen`.

    Raises:
        KinemarkError: one is not there, or a name fits several.
    """
    found = places_of(trajectories, names, model)
    paths = [replace(trajectories.paths[i], name=name) for name, i in found.items()]
    return replace(trajectories, paths=tuple(paths))


def places_of(trajectories: Trajectories, names: tuple[str, ...], model: Model) -> dict[str, int]:
    """Index of each of these markers of a model among those of a trial; raises as `picked` does."""
    found = {name: _find(trajectories.names, (name, *model.aliases.get(name, ()))) for name in names}
    if absent := [name for name, place in found.items() if place is None]:
        need = " A static trial gives them." if set(absent) <= model.carried else ""
        raise KinemarkError(
            f"The model {model.name!r} wants the markers {', '.join(absent)}, which are not in the trial; there are "
            f"{some_names(trajectories.names)}.{need} Name them so, or say in a TOML file with "
            f'base = "{model.name}" and [aliases] what they are called here, and give it as the model.'
        )
    return {name: i for name, i in found.items() if i is not None}


def _find(names: tuple[str, ...], wanted: tuple[str, ...]) -> int | None:
    """Index of the first wanted name that is there, whole or after a colon."""
    for name in wanted:
        if name in names:
            return names.index(name)
        ends = [i for i, have in enumerate(names) if have.rsplit(":", 1)[-1] == name]
        if len(ends) > 1:
            raise KinemarkError(f"{name} fits several markers: {', '.join(names[i] for i in ends)}. Keep one subject.")
        if ends:
            return ends[0]
    return None


def points_of(trajectories: Trajectories) -> dict[str, Floats]:
    """(F, 3) mm by name."""
    return {path.name: path.xyz for path in trajectories}


def joint_matrices(points: Points, model: Model, template: Template | None = None) -> Floats:
    """R (J, …, 3, 3) of (3) from points (…, 3) mm by name; NaN where a point is missing or an axis has no direction."""
    axes = segment_axes(points, model, template)
    return np.array([np.swapaxes(axes[joint.parent], -1, -2) @ axes[joint.child] for joint in model.joints])  # (3)


def segment_axes(points: Points, model: Model, template: Template | None = None) -> dict[str, Floats]:
    """Axes (…, 3, 3) of each segment, as columns in the laboratory, mirrored where the model is a left one."""
    whole = complete(points, model, template)
    right = laboratory(model)[:, 2]
    if model.side == "left":
        whole = {name: xyz - 2 * (xyz @ right)[..., None] * right for name, xyz in whole.items()}
    axes = {segment.name: _axes(whole, segment) for segment in model.segments}
    return axes | {LABORATORY: laboratory(model)}


def complete(points: Points, model: Model, template: Template | None = None) -> dict[str, Floats]:
    """The points given, (F, 3) mm by name, with those that clusters carry and those that are means of others."""
    whole = dict(points)
    if template is not None:
        whole |= carry(whole, template)
    for name, parts in model.means.items():
        if all(part in whole for part in parts):
            whole[name] = np.mean([whole[part] for part in parts], axis=0)
    return whole


def laboratory(model: Model) -> Floats:
    """(3, 3) the laboratory's forward, up and right as columns; of a model that leaves them to a trial +x, +z, −y."""
    if model.up == AUTO:
        return np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    forward, up = ((1.0 if d[0] == "+" else -1.0) * np.eye(3)["xyz".index(d[1])] for d in (model.forward, model.up))
    return np.stack([forward, up, np.cross(forward, up)], -1)


def in_room(model: Model, points: Points, *, up: Floats | None = None) -> Model:
    """The model with the laboratory's axes stated (5); itself where they are.

    Args:
        model: whose axes are `AUTO`. points: (F, 3) mm by name, with those that clusters carry.
        up: (3) the axis that goes up, where the file or the body shows it.
    """
    if model.up != AUTO:
        return model
    forward, upward = _stands(model, points)
    above = _nearest_axis(upward if up is None else up, "+z")
    level = np.where(np.arange(3) == "xyz".index(above[1]), 0.0, forward)
    return replace(model, up=above, forward=_nearest_axis(level, "+x" if above[1] != "x" else "+y"))


def _stands(model: Model, points: Points) -> tuple[Floats, Floats]:
    """(3), (3) mean of x and y of the segment that is measured against the laboratory; 0 where there is none."""
    child = next((joint.child for joint in model.joints if joint.parent == LABORATORY), None)
    axes = np.zeros((1, 3, 3)) if child is None else np.reshape(segment_axes(points, model)[child], (-1, 3, 3))
    seen = axes[np.isfinite(axes).all((1, 2))]
    mean = seen.mean(0) if len(seen) else np.zeros((3, 3))
    if model.side == "left":
        right = laboratory(model)[:, 2]
        mean = mean - 2 * np.outer(right, right @ mean)  # as it was before it was mirrored
    return mean[:, 0], mean[:, 1]


def _nearest_axis(v: Floats, usual: str) -> str:
    """The axis nearest to a vector (3), such as "-y"."""
    k = int(np.abs(v).argmax())
    return f"{'-' if v[k] < 0 else '+'}{'xyz'[k]}" if v.any() else usual


def _axes(points: Points, segment: Segment) -> Floats:
    u = _unit(*_vector(points, segment.first))
    v, scale = _vector(points, segment.second)
    w = _unit(v - (u * v).sum(-1, keepdims=True) * u, scale)  # (1)
    letters = segment.first.letter + segment.second.letter
    i, j = ("xyz".index(letter) for letter in letters)
    third = np.cross(u, w) if (j - i) % 3 == 1 else np.cross(w, u)  # (2)
    columns = {i: u, j: w, 3 - i - j: third}
    return np.stack([columns[n] for n in range(3)], -1)


def _vector(points: Points, axis: Axis) -> tuple[Floats, Floats]:
    """The vector of an axis (…, 3), and how long it would be (…) were all its parts perpendicular to each other."""
    ends = [points[b] - points[a] for a, b in zip(axis.points[::2], axis.points[1::2], strict=True)]
    scale = np.prod([np.linalg.norm(v, axis=-1) for v in ends], axis=0)
    return (ends[0] if len(ends) == 1 else np.cross(ends[0], ends[1])), scale


def _unit(v: Floats, scale: Floats) -> Floats:
    """v (…, 3) with length 1; NaN where it is next to nothing beside `scale` (…)."""
    length = np.linalg.norm(v, axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where((length > FLAT * scale)[..., None], v / length[..., None], np.nan)


def propagated(used: Trajectories, model: Model, template: Template | None = None) -> Floats:
    """(J, F, 3, 3) deg² the covariance (4) of the principal angles from that of the markers chosen."""
    total = np.zeros((len(model.joints), used.n_frames, 3, 3))
    points = complete(points_of(used), model, template)
    behind = [markers_behind(model, joint, template) for joint in model.joints]
    for path in used:
        sees = np.array([path.name in markers for markers in behind])
        # A pose does without a marker of its cluster that is missing, so that its error is none; elsewhere J is NaN.
        cov = np.where(np.asarray(np.isnan(path.xyz).any(1))[:, None, None], 0.0, path.cov)
        if np.isnan(cov).any((1, 2)).all():
            total[sees] = np.nan
        elif sees.any():
            J = slopes(points, path.name, model, template)[sees]
            total[sees] += np.einsum("jfam,fmn,jfbn->jfab", J, cov, J)  # (4)
    return total


def markers_behind(model: Model, joint: Joint, template: Template | None = None) -> frozenset[str]:
    """The markers that a joint's angles depend on, through means and clusters."""
    ends = [s for s in model.segments if s.name in (joint.parent, joint.child)]
    points = [p for segment in ends for axis in (segment.first, segment.second) for p in axis.points]
    found: set[str] = set()
    while points:
        point = points.pop()
        bodies = [] if template is None else [body for body in template.clusters if point in body.points]
        if bodies:
            found |= set(bodies[0].markers)
        elif point in model.means:
            points += model.means[point]
        else:
            found.add(point)
    return frozenset(found)


def slopes(points: Points, name: str, model: Model, template: Template | None = None) -> Floats:
    """J (J, F, 3, 3) deg/mm of (4) for one marker, angle by coordinate; points (F, 3) mm with carried ones."""
    moved = points[name] + STEP * np.stack([np.eye(3), -np.eye(3)])[:, :, None, :]  # (2, 3, F, 3)
    spread = {other: np.broadcast_to(x, moved.shape) for other, x in points.items()}
    own = None if template is None else template.of(name)  # other bodies stay where they are
    R = joint_matrices(spread | {name: moved}, model, own)
    deg = np.array([_principal(R[j], model, j) for j in range(len(model.joints))])  # (J, 2, 3, F, 3)
    change = np.remainder(deg[:, 0] - deg[:, 1] + 180, 360) - 180
    return np.moveaxis(change, 1, -1) / (2 * STEP)
