"""Errors of given size and random direction: what comes of a million of them, and what the greatest possible is.

UM²AS 4.3 moves every centroid by R in a random direction θ (eq. 4.9, 4.10),

    Δu = R cos θ,    Δv = R sin θ                                        (1)

and looks for the greatest error that follows. `sample` does so in batches. Batch k draws from a generator of its own,
seeded with (seed, k), and results are put together in the order of batches, so that they do not depend on how many
workers share the work, nor on which is first.

A million samples do not find the greatest error: with 16 directions the chance that all point the bad way is nothing.
`climb` goes on from the largest samples and turns the directions by random amounts, keeping what makes the error
greater and halving the amounts each round (2), which ends at a true (local) maximum; several starts make it likely the
greatest.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from kinemark.data.array_types import Floats

Error = Callable[[Floats], Floats]
"""From angles θ (S, D) rad to errors (S)."""

STARTS = 8  # largest samples that are followed uphill; chosen
ROUNDS, TRIES = 40, 64  # ever shorter steps uphill, and directions tried at each; chosen


@dataclass(frozen=True, slots=True)
class Sampling:
    """How samples are drawn.

    Attributes:
        samples: how many.
        seed: of the directions.
        turn: θ is uniform from 0 to this, rad: a whole turn; the thesis says "between 0 and 180 degrees".
        batch: samples worked on at once, so that they stay in the cache.
        workers: threads; None: as many as there are processors. The results do not depend on it.
    """

    samples: int = 1_000_000
    seed: int = 0
    turn: float = 2 * np.pi
    batch: int = 4096
    workers: int | None = None

    def __post_init__(self) -> None:
        for name in ("samples", "batch", "turn"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} is {getattr(self, name)}, wanted more than 0")
        if self.workers is not None and self.workers < 1:
            raise ValueError(f"workers is {self.workers}, wanted 1 or more, or None")


class Sampled(NamedTuple):
    """Errors (S) of all samples in their order; the directions θ (D) of the largest, and of the `STARTS` largest."""

    error: Floats
    largest: Floats
    starts: Floats


def circle(theta: Floats, radius: float) -> Floats:
    """Δu, Δv (…, 2) px of directions θ (…) rad at a distance of `radius` px, by (1)."""
    return radius * np.stack([np.cos(theta), np.sin(theta)], -1)


def sample(error: Error, directions: int, method: Sampling) -> Sampled:
    """The error of many random directions.

    Args:
        error: gives (S) errors of (S, directions) angles.
        directions: how many angles a sample has.
        method: how many samples, and from where.

    Raises:
        ValueError: an error is not finite: the geometry does not allow the perturbation.
    """
    batches = -(-method.samples // method.batch)

    def work(k: int) -> tuple[Floats, Floats, Floats]:
        n = min(method.batch, method.samples - k * method.batch)
        theta = np.random.default_rng((method.seed, k)).uniform(0.0, method.turn, (n, directions))
        found = error(theta)
        top = np.argsort(-found, kind="stable")[:STARTS]
        return found, theta[top], found[top]

    with ThreadPoolExecutor(method.workers or os.cpu_count() or 1) as pool:
        parts = list(pool.map(work, range(batches)))
    errors, theta, top = (np.concatenate([part[i] for part in parts]) for i in range(3))
    if not np.isfinite(errors).all():
        raise ValueError(
            f"{(~np.isfinite(errors)).sum()} of {len(errors)} perturbed samples have no solution; wanted a smaller "
            "radius, or control points and cameras that determine one"
        )
    order = np.argsort(-top, kind="stable")[:STARTS]
    return Sampled(errors, theta[order[0]], theta[order])


def climb(error: Error, starts: Floats, *, turn: float, seed: int = 0) -> Floats:
    """The angles (D) of the greatest error reached from starts (K, D) within 0 … turn, by (2)."""
    rng = np.random.default_rng((seed, len(starts)))
    best, value = starts.copy(), error(starts)
    wrap = turn >= 2 * np.pi
    for step in np.geomspace(0.8, 1e-3, ROUNDS):
        some = rng.random((*best.shape[:1], TRIES, best.shape[1])) < max(2 / best.shape[1], 0.3)
        moved = best[:, None] + step * rng.standard_normal(some.shape) * some
        moved = np.mod(moved, turn) if wrap else np.clip(moved, 0.0, turn)
        found = error(moved.reshape(-1, best.shape[1])).reshape(len(best), TRIES)
        chosen = found.argmax(1)
        better = found.max(1) > value
        best = np.where(better[:, None], moved[np.arange(len(best)), chosen], best)
        value = np.maximum(value, found.max(1))
    return np.asarray(best[value.argmax()])
