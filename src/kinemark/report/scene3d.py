"""The laboratory in 3D: cameras, control volume, floor and the paths of the markers.

A camera is drawn as the pyramid of its view. The corner (u, v) of its image lies at the depth d at

    X = centre + d Rᵀ K⁻¹ (u, v, 1)                                          (1)

without the lens's distortion, which would bend the edges.

The script that plays the markers gets their places as whole numbers q of a step s about an origin o, so that a
coordinate takes two bytes:

    x = o + s q,    s ≥ (greatest distance from o) / 32000                  (2)
"""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..data import Camera, Rig, Tracks, Trajectories
from ..data.array_types import Floats
from ..findings.cameras import upwards
from ..findings.markers import in_view, positions, present
from .drawing import Figure
from .theme import FAINT, INK, figure, hue, labels, shortened
from .thin import fullest, short

POINTS = 300
"""Most samples drawn of one path; chosen."""
ALL_POINTS, OTHERS = 4500, 1500
"""Most samples drawn of all paths that have a name, and of all others; chosen (see benchmarks/pages.py)."""
CLOSEST = 300.0
"""Least width of what is looked at, mm, so that a single point is not filled up with; chosen."""
MARGIN = 0.03  # of the width of all that is drawn, between it and the ends of the axes; chosen
SUBJECT = (0.02, 0.98)
"""Quantiles of the samples between which the subject is taken to be, so that no ghost makes it small; chosen."""
AFAR = 10.0
"""Widths of all that is drawn; an origin of the world farther off than that is not drawn with it; chosen."""
LOOSE = 1000
"""Most points drawn of those in no track; chosen (see benchmarks/pages.py)."""
HOVER = "x %{x:.0f}, y %{y:.0f}, z %{z:.0f} mm"


def scene(rig: Rig, tracks: Tracks, trajectories: Trajectories) -> Figure:
    """Cameras with names and viewing directions, control volume, floor, paths, loose points, markers that move.

    It opens on the subject. What plays is in `layout.meta`, as `motion` describes it.
    """
    xyz = positions(trajectories)
    seen = xyz[present(trajectories)]
    extent = extent_of(seen, rig.centres, rig.volume[np.isfinite(rig.volume).all(1)])
    fig = figure(680, margin={"l": 0, "r": 0, "t": 36, "b": 0}, showlegend=bool(len(seen)), legend={"y": 1})
    up = upwards(rig)
    draw_floor(fig, extent, up)
    if np.isfinite(rig.volume).all():
        draw_box(fig, rig.volume)
    target = np.median(seen, axis=0) if len(seen) else extent.mean(0)
    for c, (camera, name) in enumerate(zip(rig, labels(rig.names), strict=True)):
        draw_camera(fig, camera, hue(c), target, name=name)
    _paths(fig, trajectories)
    _loose_points(fig, tracks)
    if len(seen):
        _markers(fig, trajectories)
        fig.arrange(meta={"motion": motion(trajectories, up, trace=len(fig.data) - 1)})
    subject = np.quantile(seen, SUBJECT, axis=0) if len(seen) else extent
    return stand_upright(fig, up, subject)


def stand_upright(fig: Figure, up: int, subject: Floats, *, called: str = "subject") -> Figure:
    """A scene with its vertical axis as Plotly's z, the only one that it turns about with the floor level.

    The other axes keep their order, so that nothing is mirrored. Places are given to Plotly's camera in its own units:
    of a box with the proportions of all that is drawn, about its middle, whose sides have a geometric mean of one.

    Args:
        fig: with all its traces, in the world's axes.
        up: which axis points upwards.
        subject: (2, 3) mm, least and greatest corner of what is looked at first; called: its name.
    """
    order = [(up + 1) % 3, (up + 2) % 3, up]
    for trace in fig.data:
        values = [trace["x"], trace["y"], trace["z"]]
        trace.update(zip("xyz", (values[axis] for axis in order), strict=True))
        if "hovertemplate" in trace:
            trace["hovertemplate"] = trace["hovertemplate"].replace(HOVER, _hover(order))
    places = np.array([[_ends(trace[axis]) for axis in "xyz"] for trace in fig.data])
    low, high = places[..., 0].min(0), places[..., 1].max(0)
    width = np.maximum(high - low, 1.0)
    low, high, subject = low - MARGIN * width, high + MARGIN * width, subject[:, order]
    unit = float(np.prod(high - low)) ** (1 / 3)
    look = {"background": "#F7F9FA", "grid": "#DDE3E8"}
    axes = {
        f"{plotted}axis": {
            "title": {"text": f"{'xyz'[axis]} (mm)"},
            "range": [low[k], high[k]],
            "backgroundcolor": look["background"],
            "gridcolor": look["grid"],
        }
        for k, (plotted, axis) in enumerate(zip("xyz", order, strict=True))
    }
    ratio = dict(zip("xyz", (high - low) / unit, strict=True))
    near = view_of(subject, (low + high) / 2, unit)
    far = view_of(np.array([low, high]), (low + high) / 2, unit)
    scene = {**axes, "aspectmode": "manual", "aspectratio": ratio, "camera": near, "dragmode": "turntable"}
    buttons = [
        {"label": name, "method": "relayout", "args": [{"scene.camera": camera}]}
        for name, camera in ((called, near), ("laboratory", far))
    ]
    place = {"x": 0, "y": 1.0, "xanchor": "left", "yanchor": "bottom", "pad": {"t": 0, "b": 4}}
    menu = {"type": "buttons", "direction": "right", "showactive": False, "buttons": buttons, **place}
    return fig.arrange(scene=scene, updatemenus=[menu])


