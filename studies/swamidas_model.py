"""Matching with the component angle model in the tracking loop, of Swamidas (1997), 4.2.5.

The twelve tests of `swamidas_runs` on three runs, from several phases of the cycle, with the tracker corrected by the
model: "All the tests passed the matching of the observed markers to their corresponding tracks … no failures are
observed". A test passes when every point has the identity of its marker. The ways:

    none       the predictor alone, as in table 4.6
    position   a correction fed back as the thesis does, with the differences that follow from it
    measured   as a position measured with the model's variance
    own        measured, with the model made of the same recording with its gaps; "-" from a phase where too little of
               the motion is left to learn from
    meeting    as measured, forwards and backwards, joined where both meet in the middle of a gap (5.2)
    meet, own  the same with the model made of the same recording
    none, meet the predictor alone, forwards and backwards

The model of `position` and `measured` is that of another recording of the same motion, begun elsewhere in the cycle and
with other unsteadiness. The phase is found from what is visible; the thesis is given it.

Run: python studies/swamidas_model.py [phases, 8] [first phase as a share of the step between them, 0]
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace

from missing_markers import model_of
from swamidas import LETTERS, TESTS, outcome
from swamidas_runs import gap_frames, recorded

from kinemark.data import KinemarkError
from kinemark.track.swamidas import Swamidas

WAYS = ("none", "position", "measured", "own", "none, meet", "meeting", "meet, own")


def passed(number: int, test: int, phase: float, way: str) -> bool | None:
    """Whether a test passes from a phase; None where no model can be made."""
    try:
        return outcome(recorded(number, phase), test, method=method_of(way, number, phase)).passed
    except KinemarkError:
        return None


def method_of(way: str, number: int, phase: float) -> Swamidas:
    """The tracker of one of the ways, for a run from a phase."""
    plain = Swamidas(direction="meeting" if "meet" in way else "forward")
    if "none" in way:
        return plain
    if "own" in way:
        return replace(plain, angle_model="own")
    return replace(plain, model=model_of(number, phase), feedback="position" if way == "position" else "measured")


def table(number: int, phases: list[float], ways: tuple[str, ...] = WAYS) -> Iterator[str]:
    """Lines of one run."""
    yield f"Run {number}" + " " * 22 + "".join(f"{test:>7d}" for test in TESTS)
    yield "  gap, frames              " + "".join(f"{gap_frames(test):>7d}" for test in TESTS)
    yield "  published, no model      " + "".join(f"{letter:>7s}" for letter in LETTERS[number])
    yield "  published, model         " + "".join(f"{'P':>7s}" for _ in TESTS)
    for way in ways:
        cells = []
        for test in TESTS:
            found = [passed(number, test, phase, way) for phase in phases]
            known = [one for one in found if one is not None]
            cells.append(f"{sum(known)}/{len(known)}" if known else "-")
        yield f"  here, {way:19s}" + "".join(f"{cell:>7s}" for cell in cells)


def main() -> None:
    n = int(sys.argv[1]) if len(sys.argv) > 1 else 8
    first = float(sys.argv[2]) if len(sys.argv) > 2 else 0.0
    print(f"Tests passed, of {n} phases; of fewer where from some no model of the trial itself can be made")
    for number in (1, 2, 3):
        print("\n".join(table(number, [(k + first) / n for k in range(n)])), flush=True)


if __name__ == "__main__":
    main()
