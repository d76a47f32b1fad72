"""Images of markers as an infrared camera takes them.

Only patches round the markers are drawn. Each pixel of a patch gets the light of a marker in proportion to the share
of it that the marker's outline covers and no limb hides (`coverage`). Markers are laid from the farthest to the
nearest, each over those behind it (1). Light is then blurred, and the sensor reads it (`optics`). Round a strobe, an
opposite camera's ring of light, lies a Gaussian halo in proportion to how much of the strobe is in sight.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..data import Camera
from ..data.array_types import Bools, Floats
from ..geometry import normalised, project, to_camera, undistort
from . import optics as light
from .coverage import Ball, Box, Limbs, disc, pixels, sight_lines, visible_share
from .optics import Optics
from .sphere_image import sphere_outline
from .subjects import Capsules, Subject


def film(
    camera: Camera,
    subject: Subject,
    *,
    optics: Optics = Optics(),  # noqa: B008  frozen
    strobes: ArrayLike | None = None,
    seed: int = 0,
) -> Iterator[NDArray[np.uint8]]:
    """The images (H, W) of all frames of a subject, one after another.

    Args:
        camera: that looks.
        subject: what it sees.
        optics: how bright, sharp and noisy.
        strobes: (S, 3) places of other cameras' lights, mm.
        seed: of the noise; the same seed gives the same images.
    """
    rng = np.random.default_rng(seed)
    bank = light.noise_bank(camera.size, optics, rng)
    for f in range(subject.n_frames):
        yield render(
            camera,
            subject.xyz[:, f],
            subject.radius_mm,
            capsules=subject.capsules,
            frame=f,
            optics=optics,
            strobes=strobes,
            rng=rng,
            bank=bank,
        )


def interlace(images: Iterable[NDArray[np.uint8]]) -> Iterator[NDArray[np.uint8]]:
    """Pairs of images (H, W) woven into one: even lines from the first, odd lines from the second, as video does."""
    steps = iter(images)
    for first, second in zip(steps, steps, strict=False):
        woven = first.copy()
        woven[1::2] = second[1::2]
        yield woven


def render(
    camera: Camera,
    xyz: ArrayLike,
    radius: ArrayLike,
    *,
    capsules: Capsules | None = None,
    frame: int = 0,
    optics: Optics = Optics(),  # noqa: B008  frozen
    strobes: ArrayLike | None = None,
    rng: np.random.Generator | None = None,
    bank: NDArray[np.uint8] | None = None,
) -> NDArray[np.uint8]:
    """One image (H, W) of spheres at xyz (M, 3) mm, NaN for those that are not there.

    Args:
        camera: that looks; its `size` is the image's.
        xyz: (M, 3) centres, mm.
        radius: (M) or one, mm.
        capsules: limbs that hide spheres; `frame` says which of their frames.
        frame: see capsules.
        optics: how bright, sharp and noisy.
        strobes: (S, 3) places of other cameras' lights, mm.
        rng: of the noise; without it there is none.
        bank: background pixels from `optics.noise_bank`; without it every pixel's noise is drawn afresh.

    Raises:
        ValueError: the camera has no size.
    """
    if min(camera.size) < 1:
        raise ValueError(f"camera {camera.name} has size {camera.size}, wanted a width and height in px")
    image = light.background(camera.size, optics, rng, bank)
    limbs = _limbs(capsules, frame)
    balls, boxes = _in_view(camera, _balls(xyz, radius, strobes, optics), optics)
    if not balls:
        return image
    pad = 2 * optics.reach + 1
    canvas = np.zeros((image.shape[0] + 2 * pad, image.shape[1] + 2 * pad))
    for ball, box, coverage, bright in _coverages(camera, balls, boxes, limbs, optics):
        _lay(canvas, pad, ball, box, coverage, bright)
        if ball.glare > 0:
            _halo(canvas, pad, camera, ball, coverage, optics)
    for ball, box in zip(balls, boxes, strict=True):
        _expose(image, canvas, pad, _grow(box, ball, optics), optics, rng)
    return image


def _limbs(capsules: Capsules | None, frame: int) -> Limbs:
    if capsules is None:
        return Limbs(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))
    return Limbs(capsules.a[:, frame], capsules.b[:, frame], capsules.radius)


def _balls(xyz: ArrayLike, radius: ArrayLike, strobes: ArrayLike | None, optics: Optics) -> list[Ball]:
    """Markers and strobes as balls."""
    centres = np.asarray(xyz, np.float64).reshape(-1, 3)
    radii = np.broadcast_to(np.asarray(radius, np.float64), len(centres))
    lights = np.asarray([] if strobes is None else strobes, np.float64).reshape(-1, 3)
    markers = [Ball(c, float(r), optics.brightness, 0.0) for c, r in zip(centres, radii, strict=True)]
    return markers + [Ball(c, optics.strobe_radius_mm, optics.strobe_brightness, optics.glare) for c in lights]


def _in_view(camera: Camera, balls: list[Ball], optics: Optics) -> tuple[list[Ball], list[Box]]:
    """The balls whose images touch this camera's, from far to near (1), and the boxes round their outlines."""
    if not balls:
        return [], []
    xyz = np.array([ball.xyz for ball in balls])
    radius = np.array([ball.radius for ball in balls])
    depth = to_camera(camera, xyz)[:, 2]
    with np.errstate(invalid="ignore"):
        outline = sphere_outline(camera, xyz, radius)
        sound = (depth > radius) & np.isfinite(outline).all((1, 2)) & one_to_one(camera, xyz)
        outline = np.where(sound[:, None, None], outline, -1e9)
        low, high = np.floor(outline.min(1)) - 1, np.ceil(outline.max(1)) + 2
    margin = np.array([optics.reach + (3 * optics.glare_px if ball.glare > 0 else 0) for ball in balls])[:, None]
    sound &= ((high > -margin) & (low < camera.size + margin)).all(1)
    # A canvas has this much beyond the image; what lies farther out cannot shine into it.
    edge = 2 * optics.reach + 1
    low, high = np.maximum(low, -edge), np.minimum(high, camera.size + edge)
    order = [int(i) for i in np.argsort(-depth) if sound[i]]
    boxes = [(int(low[i, 0]), int(high[i, 0]), int(low[i, 1]), int(high[i, 1])) for i in order]
    return [balls[i] for i in order], boxes


