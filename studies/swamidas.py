"""Tracking past hidden markers, of Swamidas (1997), 4.2.3 and 4.2.4: tables 4.6 to 4.10.

Twelve tests a run: one marker (tests 1 to 6) or two (7 to 12) are hidden for 1/3, 2/3 … 2 s, three times in a recording
(`swamidas_runs`). A test passes when every point has the identity of its marker, in the gaps too. The recordings
are lost; the arm's motions are rebuilt, and each test is run from several phases of the cycle, so "6/8" stands where
the published table has one letter. The images are left out: without noise they give the points back exactly. A second
line has the segments' lengths, learned from the first frames, refuse matches, which the document leaves to its model;
the third runs through the recording backwards; in the fourth predictions from both ends of a gap meet in its middle, as
5.2 recommends.

Table 4.6 is illegible in the copy at hand; its letters are those that the text tells (4.2.3.1 and 5.1).

Tables 4.7 to 4.9 are headed "inch²". Read so, they would put the prediction some two inches off in the mean of a gap
at whose end figure 4.14 has it five feet off; in feet² they agree with the figure. So read, ours of run 1 are like
them, but for marker C. (Where test 5 of run 3 repeats the z row of test 3, nothing can fit.) In run 3 ours are
several times, in run 2 some fifty times as great: the error goes with the sixth power of the speed, and the speed and
the shape of these motions are known from a sentence each.

Run: python studies/swamidas.py [phases, 8]
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from swamidas_runs import STARTS, Run, cloud_of, gap_frames, recorded, visible

from kinemark.data.array_types import Floats
from kinemark.track.swamidas import Constraint, Swamidas, SwamidasResult, follow_points, track_distance

TESTS = tuple(range(1, 13))
LETTERS = {1: "PPPPPPPPPPPP", 2: "PPPPFFPPPPFF", 3: "PPPPPFPFFFFF"}
"""Table 4.6, as the text has it: passed and failed tests of each run."""

SQUARED: dict[tuple[int, int], tuple[tuple[float, ...], ...]] = {
    (1, 1): ((0, 0, 0), (0, 0, 0), (0, 0, 0)),
    (1, 3): ((0.15, 0.393, 0), (0.03, 0.196, 0), (0.041, 0.1282, 0.03)),
    (1, 6): ((1.097, 4.232, 0), (0.906, 3.359, 0.02), (0.3045, 1.4433, 0.407)),
    (1, 7): ((0.01, 0, 0), (0.01, 0.01, 0.02), (0, 0, 0)),
    (1, 9): ((0.205, 0.225, 0.08), (0.767, 0.464, 0.357), (0.05, 0.04, 0.06)),
    (1, 12): ((1.486, 2.102, 0.571), (7.696, 5.632, 2.012), (0.225, 0.07, 0.508)),
    (2, 1): ((0, 0, 0), (0, 0, 0), (0, 0, 0)),
    (2, 3): ((0.04, 0.02, 0), (0.03, 0.04, 0.05), (0, 0, 0.01)),
    (2, 4): ((0.09, 0.05, 0), (0.131, 0.104, 0.113), (0, 0.021, 0.01)),
    (2, 7): ((0, 0, 0), (0, 0, 0.01), (0, 0, 0)),
    (2, 9): ((0.07, 0.04, 0.04), (0.04, 0.07, 0.2), (0, 0, 0.04)),
    (2, 10): ((0.153, 0.09, 0.1), (0.09, 0.171, 0.43), (0.02, 0, 0.09)),
    (3, 1): ((0.02, 0.03, 0.02), (0.107, 0, 0.02), (0.033, 0.019, 0.044)),
    (3, 3): ((0.357, 0.99, 0.291), (2.085, 1.481, 0.14), (0.4951, 1.1842, 0.4832)),
    (3, 5): ((1.145, 4.056, 0.291), (5.626, 10.53, 0.14), (1.2966, 5.3815, 0.4832)),
    (3, 7): ((0.03, 0.07, 0.04), (0.146, 0.09, 0.03), (0.06, 0.08, 0.06)),
}
"""Tables 4.7, 4.8 and 4.9: by run and test, the mean squared error along x, y, z of markers A (D), B, C."""

GAPS = {1: (18, 13), 2: (31, 25), 3: (3, 2)}
"""Table 4.10: the gap at which the distance alone fails, with one and with two markers missing, frames."""

FOOT = 304.8  # mm
LONGEST = 60  # frames; the longest gap tried

DEFAULT = Swamidas()


class Outcome(NamedTuple):
    """One test: whether it passed, its squared errors (3, 3) mm² of markers and coordinates over the gaps' frames, how
    the points after the gaps were found, and how far off (3) the prediction for the first marker was at the end of its
    first gap, mm."""

    passed: bool
    squared: Floats
    by: list[Constraint]
    off: Floats


Found = dict[int, dict[int, list[Outcome]]]
"""By run and test, an outcome a phase."""


def outcome(run: Run, test: int, *, method: Swamidas = DEFAULT, extra: int | None = None) -> Outcome:
    """Run a test; `extra` seeds a false point that comes with each marker that comes back."""
    n_gap = gap_frames(test)
    seen = visible(n_gap, 1 if test <= 6 else 2)
    false = {} if extra is None else {start + n_gap: _anywhere(run, extra + start) for start in STARTS}
    cloud, marker = cloud_of(run.xyz, seen, run.subject.rate, false)
    followed = follow_points(cloud, method=method)
    return Outcome(
        passed=bool((followed.tracks.id[marker >= 0] == marker[marker >= 0]).all()),
        squared=_squared(followed, run.xyz, seen),
        by=_returns(followed, seen, marker),
        off=_expected_back(followed, STARTS[0] + n_gap) - run.xyz[0, STARTS[0] + n_gap],
    )


def _expected_back(followed: SwamidasResult, f: int) -> Floats:
    """(3) mm where the first track was expected in frame f; NaN where predictions met before."""
    frame = followed.expected[f]
    return np.array([*frame.xyz[frame.id == 0], np.full(3, np.nan)][0])


def _anywhere(run: Run, seed: int) -> Floats:
    """A point (1, 3) mm in the box about the whole motion."""
    low, high = run.xyz.min((0, 1)), run.xyz.max((0, 1))
    return np.random.default_rng(seed).uniform(low, high, (1, 3))


def _squared(followed: SwamidasResult, xyz: Floats, seen: NDArray[np.bool_]) -> Floats:
    """Mean squared error (3, 3) of each marker's track where it was not seen."""
    off = np.stack([followed.path(i) for i in range(3)]) - xyz[:, : seen.shape[1]]
    return np.stack([(off[i, ~seen[i]] ** 2).mean(0) for i in range(3)])


