"""Small images of discs and of patches of all forms."""

import numpy as np
from scipy import ndimage

SIDE = 25


def disc(u, v, diameter, blur, fine=8):
    """(SIDE, SIDE) a disc of height 1 at (u, v) from the middle, blurred by `blur` px."""
    at = (np.arange(SIDE * fine) + 0.5) / fine - 0.5 - SIDE // 2
    shape = np.clip((diameter / 2 - np.hypot(at - u, at[:, None] - v)) * fine + 0.5, 0, 1)
    if blur:
        shape = ndimage.gaussian_filter(shape, blur * fine)
    return shape.reshape(SIDE, fine, SIDE, fine).mean((1, 3))


def discs(n, diameter, blur, noise, rng, *, peak=190.0, ground=12.0, shot=0.0):
    """(n, SIDE, SIDE) images of one disc each, and where it is (n, 2) px."""
    part = rng.uniform(-0.5, 0.5, (n, 2))
    light = peak * np.array([disc(u, v, diameter, blur) for u, v in part])
    grey = ground + light + rng.normal(size=light.shape) * np.sqrt(noise**2 + shot * light)
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8), SIDE // 2 + part


def blotches(seed, shape):
    """(n, H, W) images with smooth bright patches of all forms."""
    rng = np.random.default_rng(seed)
    field = ndimage.gaussian_filter(rng.normal(size=shape), (0, 1.2, 1.2))
    return np.clip(60 + 200 * field, 0, 255).astype(np.uint8)
