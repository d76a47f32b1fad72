"""A walk there and back in one trial: a straight walk, turned by 180 deg on its way."""

import numpy as np


def bent(points, pelvis, *, rate, turn_s, heading_deg=0.0, on_the_spot=False):
    """Markers (F, 3) mm by name of a walk along x, which turns to the left from turn_s[0] to turn_s[1].

    Args:
        points: of the straight walk. pelvis: (F, 3) mm of it. heading_deg: of the way there.
        on_the_spot: the way back is the line of the way there.
    """
    done = np.clip((np.arange(len(pelvis)) / rate - turn_s[0]) / (turn_s[1] - turn_s[0]), 0, 1)
    done = done**3 * (10 - 15 * done + 6 * done * done)
    angle = np.radians(heading_deg) + np.pi * done
    c, s, o = np.cos(angle), np.sin(angle), np.zeros_like(angle)
    R = np.stack([np.stack([c, -s, o], -1), np.stack([s, c, o], -1), np.stack([o, o, o + 1], -1)], -2)
    flat = pelvis * (1, 1, 0)
    steps = np.gradient(flat, axis=0) * (np.abs(2 * done - 1) ** (3 if on_the_spot else 0))[:, None]
    way = np.cumsum(np.einsum("fij,fj->fi", R, steps), axis=0)
    return {name: np.einsum("fij,fj->fi", R, xyz - flat) + way for name, xyz in points.items()}


def there_and_back(body, *, duration_s, rate, **how):
    """True segments of a straight walk, its markers (F, 3) mm by name, and the same walked there and back."""
    limbs = body.limbs(np.arange(round(duration_s * rate)) / rate)
    points = body.markers(limbs)
    return limbs, points, bent(points, limbs.pelvis.origin, rate=rate, **how)