def _returns(followed: SwamidasResult, seen: NDArray[np.bool_], marker: NDArray[np.int64]) -> list[Constraint]:
    """What decided about the first point of each marker after each of its gaps."""
    back = np.zeros_like(seen)
    back[:, 1:] = seen[:, 1:] & ~seen[:, :-1]
    frame = followed.tracks.cloud.frame
    return [Constraint(by) for by in followed.by[(marker >= 0) & back[marker, frame]]]


def gap_at_failure(run: Run, missing: int, *, longest: int = LONGEST) -> int:
    """The shortest gap at which the distance alone mistakes a marker, frames; one more than the longest if none."""
    for n_gap in range(1, longest + 1):
        cloud, marker = cloud_of(run.xyz, visible(n_gap, missing), run.subject.rate)
        if (track_distance(cloud).id != marker).any():
            return n_gap
    return longest + 1


def runs(number: int, phases: int) -> list[Run]:
    """A run from phases spread over its cycle."""
    return [recorded(number, k / phases) for k in range(phases)]


def passes(
    number: int, phases: int, tests: tuple[int, ...] = TESTS, *, method: Swamidas = DEFAULT
) -> dict[int, list[Outcome]]:
    """The outcomes of the tests of a run, one a phase."""
    return {test: [outcome(run, test, method=method) for run in runs(number, phases)] for test in tests}