def view_of(box: Floats, middle: Floats, unit: float) -> dict[str, Any]:
    """Plotly's camera from where all of a box (2, 3) mm is seen; its unit is `unit` mm, its origin `middle` mm."""
    centre = (box.mean(0) - middle) / unit
    away = 1.2 * max(float(np.linalg.norm(box[1] - box[0])), CLOSEST) / unit
    eye = centre + away * np.array([0.55, -0.7, 0.45])
    places = {"eye": eye, "center": centre, "up": np.array([0.0, 0.0, 1.0])}
    return {name: dict(zip("xyz", place.tolist(), strict=True)) for name, place in places.items()} | {
        "projection": {"type": "perspective"}
    }


def _ends(values: Any) -> tuple[float, float]:
    """Least and greatest of the values that there are; 0 where there are none."""
    known = np.asarray(values, np.float64)
    known = known[np.isfinite(known)]
    return (float(known.min()), float(known.max())) if len(known) else (0.0, 0.0)


def _hover(order: Sequence[int]) -> str:
    """`HOVER` of a scene whose axes were put into this order; it names the world's."""
    plotted = ["xyz"[order.index(axis)] for axis in range(3)]
    return ", ".join(f"{name} %{{{place}:.0f}}" for name, place in zip("xyz", plotted, strict=True)) + " mm"


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


def draw_floor(fig: Figure, extent: Floats, up: int) -> None:
    """The level plane through the world's origin, or below all that is drawn where the origin is far off."""
    (a0, b0, c0), (a1, b1, c1) = np.roll(extent, 2 - up, axis=1)
    level = 0.0 if c0 <= 0 <= c1 else c0
    corner = np.array([[a0, b0, level], [a1, b0, level], [a1, b1, level], [a0, b1, level]])
    x, y, z = np.roll(corner, up - 2, axis=1).T
    fig.add(
        "mesh3d", x=x, y=y, z=z, i=[0, 0], j=[1, 2], k=[2, 3],
        color="#B8C2CC", opacity=0.25, hoverinfo="skip", showlegend=False,
    )  # fmt: skip


