"""The coefficients of (1) of `kinemark.track.simultaneous.ghosts.chance_meetings`, fitted again.

    python benchmarks/chance_meetings.py                     by the scenes of four cameras by which they were fitted
    python benchmarks/chance_meetings.py 40000-40099         by those of these seeds

Scenes are those of `tracking_scenes.py`, without files that merge within 10 px and do not say so: there most ghosts are
one marker's. They are tracked without the rule, and each stretch of two cameras is counted by its ghosts and by its
samples of markers. So p is of a point. Printed are the coefficients, and what the rule would take with them.
"""

from __future__ import annotations

import argparse
from typing import Any, NamedTuple

import numpy as np
import scipy
from tracking_scenes import numbers

from kinemark.data.array_types import Bools, Floats, Ints
from kinemark.track.simultaneous import track_with_decisions
from kinemark.track.simultaneous.ghosts import chance_meetings, given_up_points
from support.scenes import Scene, make, scene
from support.scenes.tally import owners

FITTED = ["20000-20099", "22000-22199", "40000-40140"]
PROBABILITIES = (0.5, 0.2, 0.1, 0.05, 0.02)


class Counted(NamedTuple):
    """Of N stretches: what (1) is made of (N, 4), ghosts (N) and points of markers (N)."""

    evidence: Floats
    ghosts: Floats
    markers: Floats


class Recorder:
    """Stands for the rule: gives nothing up, and keeps what it was last asked."""

    def __call__(self, *asked: Any) -> Bools:
        """No point of those that are asked about."""
        self.asked = asked
        return np.zeros(len(asked[0]), bool)


def counted(one: Scene, rule: Recorder) -> Counted:
    """The stretches of a scene's finished tracks."""
    made = make(one)
    tracks, _ = track_with_decisions(made.detections, made.rig)
    frame, _, detection = rule.asked[:3]
    stretch, evidence = chance_meetings.evidence(*rule.asked)
    owner = dict(zip(keys(tracks.cloud.frame, tracks.cloud.detection.T), owners(made, tracks)[0].tolist(), strict=True))
    mine = np.array([owner.get(key, -2) for key in keys(frame, detection)])
    some = stretch >= 0
    number = [np.bincount(stretch[some], which[some], len(evidence)) for which in (mine == -1, mine >= 0)]
    return Counted(evidence, *(np.asarray(each, np.float64) for each in number))


def keys(frame: Ints, detection: Ints) -> list[tuple[int, ...]]:
    """What tells each point: its frame and detections (C, P)."""
    return [tuple(row) for row in np.vstack([frame, detection]).T.tolist()]


def fitted(of: Counted) -> Floats:
    """The likeliest coefficients of (1), the first of them BIAS."""
    x = np.column_stack([np.ones(len(of.evidence)), of.evidence])

    def unlikelihood(b: Floats) -> tuple[float, Floats]:
        logit = x @ b
        value = of.ghosts @ np.logaddexp(0, -logit) + of.markers @ np.logaddexp(0, logit)
        return float(value), x.T @ ((of.ghosts + of.markers) * scipy.special.expit(logit) - of.ghosts)

    return np.asarray(scipy.optimize.minimize(unlikelihood, np.zeros(x.shape[1]), jac=True).x)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seeds", nargs="*", help="such as 3 or 40-49")
    seeds = numbers(parser.parse_args().seeds or FITTED)
    scenes = [one for one in map(scene, seeds) if one.cameras == 4 and (one.optics.merge < 10 or one.optics.marked)]
    vars(given_up_points)["chance_meetings"] = rule = Recorder()
    each = [counted(one, rule) for one in scenes]
    whole = Counted(*(np.concatenate(column) for column in zip(*each, strict=True)))
    b = fitted(whole)
    print(f"{len(scenes)} scenes, {whole.ghosts.sum():.0f} ghosts and {whole.markers.sum():.0f} points of markers")
    print("BIAS {:.2f}, DRIFT {:.2f}, LENGTH {:.2f}, PARTNERS {:.2f}, HELD {:.2f}".format(*b))
    p = scipy.special.expit(b[0] + whole.evidence @ b[1:])
    for least in PROBABILITIES:
        out = p > least
        print(f"p > {least:4.2f}: {whole.ghosts[out].sum():5.0f} ghosts and {whole.markers[out].sum():6.0f} of markers")


if __name__ == "__main__":
    main()
