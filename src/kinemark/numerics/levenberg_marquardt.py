"""Levenberg–Marquardt: least squares by steps between those of Gauss and Newton and those of steepest descent.

Let χ² = Σ r² of residuals r, and J = −∂r / ∂δ. Near a state χ² is χ² − 2 gᵀδ + δᵀA δ with

    A = JᵀJ,   g = Jᵀr                                                    (1)

and the step δ solves (Levenberg 1944; Marquardt 1963)

    (A + λ D) δ = g,   D = diag A                                         (2)

so that the unit of a parameter changes nothing. By this model χ² falls by

    2 gᵀδ − δᵀA δ = gᵀδ + λ δᵀD δ                                         (3)

With ϱ the actual decrease over the one that (3) predicts, the damping λ goes on as (Nielsen 1999,
"Damping parameter in Marquardt's method", IMM-REP-1999-05)

    χ² did not rise:   λ ← λ max(1/10, 1 − (2ϱ − 1)³),   ν ← 2
    χ² rose:           λ ← λ ν,                           ν ← 2 ν         (4)

with 1/10 (Marquardt's) where Nielsen has 1/3. Where the model holds (ϱ near 1) λ soon vanishes, and the steps are Gauss
and Newton's; where tries fail, λ grows faster and faster. Where only a few tries can be paid for, fixed factors as
Marquardt has them get farther

    χ² did not rise:   λ ← λ down,      χ² rose:   λ ← λ up               (5)

In a long valley every other step of (5) fails. There `hold` keeps λ at the first success after a failure (6).

`minimise` solves one problem, whatever its state is made of and in whatever way it solves (2); `minimise_many` many
small problems of one kind at once. Both change λ by (4), (5) or (6), and nothing else in the package does.
"""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol, TypeVar

import numpy as np

from ..data.array_types import Bools, Floats, Ints
from .scaled import scaled_solution

START = 1e-4
"""λ at first, without unit; of 10⁻³ and 10⁻⁴ the one with fewer tries to a minimum in `benchmarks/bundle.py start`."""

LEAST_FACTOR = 0.1
"""Of (4), without unit; Marquardt's. With 1/100 `benchmarks/bundle.py start` ends less exactly, in no fewer tries."""

MAX_DAMPING = 1e8
"""λ above which no step is tried; chosen, not tuned: δ is then 10⁻⁸ of what it was, and only rounding is left."""

State = TypeVar("State")
Equations = TypeVar("Equations")


class Damping(NamedTuple):
    """λ and ν of (4), one each or (n) of many problems.

    Attributes:
        value: λ.
        growth: ν; 2 where the try before did not fail.
        fixed: the factors down and up of (5), which then holds instead of (4).
        hold: (6).
    """

    value: Any = START
    growth: Any = 2.0
    fixed: tuple[float, float] | None = None
    hold: bool = False

    def after(self, decrease: Any, predicted: Any) -> Damping:
        """After tries that lowered χ² by `decrease`, where (3) predicted `predicted`."""
        if self.fixed is None:
            with np.errstate(invalid="ignore", over="ignore"):
                ratio = np.clip(decrease / np.maximum(predicted, 1e-300), 0.0, 1.0)
            down, up = np.maximum(LEAST_FACTOR, 1 - (2 * ratio - 1) ** 3), self.growth  # (4)
        else:
            down, up = self.fixed  # (5)
            down = np.where(self.hold & (np.asarray(self.growth) > 2), 1.0, down)  # (6)
        factor, growth = np.where(decrease >= 0, down, up), np.where(decrease >= 0, 2.0, 2 * self.growth)
        return self._replace(value=self.value * factor, growth=growth)

    def of_many(self, n: int) -> Damping:
        """The same for each of n problems."""
        return self._replace(value=np.full(n, self.value), growth=np.full(n, self.growth))

    def take(self, which: Bools) -> Damping:
        """That of some of many problems."""
        return self._replace(value=self.value[which], growth=self.growth[which])


NIELSEN = Damping()  # (4) from `START`, without unit; Nielsen's, whose numbers stand above


