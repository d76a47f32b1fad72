"""Calls of every function of `native`: right ones, and the same with arrays that are wrong in one way or several."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from kinemark import native
from kinemark.native import shape_images
from kinemark.native.shape_fits import fit_shapes as fit_shapes_of_patches
from kinemark.native.side_light import light_sides as light_sides_of_patches


class Call(NamedTuple):
    """A function with its arguments: arrays by name, in order, and other parameters."""

    function: Callable[..., Any]
    arrays: dict[str, Any]
    parameters: dict[str, Any]

    def __call__(self) -> list[Any]:
        """The arrays that it gives, in one list."""
        found = self.function(*self.arrays.values(), **self.parameters)
        return list(found) if isinstance(found, tuple) else [found]


def outcome(call: Call) -> list[Any] | None:
    """What a call gives; None where it refuses its arguments."""
    try:
        return call()
    except ValueError:
        return None


# ---- Right calls ----


def film(rng):
    n, height, width = rng.integers(0, 3), rng.integers(1, 30), rng.choice([1, 7, 40, 300])
    top, dtype = (255, np.uint8) if rng.random() < 0.5 else (65535, np.uint16)
    grey = np.zeros((n, height, width), dtype)
    grey[rng.random(grey.shape) < rng.choice([0.02, 0.4])] = rng.integers(top // 2, top)
    return grey, int(rng.integers(0, top // 2))


def find_runs(rng):
    images, threshold = film(rng)
    most = None if rng.random() < 0.7 else int(rng.integers(-1, 20))
    return Call(native.find_runs, {"tall": images.reshape(-1, images.shape[2])}, {"threshold": threshold, "most": most})


def group_runs(rng):
    images, threshold = film(rng)
    runs = native.find_runs(images.reshape(-1, images.shape[2]), threshold)
    size = {"height": images.shape[1], "width": images.shape[2]}
    if rng.random() < 0.2:
        size[rng.choice(list(size))] += int(rng.choice([-1, 1, -(10**6), 10**9]))
    return Call(native.group_runs, dict(zip(("y", "first", "last"), runs, strict=True)), size)


def groups(rng):
    """A film, its groups of white pixels as arguments by name, and the threshold."""
    images, threshold = film(rng)
    runs = native.find_runs(images.reshape(-1, images.shape[2]), threshold)
    (y, first, last), start, _ = native.group_runs(*runs, height=images.shape[1], width=images.shape[2])
    return {"images": images, "start": start, "y": y, "first": first, "last": last}, threshold


def sum_pixels(rng):
    return Call(native.sum_pixels, groups(rng)[0], {})


def cut_pixels(rng):
    asked, threshold = groups(rng)
    return Call(native.cut_pixels, asked, {"threshold": threshold, "margin": int(rng.integers(0, 5))})


def group_peaks(rng):
    return Call(native.group_peaks, groups(rng)[0], {})


def sum_peaks(rng):
    asked, _ = groups(rng)
    n = len(asked["start"]) - 1
    peak = asked["images"].max(initial=0) - rng.integers(0, 3, n).astype(float)
    places = {"peak": peak, "near": peak - rng.uniform(0, 50, n), "uv": rng.uniform(0, 30, (n, 2))}
    return Call(native.sum_peaks, asked | places, {})


def motion(rng, n):
    root = rng.normal(0, 1, (n, 9, 9)) * np.repeat([3.0, 50.0, 900.0], 3)[:, None]
    return rng.normal(0, 800, (9, n)), np.ascontiguousarray((root @ root.swapaxes(1, 2)).transpose(1, 2, 0))


def predict(rng):
    x, V = motion(rng, n := int(rng.integers(0, 20)))
    return Call(native.predict, {"x": x, "V": V, "T": rng.uniform(0.001, 0.3, n)}, {"q": 5000.0})


def update(rng):
    x, V = motion(rng, n := int(rng.integers(0, 20)))
    J = rng.normal(0, 1, (n, 3, 3))
    return Call(
        native.update, {"x": x, "V": V, "N": np.einsum("nai,naj->ijn", J, J), "g": rng.normal(0, 1, (3, n))}, {}
    )


def cameras(rng, C):
    """(C, 3, 4) of focal length 1000 px, 4 m from the origin and looking at it, the third row of length 1."""
    angle = rng.uniform(0, 2 * np.pi) + np.arange(C) * 2 * np.pi / max(C, 1)
    c, s, zero, one = np.cos(angle), np.sin(angle), np.zeros(C), np.ones(C)
    R = np.array([[-s, c, zero], [zero, zero, -one], [-c, -s, zero]]).transpose(2, 0, 1)
    P = np.concatenate([R, np.array([zero, zero, 4000 * one]).T[:, :, None]], -1)
    return np.array([[1000.0, 0, 640], [0, 1000.0, 512], [0, 0, 1]]) @ P


def project(rng):
    _, V = motion(rng, n := int(rng.integers(0, 12)))
    P = cameras(rng, int(rng.integers(0, 5)))
    return Call(native.project, {"P": P, "xyz": rng.uniform(-900, 900, (3, n)), "cov": V[:3, :3]}, {})


def information(rng):
    arrays = project(rng).arrays
    uv, J, _ = native.project(*arrays.values())
    C, _, n = uv.shape
    D = int(rng.integers(1, 30))
    detection = rng.integers(-1, D, (C, n))
    asked = {
        "uv": uv,
        "J": J,
        "detection": detection,
        "variance": rng.uniform(0.01, 1, (C, n)),
        "images": rng.normal(0, 9, (D, 2)),
    }
    return Call(native.information, asked, {})


def recording(rng):
    D, n_cells = int(rng.integers(0, 60)), int(rng.integers(1, 9))
    return rng.uniform(0, 50, (D, 2)), rng.integers(0, n_cells, D), rng.random(D) < 0.8, n_cells


def index_images(rng):
    uv, cell, usable, n_cells = recording(rng)

    def function(*arrays, n_cells):
        index = native.index_images(*arrays, n_cells=n_cells)
        return index.uv, index.order, index.first

    return Call(function, {"uv": uv, "cell": cell, "usable": usable}, {"n_cells": n_cells})


def image_index(rng):
    uv, cell, usable, n_cells = recording(rng)
    index = native.index_images(uv, cell, usable, n_cells=n_cells)

    def function(*arrays):
        made = native.ImageIndex(*arrays)
        return made.near(np.arange(n_cells), np.full(n_cells, 25.0), np.full(n_cells, 9.0))

    return Call(function, {name: getattr(index, name) for name in ("uv", "order", "first")}, {})


def near(rng):
    *images, n_cells = recording(rng)
    cell = rng.integers(0, n_cells, n := int(rng.integers(0, 12)))
    asked = {"cell": cell, "u": rng.uniform(-5, 55, n), "reach": rng.uniform(-1, 20, n)}
    return Call(native.index_images(*images, n_cells=n_cells).near, asked, {})


def candidates(rng):
    *images, n_cells = recording(rng)
    index, D = native.index_images(*images, n_cells=n_cells), len(images[0])
    cell = rng.integers(0, n_cells, n := int(rng.integers(0, 12)))
    S = np.array([rng.uniform(0, 9, n), rng.uniform(-1, 1, n), rng.uniform(0, 9, n)])
    asked = {
        "variance": rng.uniform(1, 2, D),
        "free": rng.random(D) < 0.8,
        "cell": cell,
        "uv": rng.uniform(0, 50, (2, n)),
    }
    asked |= {"S": S, "reach": rng.uniform(-1, 60, n)}
    return Call(
        lambda *arrays, gate: native.candidates(index, *arrays, gate=gate), asked, {"gate": rng.choice([4.0, 1e4])}
    )


def intersect(rng):
    """Points of which all five cameras have an image, without some."""
    n = int(rng.integers(0, 12))
    P = cameras(rng, 5)
    uv = native.project(P, rng.uniform(-900, 900, (3, n)), np.zeros((3, 3, n)))[0] + rng.normal(0, 0.2, (5, 2, n))
    uv, detection = uv.swapaxes(1, 2).reshape(-1, 2), np.arange(5 * n).reshape(5, n)
    detection[rng.permuted(np.tile(np.arange(5) < rng.integers(0, 3), (n, 1)).T, axis=0)] = -1
    asked = {"P": P, "uv": uv, "variance": rng.uniform(0.01, 1, 5 * n), "detection": detection}
    return Call(native.intersect, asked | {"camera": np.repeat(np.arange(5)[:, None], n, axis=1)}, {})


def cluster_pixels(rng):
    """Pixels on a grid, some of them white, and centres of which some lie on each other or far away."""
    n, N, k = (int(number) for number in rng.integers((0, 0, 1), (5, 60, 6)))
    x, y = rng.integers(0, 9, (2, n, N)) / 2
    centres = rng.integers(0, 9, (n, k, 2)) / rng.choice([1.0, 3.0])
    asked = {"x": x, "y": y, "white": rng.random((n, N)) < 0.6, "centres": centres}
    return Call(native.cluster_pixels, asked, {"turns": int(rng.integers(0, 8))})


SHAPES = {
    "discs": [0.3, -0.2, 3.1],
    "ellipse": [0.2, 0.1, 0.3, 0.02, 0.4],
    "motion": [0.1, 0.2, 3.0, 2.0, 1.0],
    "cut": [0.1, 0.2, 4.0, 0.7, 1.0],
}


def fit_shapes(rng):
    """Patches that show what is fitted to them, with noise, some of them saturated, some pixels left out."""
    name, n, k = rng.choice(list(SHAPES)), int(rng.integers(0, 4)), 1
    true = np.array(SHAPES[name])
    if name == "discs" and (k := int(rng.integers(1, 6))) > 1:
        turn = np.arange(k) * 2 * np.pi / k
        true = np.stack([2.5 * np.cos(turn), 2.5 * np.sin(turn), np.full(k, 3.0)], -1).reshape(-1)
    true = np.concatenate([true + rng.uniform(-0.1, 0.1, (n, len(true))), np.tile([0.6, 180.0, 12.0], (n, 1))], 1)
    y, x = (np.tile(at.reshape(-1).astype(float), (n, 1)) for at in np.mgrid[-8:9, -8:9])
    weight = np.where(rng.random(x.shape) < 0.95, 1 / 9, 0.0)
    patches = shape_images.Patches(x, y, np.zeros_like(x), weight, np.where(rng.random(n) < 0.3, 150.0, np.inf))
    shape = getattr(shape_images, name)
    grey = shape_images.image(shape, true, patches)[0] + rng.normal(0, 3, x.shape)
    start = true + rng.uniform(-0.05, 0.05, true.shape) * np.abs(true)
    asked = {"start": start, **patches._replace(grey=grey)._asdict(), "wanted": np.full(n, rng.choice([200.0, np.inf]))}
    return Call(fit_shapes_of_patches, asked | {"enough": np.full(n, rng.choice([0.0, 400.0]))}, {"shape": shape})


def light_sides(rng):
    """Patches lit from a side, and what is fitted to them but for that."""
    asked, parameters = (fitted := fit_shapes(rng)).arrays, fitted.parameters
    asked["grey"] = asked["grey"] * (1 + rng.uniform(-0.03, 0.03) * asked["x"] + rng.uniform(-0.03, 0.03) * asked["y"])
    patches = {name: asked[name] for name in shape_images.Patches._fields}
    found = fit_shapes_of_patches(**(asked | {"grey": patches["grey"]}), **parameters)
    return Call(light_sides_of_patches, {"parameters": found.parameters, **patches}, parameters)


CALLS = {
    made.__name__: made
    for made in (
        find_runs, group_runs, sum_pixels, cut_pixels, group_peaks, sum_peaks, predict, update, project, information,
        index_images, image_index, near, candidates, intersect, cluster_pixels, fit_shapes, light_sides,
    )
}  # fmt: skip


# ---- What may be wrong with an array ----


def other_shape(array, rng):
    changes = [lambda a: a[None], lambda a: a[..., None], lambda a: np.concatenate([a, a]), lambda a: a.reshape(-1)]
    changes += [
        lambda a: a[1:],
        lambda a: a[..., :-1],
        lambda a: a[:0],
        lambda a: a[..., :0],
        lambda a: np.array(a.size),
    ]
    changes += [lambda a: np.concatenate([a, a, a], -1), lambda a: np.swapaxes(a, 0, -1)]
    return changes[rng.integers(len(changes))](array)


def other_dtype(array, rng):
    dtypes = ["f4", "f8", ">f8", "i4", "i8", ">i8", "u1", "u2", ">u2", "u8", "?", "c16", "O", "U9"]
    with np.errstate(all="ignore"):
        return array.astype(rng.choice(dtypes)) if array.dtype.kind in "fiub" else array


def other_layout(array, rng):
    raw = np.frombuffer(b"\0" + array.tobytes(), np.uint8)[1:]  # not aligned
    changes = [
        array[::-1],
        array[..., ::-1],
        np.asfortranarray(array),
        np.repeat(array, 2, -1)[..., ::2],
        np.broadcast_to(array[:1], array.shape),
        raw.view(array.dtype).reshape(array.shape) if array.size and array.dtype != object else array,
    ]
    array = changes[rng.integers(len(changes))]
    array.flags.writeable = False
    return array


def other_values(array, rng):
    array = np.array(array)
    if array.size and array.dtype.kind in "fiub":
        wild = {"f": [np.nan, np.inf, -np.inf, 0.0, -1.0], "i": [-1, -2, 0, 10**6, 2**62, -(2**63), 2**63 - 1]}
        value = np.array(rng.choice(wild.get(array.dtype.kind, [0, 1])))
        array.flat[rng.integers(array.size)] = value.astype(array.dtype)
    return array


def no_array(array, rng):
    return [None, "x", [], [[1.0], [1.0, 2.0]], 3.0, {}, array.tolist()][rng.integers(7)]


WRONGS = (other_shape, other_dtype, other_layout, other_values, no_array)


def wrong(call: Call, wrongs, rng) -> Call:
    """The call, with an array that is wrong in each of these ways."""
    arrays = dict(call.arrays)
    for change in wrongs:
        name = rng.choice(list(arrays))
        if isinstance(arrays[name], np.ndarray) and arrays[name].ndim:
            arrays[name] = change(arrays[name], rng)
    return call._replace(arrays=arrays)
