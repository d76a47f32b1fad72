"""Scenes with impacts: a ball that bounces, a body that lands, limbs that are struck.

The velocity of what is hit changes at once, and its rate of turning too. Lengths in mm, angles in rad.
"""

import numpy as np

from .bodies import GRAVITY, Body, walker
from .imaging import Optics, images
from .placements import PLACEMENTS, off, rig
from .scene import FRAMES, Made, Scene, allowed

STEPS = 4000  # a second, of the ball's flight


def impact_scene(seed):
    """What a scene of this seed is like, and the scene."""
    rng = np.random.default_rng([seed, 77])
    kind, cameras = str(rng.choice(["ball", "land", "strike"])), int(rng.choice([2, 3, 4, 4, 6, 6, 8]))
    rate = float(rng.choice([25, 50, 100, 100, 150, 200, 250]))
    seconds = min(3.0, FRAMES / rate) if rate >= 50 else 6.0
    optics = Optics(
        noise=float(rng.choice([0.1, 0.2, 0.3])),
        stated=bool(rng.random() < 0.5),
        merge=float(rng.choice([0, 4, 6])),
        marked=bool(rng.random() < 0.6),
        dropout=float(rng.choice([0, 0.01])),
        false=float(rng.choice([0, 0.5])),
    )
    calibration, placement = float(rng.choice([0, 0.1, 0.3])), str(rng.choice(PLACEMENTS))
    t = np.arange(round(seconds * rate)) / rate
    body = with_ball(t, rng) if kind == "ball" else clusters(t, rng, kind, int(rng.choice([2, 4, 6])), 5)
    true = rig(placement, cameras, rng.uniform(3200, 4600), rng)
    detections, image, own = images(true, body, rate, optics, rng)
    markers = len(body.xyz)
    scene = Scene(seed, markers, cameras, placement, kind, rate, seconds, optics, calibration, False)
    sd = allowed(true, body.xyz, own, np.hypot(optics.noise, calibration))
    return Made(scene, off(true, calibration, rng), detections, body.xyz, own.sum(0), sd, true, image)


def with_ball(t, rng):
    """A ball of 4 to 12 markers, in every other scene beside someone who walks."""
    ball = bouncing(t, rng, int(rng.choice([4, 6, 8, 12])))
    if rng.random() >= 0.5:
        return ball
    walking, beside = walker("walk", 15, t, rng, False), np.array([500, 300, 0])
    return Body(
        np.concatenate([ball.begin, walking.begin + beside]),
        np.concatenate([ball.end, walking.end + beside]),
        np.append(ball.radius, walking.radius),
        np.concatenate([ball.xyz, walking.xyz + beside]),
        np.full(len(ball.xyz) + len(walking.xyz), -1),
    )


def bouncing(t, rng, n):
    """A ball with n markers that falls, bounces, and is hit by hand when it hardly does."""
    radius, restitution, height = rng.uniform(60, 120), rng.uniform(0.7, 0.9), rng.uniform(900, 1800)
    fine = np.arange(0, t[-1] + 0.001, 1 / STEPS)
    at, turns = np.empty((len(fine), 3)), np.empty((len(fine), 3, 3))
    speed, spin, drift, place, R = 0.0, rng.normal(0, 4, 3), rng.normal(0, 250, 2), rng.uniform(-200, 200, 2), np.eye(3)
    for k in range(len(fine)):
        at[k], turns[k] = [*place, height], R
        speed -= GRAVITY / STEPS
        height, place, R = height + speed / STEPS, place + drift / STEPS, rotations(spin / STEPS) @ R
        if height < radius and speed < 0:
            speed = 3500.0 if abs(speed) < 600 else -restitution * speed
            spin, drift, height = spin + rng.normal(0, 4, 3), rng.normal(0, 300, 2), radius
    k = np.minimum((t * STEPS).round().astype(int), len(fine) - 1)
    skin = 1.05 * radius * apart(n, 50 / radius, lambda: direction(rng))
    xyz = at[k] + np.einsum("fij,mj->mfi", turns[k], skin)
    up = np.array([0.0, 0.0, 1.0])
    return Body((at[k] - up)[None], (at[k] + up)[None], np.array([0.97 * radius]), xyz, np.full(n, -1))


def clusters(t, rng, kind, n, each):
    """n rigid clusters of markers that move smoothly, and some or all of which are hit at once, now and then."""
    times = np.sort(rng.uniform(0.15, t[-1] - 0.1, max(int(t[-1] / 0.6), 1)))
    middle = rng.uniform(-250, 250, (n, 3)) * [1.6, 1, 1] + [0, 0, 700]
    xyz, begin, end, up = [], [], [], np.array([0.0, 0.0, 30.0])
    for c in range(n):
        f, phase = rng.uniform(0.4, 1.4, (3, 3)), rng.uniform(0, 6.28, (3, 3))
        size = rng.uniform(60, 220, (3, 3)) / (0.5 + f)
        x = middle[c] + (size * np.sin(2 * np.pi * f * t[:, None, None] + phase)).sum(1)
        size, f, phase = rng.uniform(0.1, 0.5, (2, 3)), rng.uniform(0.4, 1.2, (2, 3)), rng.uniform(0, 6, (2, 3))
        w = (size * np.sin(2 * np.pi * f * t[:, None, None] + phase)).sum(1)
        for time in times:
            jump = jump_of(kind, rng)
            if jump is None:
                continue
            decay, s = rng.uniform(0.05, 0.12), np.maximum(t - time, 0)
            fast = decay * (1 - np.exp(-s / decay))  # the velocity jumps and decays, and the place comes back slowly
            x = x + jump * (fast - decay * (1 - np.exp(-((s / 0.4) ** 2))))[:, None]
            w = w + rng.normal(0, 5, 3) * fast[:, None]
        plate = apart(each, 45, lambda: rng.uniform(-75, 75, 3))
        xyz.append(x + np.einsum("fij,mj->mfi", rotations(w), plate))
        begin.append(x - up)
        end.append(x + up)
    return Body(np.array(begin), np.array(end), np.full(n, 30.0), np.concatenate(xyz), np.full(n * each, -1))


def jump_of(kind, rng):
    """(3) mm/s by which an impact changes a cluster's velocity, None where it is not hit."""
    if kind == "land":
        return np.array([rng.normal(0, 300), rng.normal(0, 300), 3000.0]) * rng.uniform(0.6, 1.1)
    return direction(rng) * rng.uniform(1200, 3500) if rng.random() < 0.5 else None


def direction(rng):
    """(3) of length 1, any."""
    d = rng.normal(size=3)
    return d / np.linalg.norm(d)


def apart(n, least, drawn):
    """(n, 3) places that are `least` from each other."""
    found = []
    while len(found) < n:
        place = drawn()
        if all(np.linalg.norm(place - other) > least for other in found):
            found.append(place)
    return np.array(found)


def rotations(w):
    """(…, 3, 3) by the vectors w (…, 3)."""
    angle = np.linalg.norm(w, axis=-1, keepdims=True)
    x, y, z = np.moveaxis(w / np.maximum(angle, 1e-12), -1, 0)
    zero = np.zeros_like(x)
    K = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], -1).reshape(*x.shape, 3, 3)
    angle = angle[..., None]
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * (K @ K)