class Problem(Protocol[State, Equations]):
    """Least squares over states of any kind."""

    def cost(self, state: State) -> float:
        """χ² of a state, infinite where it is impossible."""

    def equations(self, state: State) -> Equations:
        """(1) at a state, in whatever form `step` takes it."""

    def step(self, state: State, equations: Equations, damping: float) -> tuple[State | None, float]:
        """The state after the step (2), None where there is none, and the decrease that (3) predicts."""


def minimise(
    problem: Problem[State, Equations],
    start: State,
    *,
    steps: int,
    relative: float = 0.0,
    absolute: float = 0.0,
    damping: Damping = NIELSEN,
) -> State:
    """The state near `start` with the least cost; `start` itself where its cost is not finite.

    It is found once two tries in turn neither predict nor bring a decrease of more than `relative` times the cost plus
    `absolute`.

    Args:
        problem: what is minimised.
        start: where to begin.
        steps: at most so many tries.
        relative: without unit.
        absolute: in the unit of the cost.
        damping: λ at first, and how it changes.
    """
    state, cost, small = start, problem.cost(start), 0
    equations: Equations | None = None
    for _ in range(steps if np.isfinite(cost) else 0):
        equations = problem.equations(state) if equations is None else equations
        candidate, predicted = problem.step(state, equations, float(damping.value))
        decrease = cost - (lower := np.inf if candidate is None else problem.cost(candidate))
        damping = damping.after(decrease, predicted)
        small = small + 1 if max(decrease, predicted) <= relative * cost + absolute else 0
        if candidate is not None and decrease >= 0:
            state, cost, equations = candidate, lower, None
        if small >= 2 or damping.value > MAX_DAMPING:
            break
    return state


def damped_step(A: Floats, g: Floats, damping: float) -> tuple[Floats, float]:
    """δ (p) of (2) and the decrease (3), from A (p, p) and g (p)."""
    D = np.diag(A)
    step = scaled_solution(A + damping * np.diag(D), g)
    return step, float(g @ step + damping * step @ (D * step))  # (3)


class Iterates(NamedTuple):
    """States of n problems of p parameters, which may be tried ones.

    Attributes:
        parameters: (n, p).
        cost: (n) χ².
        equations: what (1) is worked out from, arrays (n, …).
    """

    parameters: Floats
    cost: Floats
    equations: tuple[Floats, ...]

    def take(self, which: Ints) -> Iterates:
        """Those of some of the problems."""
        return Iterates(self.parameters[which], self.cost[which], tuple(part[which] for part in self.equations))

    def put(self, which: Ints, candidate: Iterates, better: Bools) -> None:
        """Write the `better` (b) of tries of problems `which` (b) here."""
        good = which[better]
        self.parameters[good], self.cost[good] = candidate.parameters[better], candidate.cost[better]
        for part, new in zip(self.equations, candidate.equations, strict=True):
            part[good] = new[better]


class Problems(Protocol):
    """Many least squares problems with as many parameters each."""

    def step(self, which: Ints, now: Iterates, damping: Floats) -> tuple[Iterates, Floats]:
        """Problems `which` (b) after the step (2) from `now`, theirs alone, with λ (b); and what (3) predicts (b)."""

    def converged(self, which: Ints, now: Iterates, candidate: Iterates) -> Bools:
        """(b) whether what was found by the step has converged; only asked where χ² did not rise."""


def minimise_many(problems: Problems, start: Iterates, *, steps: int, damping: Damping = NIELSEN) -> Iterates:
    """The states near `start` with the least cost, each until it has converged; `start` is written over.

    Args:
        problems: what is minimised.
        start: where to begin.
        steps: at most so many tries of each.
        damping: λ at first, and how it changes.
    """
    damping, busy = damping.of_many(len(start.cost)), np.arange(len(start.cost))
    for _ in range(steps):
        if not len(busy):
            break
        now = start.take(busy)
        candidate, predicted = problems.step(busy, now, damping.value)
        decrease = now.cost - candidate.cost
        better = decrease >= 0
        damping = damping.after(decrease, predicted)
        done = (better & problems.converged(busy, now, candidate)) | (damping.value > MAX_DAMPING)
        start.put(busy, candidate, better)
        busy, damping = busy[~done], damping.take(~done)
    return start
