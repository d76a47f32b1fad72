"""The figure of `docs/theory/kinematics.md`: what inverse cosines lose, and skin against bone.

Run: python studies/upper_limb_figure.py FILE.svg
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from recordings import recording
from upper_limb import BONE, bones, cluster_misfit, eating, first_frames, thinned

from kinemark.data import MarkerTrajectory as MarkerPath
from kinemark.data import Trajectories
from kinemark.data.array_types import Floats
from kinemark.io.model_toml import load_model
from kinemark.kinematics import InverseCosines, joint_angles, static_template
from kinemark.synth import arm

BLUE, RED, GREY = "#0072B2", "#D55E00", "#66727F"
WIDE, HIGH, LEFT, TOP = 340.0, 200.0, 60.0, 40.0


def main() -> None:
    if len(sys.argv) != 2:
        raise SystemExit(__doc__)
    Path(sys.argv[1]).write_text(svg(), encoding="utf-8")


def svg() -> str:
    """Both panels beside each other."""
    style = "text{font:13px system-ui,sans-serif;fill:#1C2733}"
    second = LEFT + WIDE + 90
    body = wrist(LEFT) + skin_and_bone(second)
    size = f'viewBox="0 0 {second + WIDE + 20:.0f} 330" width="{second + WIDE + 20:.0f}" height="330"'
    ground = '<rect width="100%" height="100%" fill="white"/>'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size}><style>{style}</style>{ground}{body}</svg>\n'


def wrist(left: float) -> str:
    """Flexion of the wrist while eating, signed and by inverse cosine."""
    subject = arm(duration_s=6.0)
    paths = tuple(MarkerPath.measured(n, x) for n, x in zip(subject.names, subject.xyz, strict=True))
    trial, model = Trajectories(paths, subject.rate), load_model("um2as")
    signed = joint_angles(trial, model=model)["wrist"][:, 0]
    thesis = joint_angles(trial, model=model, method=InverseCosines())["wrist"][:, 0]
    time = np.arange(len(signed)) / subject.rate
    limits = (0.0, 6.0, -18.0, 18.0)
    lines = [curve(time, thesis, left, limits, RED, 4.0, 0.6), curve(time, signed, left, limits, BLUE, 2.0)]
    words = [(BLUE, "signed"), (RED, "inverse cosine (A.35)")]
    return panel(left, limits, "Wrist flexion (+) and extension (−), deg", words, [-10, 0, 10]) + "".join(lines)


def skin_and_bone(left: float) -> str:
    """Elevation of the humerus in the scapula from bone pins and from skin markers, with two predicted SD."""
    skin, bone = bones(recording(BONE))
    model = eating()
    template = static_template(first_frames(skin, bone), model)
    true = joint_angles(thinned(bone), model=replace(model, clusters=()))
    found = joint_angles(thinned(cluster_misfit(skin, model)[0]), model=model, template=template)
    y, s, time = found.deg[0, :, 1], found.sd[0, :, 1], found.time
    limits = (0.0, 7.6, -75.0, 5.0)
    around = np.concatenate([time, time[::-1]]), np.concatenate([y + 2 * s, (y - 2 * s)[::-1]])
    band = f'<polygon points="{points(*around, left, limits)}" fill="{RED}" fill-opacity="0.2"/>'
    lines = curve(time, y, left, limits, RED, 2.0) + curve(time, true.deg[0, :, 1], left, limits, BLUE, 2.0)
    words = [(BLUE, "bone pins"), (RED, "skin markers ± 2 SD of misfit")]
    return panel(left, limits, "Glenohumeral elevation (−), deg", words, [-60, -40, -20, 0]) + band + lines


def points(x: Floats, y: Floats, left: float, limits: tuple[float, float, float, float]) -> str:
    """Places of a curve in the picture."""
    x0, x1, y0, y1 = limits
    u, v = left + (x - x0) / (x1 - x0) * WIDE, TOP + HIGH - (y - y0) / (y1 - y0) * HIGH
    return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(u, v, strict=True))


def curve(
    x: Floats,
    y: Floats,
    left: float,
    limits: tuple[float, float, float, float],
    colour: str,
    width: float,
    dim: float = 1,
) -> str:
    """A line."""
    drawn = points(x[::2], y[::2], left, limits)
    return f'<polyline points="{drawn}" fill="none" stroke="{colour}" stroke-width="{width}" stroke-opacity="{dim}"/>'


def panel(
    left: float, limits: tuple[float, float, float, float], title: str, words: list[tuple[str, str]], ticks: list[int]
) -> str:
    """Frame, ticks, title and legend."""
    x0, x1, y0, y1 = limits
    parts = [f'<text x="{left}" y="22" font-weight="600">{title}</text>']
    for tick in ticks:
        v = TOP + HIGH - (tick - y0) / (y1 - y0) * HIGH
        parts.append(f'<path d="M{left} {v:.1f}h{WIDE}" stroke="#E4E8EC"/>')
        parts.append(f'<text x="{left - 8}" y="{v + 4:.1f}" text-anchor="end">{tick}</text>')
    for second in range(int(x0), int(x1) + 1):
        u = left + (second - x0) / (x1 - x0) * WIDE
        parts.append(f'<text x="{u:.1f}" y="{TOP + HIGH + 18}" text-anchor="middle">{second}</text>')
    parts.append(f'<text x="{left + WIDE}" y="{TOP + HIGH + 36}" text-anchor="end">time, s</text>')
    parts.append(f'<rect x="{left}" y="{TOP}" width="{WIDE}" height="{HIGH}" fill="none" stroke="{GREY}"/>')
    for k, (colour, text) in enumerate(words):
        v = TOP + HIGH + 42 + 20 * k
        parts.append(f'<path d="M{left} {v}h24" stroke="{colour}" stroke-width="3"/>')
        parts.append(f'<text x="{left + 32}" y="{v + 4}">{text}</text>')
    return "".join(parts)


if __name__ == "__main__":
    main()
