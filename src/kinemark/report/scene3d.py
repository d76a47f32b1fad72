"""The laboratory in 3D: cameras, control volume, floor and the paths of the markers.

A camera is drawn as the pyramid of its view. The corner (u, v) of its image lies at the depth d at

    X = centre + d Rᵀ K⁻¹ (u, v, 1)                                          (1)

without the lens's distortion, which would bend the edges.
"""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go

from ..data import Camera, Rig, Tracks, Trajectories
from ..data.array_types import Floats
from ..findings.cameras import upwards
from ..findings.markers import in_view, positions, present
from .theme import FAINT, INK, figure, hue, label
from .thin import short

POINTS = 300
"""Most samples drawn of one path; chosen."""
AFAR = 10.0
"""Widths of all that is drawn; an origin of the world farther off than that is not drawn with it; chosen."""
LOOSE = 2000
"""Most points drawn of those in no track; chosen."""


def scene(rig: Rig, tracks: Tracks, trajectories: Trajectories) -> go.Figure:
    """Cameras with names and viewing directions, control volume, floor, paths, loose points, markers of one frame."""
    xyz = positions(trajectories)
    seen = xyz[present(trajectories)]
    extent = extent_of(seen, rig.centres, rig.volume[np.isfinite(rig.volume).all(1)])
    fig = figure(680, margin={"l": 0, "r": 0, "t": 36, "b": 0}, showlegend=bool(len(seen)), legend={"y": 1})
    up = upwards(rig)
    draw_floor(fig, extent, up)
    if np.isfinite(rig.volume).all():
        draw_box(fig, rig.volume)
    target = np.median(seen, axis=0) if len(seen) else extent.mean(0)
    for c, camera in enumerate(rig):
        draw_camera(fig, camera, hue(c), target)
    _paths(fig, trajectories)
    _loose_points(fig, tracks)
    if len(seen):
        _markers(fig, trajectories)
    axes = {f"{a}axis": {"title": f"{a} (mm)", "backgroundcolor": "#F7F9FA", "gridcolor": "#DDE3E8"} for a in "xyz"}
    look = {
        "eye": viewpoint(extent, up),
        "up": dict(zip("xyz", np.eye(3)[up].tolist(), strict=True)),
        "center": dict(zip("xyz", (-0.1 * np.eye(3)[up]).tolist(), strict=True)),
        "projection": {"type": "perspective"},
    }
    drag = "turntable" if up == 2 else "orbit"  # Plotly's turntable turns about z alone
    wide = {"domain": {"x": [0, 0.87 if len(seen) else 1]}}
    return fig.update_layout(scene={**axes, **wide, "aspectmode": "data", "camera": look, "dragmode": drag})


def corners(camera: Camera, depth: float) -> Floats:
    """(4, 3) mm the corners of its image at that depth; an image of unknown size is centred on the principal point."""
    width, height = camera.size if (camera.size > 0).all() else 2 * np.abs(camera.K[:2, 2])
    if not (width > 1 and height > 1):
        width, height = 2 * np.abs(camera.K[:2, 2]) + np.abs(np.diag(camera.K)[:2])
    uv = np.array([[0, 0, 1], [width, 0, 1], [width, height, 1], [0, height, 1]], float) - [0.5, 0.5, 0]
    return camera.centre + depth * np.linalg.solve(camera.K, uv.T).T @ camera.R  # (1)


def extent_of(*places: Floats) -> Floats:
    """(2, 3) mm least and greatest corner of places (N, 3) mm, and of the world's origin unless that is far off."""
    everything = np.concatenate([*places, np.zeros((0, 3))])
    if not len(everything):
        return np.zeros((2, 3))
    extent = np.array([everything.min(0), everything.max(0)])
    beside = np.maximum(np.maximum(extent[0], -extent[1]), 0.0)  # from the box to the origin
    near = np.linalg.norm(beside) <= AFAR * np.linalg.norm(extent[1] - extent[0])
    return np.array([np.minimum(extent[0], 0.0), np.maximum(extent[1], 0.0)]) if near else extent


def viewpoint(extent: Floats, up: int) -> dict[str, float]:
    """From where all of `extent` is seen; Plotly measures in the geometric mean of the three widths."""
    width = np.maximum(extent[1] - extent[0], 1.0)
    away = 1.2 * float(np.linalg.norm(width)) / float(np.prod(width)) ** (1 / 3)
    return dict(zip("xyz", away * np.roll([0.55, -0.7, 0.45], up - 2), strict=True))