def one_to_one(camera: Camera, xyz: Floats) -> Bools:
    """(…) whether the lens model sends nothing else to where it draws these points (…, 3) mm.

    Far outside the image a polynomial lens model folds back, and would show what no lens sees.
    """
    c = to_camera(camera, xyz)
    if not camera.distortion.any():
        return np.asarray(np.isfinite(c).all(-1))
    with np.errstate(all="ignore"):
        ideal = c[..., :2] / c[..., 2:]
        back = normalised(camera, undistort(camera, project(camera, xyz)))
        return np.asarray((np.abs(back - ideal) < 1e-6).all(-1))


def _coverages(
    camera: Camera, balls: list[Ball], boxes: list[Box], limbs: Limbs, optics: Optics
) -> Iterator[tuple[Ball, Box, Floats, Floats]]:
    """Each ball with its box, the share of each pixel (h, w) it covers, and the light it sends from there."""
    n = optics.subsamples
    places = [pixels(box) for box in boxes]
    ends = np.cumsum([len(uv) for uv in places])
    xy, turn = sight_lines(camera, np.concatenate(places), n)
    for ball, box, uv, end in zip(balls, boxes, places, ends, strict=True):
        part = slice(end - len(uv), end)
        share, rim = disc(camera, ball, xy[part], turn[part], n)
        lit = share.any(1)
        share[lit] *= visible_share(camera, ball, xy[part][lit], limbs, n)
        shape = (box[3] - box[2], box[1] - box[0])
        cover = share.mean(1).reshape(shape)
        dark = optics.limb_darkening
        bright = (share * (1 - dark * (1 - rim))).mean(1).reshape(shape) if dark else cover
        yield ball, box, cover, bright


def _lay(canvas: Floats, pad: int, ball: Ball, box: Box, coverage: Floats, bright: Floats) -> None:
    """Lay a ball's light over what is behind it (1)."""
    patch = canvas[box[2] + pad : box[3] + pad, box[0] + pad : box[1] + pad]
    patch *= 1 - coverage
    patch += ball.brightness * bright


def _halo(canvas: Floats, pad: int, camera: Camera, ball: Ball, coverage: Floats, optics: Optics) -> None:
    """Add the glare of a strobe, in proportion to how much of it is in sight."""
    u, v = project(camera, ball.xyz)
    area = np.pi * abs(camera.K[0, 0] * camera.K[1, 1]) * (ball.radius / to_camera(camera, ball.xyz)[2]) ** 2
    seen = min(float(coverage.sum() / area), 1.0)
    rows, columns = np.arange(canvas.shape[0]) - pad - v, np.arange(canvas.shape[1]) - pad - u
    near_v, near_u = np.abs(rows) < 3 * optics.glare_px, np.abs(columns) < 3 * optics.glare_px
    fall = [np.exp(-0.5 * (x / max(optics.glare_px, 1e-9)) ** 2) for x in (rows[near_v], columns[near_u])]
    canvas[np.ix_(near_v, near_u)] += seen * ball.glare * np.outer(*fall)


def _grow(box: Box, ball: Ball, optics: Optics) -> Box:
    """The box with all pixels that the ball's light reaches."""
    by = optics.reach + (int(3 * optics.glare_px) + 1 if ball.glare > 0 else 0)
    return box[0] - by, box[1] + by, box[2] - by, box[3] + by


def _expose(
    image: NDArray[np.uint8], canvas: Floats, pad: int, box: Box, optics: Optics, rng: np.random.Generator | None
) -> None:
    """Blur the canvas over a box and read it into the image."""
    u0, u1 = max(box[0], 0), min(box[1], image.shape[1])
    v0, v1 = max(box[2], 0), min(box[3], image.shape[0])
    if u0 >= u1 or v0 >= v1:
        return
    m = optics.reach
    window = canvas[v0 + pad - m : v1 + pad + m, u0 + pad - m : u1 + pad + m]
    lit = light.blur(window, optics)[m : m + v1 - v0, m : m + u1 - u0]
    image[v0:v1, u0:u1] = light.sensor(lit, optics, rng)
