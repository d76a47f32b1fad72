"""Stick bodies in motion, the markers on them, and the capsules that hide markers.

A body is a tree of segments; the turn of each about the axis across the body is a constant and two harmonics of the
stride, which gives walking, running and sprinting; jumps add flights under gravity. Lengths in mm, angles in rad.
"""

from typing import NamedTuple

import numpy as np

GRAVITY = 9810.0
SEGMENTS = (  # name, parent, length, radius, side (−1 right, 1 left)
    ("trunk", None, 520, 125, 0),
    ("head", "trunk", 260, 90, 0),
    ("thigh_l", "pelvis", 430, 70, 1),
    ("thigh_r", "pelvis", 430, 70, -1),
    ("shank_l", "thigh_l", 420, 50, 1),
    ("shank_r", "thigh_r", 420, 50, -1),
    ("foot_l", "shank_l", 230, 35, 1),
    ("foot_r", "shank_r", 230, 35, -1),
    ("upper_l", "trunk", 300, 45, 1),
    ("upper_r", "trunk", 300, 45, -1),
    ("fore_l", "upper_l", 320, 35, 1),
    ("fore_r", "upper_r", 320, 35, -1),
)


class Gait(NamedTuple):
    """speed mm/s; stride Hz; swings of hip, knee, shoulder and elbow, rad; bounce mm; lean rad."""

    speed: float
    stride: float
    hip: float
    knee: float
    shoulder: float
    elbow: float
    bounce: float
    lean: float


GAITS = {
    "walk": Gait(1250, 0.95, 0.42, 0.95, 0.35, 0.3, 22, 0.05),
    "run": Gait(3500, 1.4, 0.65, 1.7, 0.7, 1.4, 45, 0.15),
    "sprint": Gait(7000, 2.1, 0.95, 2.1, 1.0, 1.5, 40, 0.2),
    "jump": Gait(0, 0.7, 0.5, 1.1, 1.2, 0.3, 0, 0.1),
    "crawl": Gait(450, 0.6, 0.35, 0.3, 0.35, 0.2, 10, 1.45),
    "arms": Gait(0, 1.0, 0.02, 0.03, 1.3, 1.2, 2, 0.0),
}


class Body(NamedTuple):
    """Capsules: begin, end (S, F, 3) mm, radius (S) mm; markers xyz (M, F, 3) mm and the capsule (M) that each is on,
    −1 for none."""

    begin: np.ndarray
    end: np.ndarray
    radius: np.ndarray
    xyz: np.ndarray
    own: np.ndarray


def turn(pitch, yaw):
    """(F, 3, 3): a pitch about the axis across, then a yaw about the vertical."""
    c, s, zero, one = np.cos(pitch), np.sin(pitch), np.zeros_like(pitch), np.ones_like(pitch)
    across = np.moveaxis(np.array([[c, zero, s], [zero, one, zero], [-s, zero, c]]), -1, 0)
    c, s = np.cos(yaw), np.sin(yaw)
    upright = np.moveaxis(np.array([[c, -s, zero], [s, c, zero], [zero, zero, one]]), -1, 0)
    return upright @ across


def pitches(gait, phase, rng):
    """Pitch (F) of each segment against the vertical, forwards positive for what hangs down."""
    own = {}
    own["trunk"] = gait.lean + 0.03 * np.sin(2 * phase + 1)
    own["head"] = 0.6 * gait.lean + 0.05 * np.sin(2 * phase)
    for side, late in (("l", 0.0), ("r", np.pi)):
        p = phase + late
        base = 1.35 if gait.lean > 1 else 0.0  # hands and knees: thighs and arms hang under a level trunk
        hip = gait.hip * np.sin(p) + 0.25 * gait.hip
        knee = gait.knee * np.clip(0.5 - 0.5 * np.cos(p + 0.6), 0, 1) ** 2 + 0.1 + base
        own[f"thigh_{side}"] = hip
        own[f"shank_{side}"] = hip - knee
        own[f"foot_{side}"] = hip - 0.8 * knee + 1.5
        swing = -gait.shoulder * np.sin(p + rng.uniform(-0.2, 0.2))
        own[f"upper_{side}"] = swing
        own[f"fore_{side}"] = swing + 0.25 + gait.elbow * (0.7 + 0.3 * np.sin(p + 1.5))
    return own