def draw_floor(fig: go.Figure, extent: Floats, up: int) -> None:
    """The level plane through the world's origin, or below all that is drawn where the origin is far off."""
    (a0, b0, c0), (a1, b1, c1) = np.roll(extent, 2 - up, axis=1)
    level = 0.0 if c0 <= 0 <= c1 else c0
    corner = np.array([[a0, b0, level], [a1, b0, level], [a1, b1, level], [a0, b1, level]])
    x, y, z = np.roll(corner, up - 2, axis=1).T
    fig.add_mesh3d(
        x=x, y=y, z=z, i=[0, 0], j=[1, 2], k=[2, 3],
        color="#B8C2CC", opacity=0.25, hoverinfo="skip", showlegend=False,
    )  # fmt: skip


def draw_box(fig: go.Figure, volume: Floats) -> None:
    """Its twelve edges in one line with breaks."""
    corner = np.array([[volume[i, 0], volume[j, 1], volume[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    edges = [(a, b) for a in range(8) for b in range(a + 1, 8) if (a ^ b) in (1, 2, 4)]
    line = np.concatenate([[corner[a], corner[b], [np.nan] * 3] for a, b in edges])
    draw_line(fig, line, FAINT, name="control volume", width=3, dash="dash", showlegend=True, hoverinfo="name")


def draw_camera(fig: go.Figure, camera: Camera, colour: str, target: Floats) -> None:
    """Pyramid, name and the line along its axis to beside the subject."""
    distance = float(np.linalg.norm(target - camera.centre)) or 1000.0
    ring = corners(camera, 0.15 * distance)
    spokes = np.concatenate([[camera.centre, corner, [np.nan] * 3] for corner in ring])
    outline = np.concatenate([ring, ring[:1], [[np.nan] * 3], spokes])
    draw_line(fig, outline, colour, width=4, hoverinfo="skip")
    axis = camera.R[2] * max(0.3 * distance, float(camera.R[2] @ (target - camera.centre)))
    draw_line(fig, np.array([camera.centre, camera.centre + axis]), colour, width=2, opacity=0.45, hoverinfo="skip")
    x, y, z = camera.centre
    fig.add_scatter3d(
        x=[x], y=[y], z=[z], mode="markers+text", text=[f"<b>{label(camera.name)}</b>"], textposition="top center",
        textfont={"color": colour, "size": 13}, marker={"color": colour, "size": 4}, showlegend=False,
        hovertemplate="%{text}<br>x %{x:.0f}, y %{y:.0f}, z %{z:.0f} mm<extra></extra>",
    )  # fmt: skip


def _paths(fig: go.Figure, trajectories: Trajectories) -> None:
    step = max(1, -(-trajectories.n_frames // POINTS))
    for m, path in enumerate(trajectories):
        draw_line(
            fig, path.xyz[::step], hue(m), name=label(path.name), width=3, showlegend=True,
            legendgroup=str(m), text=[f"{t:.2f} s" for t in trajectories.time[::step]],
            hovertemplate="%{text}<br>x %{x:.0f}, y %{y:.0f}, z %{z:.0f} mm",
        )  # fmt: skip


def _loose_points(fig: go.Figure, tracks: Tracks) -> None:
    """Points in no track, faint: ghosts and reflections stand where they arise; hidden until asked for."""
    xyz = tracks.cloud.xyz[(tracks.id < 0) & np.isfinite(tracks.cloud.xyz).all(axis=1)]
    if not len(xyz):
        return
    x, y, z = short(xyz[:: -(-len(xyz) // LOOSE)].T)
    fig.add_scatter3d(
        x=x, y=y, z=z, mode="markers", name="points in no track", marker={"size": 2, "color": FAINT, "opacity": 0.6},
        visible="legendonly", hovertemplate="x %{x:.0f}, y %{y:.0f}, z %{z:.0f} mm",
    )  # fmt: skip


def _markers(fig: go.Figure, trajectories: Trajectories) -> None:
    """Dots at the fullest frame nearest to the middle of the time in view."""
    xyz, middle = positions(trajectories), sum(in_view(trajectories)) / 2
    complete = present(trajectories).sum(axis=0)
    fullest = np.flatnonzero(complete == complete.max())
    f = int(fullest[np.abs(fullest - middle).argmin()])
    x, y, z = xyz[:, f].T
    fig.add_scatter3d(
        x=x, y=y, z=z, mode="markers", name=f"markers at {trajectories.time[f]:.2f} s",
        marker={"size": 4, "color": INK}, text=[label(name) for name in trajectories.names],
        hovertemplate="%{text}<br>x %{x:.0f}, y %{y:.0f}, z %{z:.0f} mm<extra></extra>",
    )  # fmt: skip


def draw_line(fig: go.Figure, xyz: Floats, colour: str, *, width: float, dash: str = "solid", **more: object) -> None:
    """A line through points (n, 3) mm, broken where they are NaN."""
    x, y, z = short(xyz.T)
    style = {"color": colour, "width": width, "dash": dash}
    fig.add_scatter3d(x=x, y=y, z=z, mode="lines", line=style, **{"showlegend": False, **more})