def table_6(found: Found, better: Found, backward: Found, meeting: Found) -> Iterator[str]:
    """Lines of table 4.6 for runs 1 to 3."""
    ways = {"here": found, "with segments": better, "backward": backward, "meeting (5.2)": meeting}
    yield "Table 4.6: tests passed (P) and failed (F); here, of how many phases so many passed"
    yield "  test                     " + "".join(f"{test:>6d}" for test in TESTS)
    yield "  gap, frames              " + "".join(f"{gap_frames(test):>6d}" for test in TESTS)
    for number, letters in LETTERS.items():
        yield f"  run {number}: published         " + "".join(f"{letter:>6s}" for letter in letters)
        for words, table in ways.items():
            shares = (f"{sum(o.passed for o in table[number][test])}/{len(table[number][test])}" for test in TESTS)
            yield f"         {words:18s}" + "".join(f"{share:>6s}" for share in shares)
    yield "How a marker that comes back was found, %: by region, distance, velocity, elimination, not at all"
    for number, tests in found.items():
        for words, some in (("one missing", TESTS[:6]), ("two missing", TESTS[6:])):
            by = [constraint for test in some for o in tests[test] for constraint in o.by]
            kinds = (1, 2, 3, 4, 0)
            yield f"  run {number}, {words}: " + "".join(f"{100 * np.mean(np.equal(by, kind)):6.1f}" for kind in kinds)


def tables_7_to_9(found: Found, meeting: Found) -> Iterator[str]:
    """Lines of tables 4.7 to 4.9, the mean over the phases in which the test passed."""
    for (number, test), published in SQUARED.items():
        if test == 1:
            yield f"Table 4.{number + 6}: run {number}, mean squared error in the gaps along x, y, z, feet²"
            yield f"{'':21s}" + "".join(f"{'marker ' + name:>24s}" for name in ("A (D)", "B", "C"))
        own, met = (_mean_squared(table[number][test]) for table in (found, meeting))
        for words, rows in ((f"test {test:2d}: published", np.array(published)), ("here", own), ("meeting", met)):
            yield f"  {words:>19s}" + "".join(f"{x:>10.2f}{y:7.2f}{z:7.2f}" for x, y, z in rows)
    off = np.abs([o.off for o in found[1][12]]) / FOOT
    yield (
        'Run 1, test 12, marker A at the end of its first gap: published "as far as 5 feet away"; '
        f"here {off.max(1).min():.1f} to {off.max():.1f} feet along one coordinate"
    )


def _mean_squared(outcomes: list[Outcome]) -> Floats:
    """(3, 3) feet², the mean over those that passed."""
    passed = [o.squared for o in outcomes if o.passed]
    return np.mean(passed, axis=0) / FOOT**2 if passed else np.full((3, 3), np.nan)


def table_10(phases: int) -> Iterator[str]:
    """Lines of table 4.10."""
    yield "Table 4.10: gap at which the distance alone fails, frames; here the least, the median and the greatest"
    yield f"  (61: not up to 60){'one missing':>24s}{'two missing':>32s}"
    for number, published in GAPS.items():
        cells = []
        for missing, known in zip((1, 2), published, strict=True):
            gaps = [gap_at_failure(run, missing) for run in runs(number, phases)]
            cells.append(f"published {known:2d}, here {min(gaps):2d} {np.median(gaps):4.1f} {max(gaps):2d}")
        yield f"  run {number}:  {cells[0]}   {cells[1]}"


def extra_points(phases: int) -> Iterator[str]:
    """Lines for false points that come with the markers that come back."""
    yield "A false point beside each marker that comes back: passed (published: most, failures after > 30 frames)"
    for number in (1, 2, 3):
        found = {test: [outcome(run, test, extra=test) for run in runs(number, phases)] for test in TESTS[:6]}
        shares = (f"{sum(o.passed for o in outcomes)}/{len(outcomes)}" for outcomes in found.values())
        yield f"  run {number}, gaps of 10 … 60 frames: " + "".join(f"{share:>6s}" for share in shares)


def main() -> None:
    phases = int(sys.argv[1]) if len(sys.argv) > 1 else 8
    found = {number: passes(number, phases) for number in (1, 2, 3)}
    stiff = Swamidas(segment_tolerance=0.05)
    better, backward, meeting = (
        {number: passes(number, phases, method=method) for number in (1, 2, 3)}
        for method in (stiff, Swamidas(direction="backward"), Swamidas(direction="meeting"))
    )
    tables = table_6(found, better, backward, meeting), tables_7_to_9(found, meeting)
    for lines in (*tables, table_10(phases), extra_points(phases)):
        print("\n".join(lines))
        print()


if __name__ == "__main__":
    main()