def draw_box(fig: Figure, volume: Floats) -> None:
    """Its twelve edges in one line with breaks."""
    corner = np.array([[volume[i, 0], volume[j, 1], volume[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    edges = [(a, b) for a in range(8) for b in range(a + 1, 8) if (a ^ b) in (1, 2, 4)]
    line = np.concatenate([[corner[a], corner[b], [np.nan] * 3] for a, b in edges])
    draw_line(fig, line, FAINT, name="control volume", width=3, dash="dash", showlegend=True, hoverinfo="name")


def draw_camera(fig: Figure, camera: Camera, colour: str, target: Floats, *, name: str) -> None:
    """Pyramid, name and the line along its axis to beside the subject."""
    distance = float(np.linalg.norm(target - camera.centre)) or 1000.0
    ring = corners(camera, 0.15 * distance)
    spokes = np.concatenate([[camera.centre, corner, [np.nan] * 3] for corner in ring])
    outline = np.concatenate([ring, ring[:1], [[np.nan] * 3], spokes])
    draw_line(fig, outline, colour, width=4, hoverinfo="skip")
    axis = camera.R[2] * max(0.3 * distance, float(camera.R[2] @ (target - camera.centre)))
    draw_line(fig, np.array([camera.centre, camera.centre + axis]), colour, width=2, opacity=0.45, hoverinfo="skip")
    x, y, z = camera.centre
    fig.add(
        "scatter3d", x=[x], y=[y], z=[z], mode="markers+text", text=[f"<b>{name}</b>"], textposition="top center",
        textfont={"color": colour, "size": 13}, marker={"color": colour, "size": 4}, showlegend=False,
        hovertemplate=f"%{{text}}<br>{HOVER}<extra></extra>",
    )  # fmt: skip


def _paths(fig: Figure, trajectories: Trajectories) -> None:
    """A line a marker, of the fullest ones; the others together, in grey."""
    some, others = fullest(trajectories)
    names = labels(some.names)
    step = max(1, -(-some.n_frames * max(len(some), 1) // ALL_POINTS), -(-some.n_frames // POINTS))
    time = some.time[::step].astype(np.float32)
    for m, path in enumerate(some):
        draw_line(
            fig, path.xyz[::step], hue(m), name=names[m], width=3, showlegend=True, legendgroup=str(m),
            customdata=time, hovertemplate=f"%{{customdata:.2f}} s<br>{HOVER}",
        )  # fmt: skip
    if len(others):
        draw_line(
            fig, _joined(others), FAINT, name=f"{len(others)} others", width=2, showlegend=True, opacity=0.6,
            hoverinfo="skip",
        )  # fmt: skip


def _joined(trajectories: Trajectories) -> Floats:
    """(n, 3) mm all paths as one line with breaks, of so many samples that all are drawn by `OTHERS` in all."""
    seen = [path.xyz[np.isfinite(path.xyz).all(1)] for path in trajectories]
    seen = [xyz for xyz in seen if len(xyz)][:OTHERS]
    step = max(1, -(-sum(map(len, seen)) // OTHERS))
    broken = [np.concatenate([xyz[::step], np.full((1, 3), np.nan)]) for xyz in seen]
    return np.concatenate(broken) if broken else np.zeros((0, 3))


def _loose_points(fig: Figure, tracks: Tracks) -> None:
    """Points in no track, faint: ghosts and reflections stand where they arise; hidden until asked for."""
    xyz = tracks.cloud.xyz[(tracks.id < 0) & np.isfinite(tracks.cloud.xyz).all(axis=1)]
    if not len(xyz):
        return
    x, y, z = short(xyz[:: -(-len(xyz) // LOOSE)].T)
    fig.add(
        "scatter3d",
        x=x, y=y, z=z, mode="markers", name="points in no track", marker={"size": 2, "color": FAINT, "opacity": 0.6},
        visible="legendonly", hovertemplate=HOVER,
    )  # fmt: skip


def _markers(fig: Figure, trajectories: Trajectories) -> None:
    """Dots at the frame that is drawn before anything plays."""
    f = _drawn_frame(trajectories)
    rows = np.flatnonzero(present(trajectories)[:, f])
    x, y, z = positions(trajectories)[rows, f].T
    fig.add(
        "scatter3d", x=x, y=y, z=z, mode="markers", name=f"markers at {trajectories.time[f]:.2f} s",
        marker={"size": 4, "color": INK}, text=labels(trajectories.names[m] for m in rows),
        hovertemplate=f"%{{text}}<br>{HOVER}<extra></extra>",
    )  # fmt: skip


def _drawn_frame(trajectories: Trajectories) -> int:
    """The fullest frame nearest to the middle of the time in view."""
    middle, complete = sum(in_view(trajectories)) / 2, present(trajectories).sum(axis=0)
    full = np.flatnonzero(complete == complete.max())
    return int(full[np.abs(full - middle).argmin()])


def draw_line(fig: Figure, xyz: Floats, colour: str, *, width: float, dash: str = "solid", **more: object) -> None:
    """A line through points (n, 3) mm, broken where they are NaN."""
    x, y, z = short(xyz.T)
    style = {"color": colour, "width": width, "dash": dash}
    fig.add("scatter3d", x=x, y=y, z=z, mode="lines", line=style, **{"showlegend": False, **more})


MOST_PLACES = 6000
"""Of all markers in all frames that are played; chosen (see benchmarks/pages.py)."""
MOST_FRAMES = 400  # that are played; chosen
FINEST = 0.1  # mm; step of a coordinate; chosen
GREATEST = 32000
"""Of the whole numbers in (2), without unit; a little less than sixteen bits hold, by definition."""


def motion(trajectories: Trajectories, up: int, *, trace: int) -> dict[str, Any]:
    """What the script plays, coordinates in the order of `scene3d.stand_upright`.

    Args:
        trajectories: with at least one sample.
        up: which axis of the world points upwards.
        trace: index of the trace that moves.
    """
    order = [(up + 1) % 3, (up + 2) % 3, up]
    xyz, there = positions(trajectories)[..., order], present(trajectories)
    frames = _played_frames(there)
    frame, marker = np.nonzero(there[:, frames].T)
    places = xyz[marker, frames[frame]]
    origin = (places.min(0) + places.max(0)) / 2
    step = max(FINEST, float(np.abs(places - origin).max()) / GREATEST)  # (2)
    return {
        "trace": trace,
        "names": shortened(trajectories.names),
        "time": [round(float(t), 3) for t in trajectories.time[frames]],
        "drawn": int(np.abs(frames - _drawn_frame(trajectories)).argmin()),
        "starts": np.searchsorted(frame, np.arange(len(frames) + 1)).tolist(),
        "marker": _packed(marker, "<u2"),
        "xyz": _packed(np.rint((places - origin) / step), "<i2"),
        "origin": origin.round(1).tolist(),
        "step": step,
    }


def _played_frames(there: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Frames at equal steps from the first to the last in which any marker (M, F) is there, as many as may play."""
    seen = np.flatnonzero(there.any(0))
    first, last = int(seen[0]), int(seen[-1]) + 1
    by = max(1, -(-(last - first) // MOST_FRAMES))
    by = max(by, -(-int(there[:, first:last].sum()) // MOST_PLACES))
    return np.arange(first, last, by)


def _packed(values: NDArray[Any], kind: str) -> str:
    return b64encode(np.ascontiguousarray(values, kind).tobytes()).decode()