def root(kind, gait, t, rng, treadmill):
    """(F, 3) the pelvis, and the heading (F)."""
    heading = rng.uniform(0, 2 * np.pi) + 0.15 * np.sin(0.8 * t + rng.uniform(0, 6))
    along = np.zeros_like(t) if treadmill else gait.speed * (t - t.mean())
    xyz = np.stack([along, 25 * np.sin(2 * np.pi * gait.stride * t), np.full_like(t, 930.0)], 1)
    xyz[:, 2] += gait.bounce * np.sin(4 * np.pi * gait.stride * t)
    if kind == "crawl":
        xyz[:, 2] -= 430
    if kind == "jump":
        xyz[:, 2] += flights(t, gait.stride)
    mean = heading.mean()
    xyz[:, :2] = xyz[:, :2] @ np.array([[np.cos(mean), np.sin(mean)], [-np.sin(mean), np.cos(mean)]])
    xyz[:, :2] += rng.uniform(-250, 250, 2)
    return xyz, heading


def flights(t, per_second):
    """Heights (F): a flight under gravity in each cycle, and a crouch between, smooth where they meet."""
    u = (t * per_second) % 1.0 / per_second
    air = 0.45
    rise = GRAVITY * air / 2
    ground = 1 / per_second - air
    w = np.pi / ground
    crouch = -rise / w * np.sin(w * (u - air))
    return np.where(u < air, rise * u - GRAVITY * u * u / 2, crouch)


def posed(kind, t, rng, treadmill):
    """Ends (S, F, 3) of the capsules, their radii and the axes (S, F, 3, 3) of each."""
    gait = GAITS[kind]._replace(stride=GAITS[kind].stride * rng.uniform(0.9, 1.1))
    pelvis, heading = root(kind, gait, t, rng, treadmill)
    pitch = pitches(gait, 2 * np.pi * gait.stride * t + rng.uniform(0, 6), rng)
    left = np.stack([-np.sin(heading), np.cos(heading), 0 * t], 1)
    place, begin, end, axes = {}, [], [], []
    for name, parent, length, _, side in SEGMENTS:
        up = parent in (None, "trunk") and side == 0
        R = turn(pitch[name] if up else -pitch[name], heading)
        if parent is None:
            start = pelvis
        elif parent == "pelvis":
            start = pelvis + 95 * side * left
        elif side and parent == "trunk":
            start = place["trunk"] + 190 * side * left
        else:
            start = place[parent]
        place[name] = start + length * (1 if up else -1) * R[:, :, 2]
        begin.append(start)
        end.append(place[name])
        axes.append(R)
    return np.array(begin), np.array(end), np.array([row[3] for row in SEGMENTS], float), np.array(axes)


def walker(kind, n, t, rng, treadmill):
    """A body with n markers on its skin."""
    begin, end, radius, axes = posed(kind, t, rng, treadmill)
    own = np.array([*range(len(radius)), *rng.choice(len(radius), max(n - len(radius), 0), p=radius / radius.sum())])[
        :n
    ]
    xyz = []
    for s in own:
        for _ in range(200):
            along, angle = rng.uniform(0.08, 0.95), rng.uniform(0, 2 * np.pi)
            place = begin[s] + along * (end[s] - begin[s])
            place = place + (radius[s] + 8) * (axes[s] @ np.array([np.cos(angle), np.sin(angle), 0.0]))
            if all(np.linalg.norm(place[0] - other[0]) > 45 for other in xyz):
                break
        xyz.append(place + rng.uniform(0, 3) * np.sin(2 * np.pi * t * rng.uniform(3, 6) + local_phase(rng))[:, None])
    return Body(begin, end, radius, np.array(xyz), own)


def standing(n, t, rng):
    """Who stands still, with n markers: a body that sways about its feet by up to 10 mm at the head."""
    body = walker("arms", n, np.full_like(t, rng.uniform(0, 1)), rng, True)
    lean = rng.uniform(2e-3, 6e-3, (2, 1)) * np.sin(2 * np.pi * rng.uniform(0.1, 0.4, (2, 1)) * t + local_phase(rng))
    begin, end, xyz = (at + at[..., 2:] * np.pad(lean, ((0, 1), (0, 0))).T for at in (body.begin, body.end, body.xyz))
    return body._replace(begin=begin, end=end, xyz=xyz)


def local_phase(rng):
    """A phase of the skin's wobble, rad."""
    return rng.uniform(0, 2 * np.pi)


def swarm(n, t, rng):
    """n points that wander smoothly, each by itself, and hide nothing."""
    middle = rng.uniform([-900, -900, 300], [900, 900, 1700], (n, 3))
    f, phase = rng.uniform(0.1, 1.6, (n, 4, 3)), rng.uniform(0, 2 * np.pi, (n, 4, 3))
    size = rng.uniform(20, 220, (n, 4, 3)) / (0.5 + f)
    xyz = middle[:, None] + (size[:, None] * np.sin(2 * np.pi * f[:, None] * t[:, None, None] + phase[:, None])).sum(2)
    none = np.zeros((0, len(t), 3))
    return Body(none, none, np.zeros(0), xyz, np.full(n, -1))
