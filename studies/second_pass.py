"""What the tracker profits from names: tracks before and after the second pass by the body.

    python studies/second_pass.py [walks|scenes|foot|gait9 …] [--seeds 20 21]

Each recording is tracked, named by another trial of the same person, and gone over by the second pass of `[label]`.

    walks   walkers of 15, 39 and 53 markers before 3, 4, 6 and 8 cameras at 25 to 100 Hz, noise 0.1 to 0.5 px, two
            false points a camera and frame, images merged within 8 px (`kinemark.synth`)
    scenes  of the second generator, `tests/support/scenes`, which shares no code with it; seed 2 is its
            scenes 20 to 29, those that another motion of the same person can name
    foot    the child's foot of `child_foot.py`, from images: markers of 8 mm, 25 mm apart
    gait9   the recording of walking (KINEMARK_DATA), named by its own first second; the other system's 24 named tracks
            are the judge where they do not leap

Recall and what is named rightly, in % of the samples of which two cameras have an image of their own (of the foot:
that two see; of `gait9`: that the reference has); points of a marker under another's name; points that are within
10 mm of no marker, a frame; changes of a track from marker to marker. Before → after, and the points that the pass
found, renamed, joined and put aside. Seeds 1 to 6, scenes 0 to 12 and seed 1 of the foot were looked at while this was
written; the others were not.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "benchmarks"))

import child_foot
import labelling_from_cameras as cameras
import numpy as np

from kinemark.data import Detections, Rig, Tracks
from kinemark.data.array_types import Bools, Floats
from kinemark.detect import Centroids
from kinemark.engine.naming.naming import name_tracks
from kinemark.engine.naming.second_pass import Search, second_pass
from kinemark.engine.naming.templates import SessionTemplate
from kinemark.io.tdf import read_tdf
from kinemark.label import Labelling, learn_template
from kinemark.synth import Optics, film, observe, ring, truth
from kinemark.track.simultaneous import Simultaneous
from support.scenes import scene

CASES = ((25.0, 0.3), (50.0, 0.1), (100.0, 0.5))
"""Hz and px of noise of the walks; chosen, so that each rate and each noise occurs."""
OPEN_MM = 50.0
"""Standard deviation that the cameras leave of a sample of a scene, above which it is not asked for; as in `tally`."""


class Case(NamedTuple):
    """A recording, a template, the truth (M, F, 3) mm with its names, and the samples (M, F) that are asked for."""

    name: str
    detections: Detections
    rig: Rig
    template: SessionTemplate
    xyz: Floats
    names: tuple[str, ...]
    wanted: Bools


class Figures(NamedTuple):
    """Recall and named rightly, %; wrong names, points; of no marker, points a frame; changes of marker."""

    recall: float
    named: float
    wrong: int
    ghosts: float
    swaps: int


def walks(seeds: list[int]) -> Iterator[Case]:
    for seed in seeds:
        for n in (15, 39, 53):
            for rate, noise in CASES:
                one, two = cameras.one_person(n, rate, seed)
                template = SessionTemplate(learn_template(two.trajectories), ("another walk",))
                for number in (3, 4, 6, 8):
                    rig = ring(number, focal_px=1100.0)
                    seen = observe(
                        rig, one, noise_px=noise, false_per_frame=2.0, merge_px=8.0, least_visible=0.3, seed=seed
                    )
                    name = f"walk {n}, {number} cameras, {rate:g} Hz, {noise} px, seed {seed}"
                    yield Case(name, seen.detections, rig, template, one.xyz, one.names, seen.unmerged_views >= 2)


def scenes(seeds: list[int]) -> Iterator[Case]:
    for k in (10 * seed + i for seed in seeds for i in range(10)):
        named = cameras.named_scene(k)
        if named is not None:
            seen, template, names = named
            wanted = (seen.own >= 2) & (seen.sd <= OPEN_MM)
            yield Case(str(scene(k))[:44], seen.detections, seen.rig, template, seen.xyz, names, wanted)


def foot(seeds: list[int]) -> Iterator[Case]:
    for rate, metres in child_foot.CASES:
        subject, later = child_foot.child(1.2, rate), child_foot.child(1.5, rate, speed=600.0)
        template, rig = (
            SessionTemplate(learn_template(later.trajectories), ("another walk",)),
            child_foot.cameras(metres),
        )
        shown = (truth(rig, subject).visible > 0.5).sum(0) >= 2
        for seed in seeds:
            images = [
                np.stack(list(film(c, subject, optics=Optics(subsamples=2), seed=seed + i))) for i, c in enumerate(rig)
            ]
            seen = child_foot.found(images, rig, rate, Centroids(threshold=60.0, min_area=2))
            name = f"foot, {rate:g} Hz, {metres} m, seed {seed}"
            yield Case(name, seen, rig, template, subject.xyz, subject.names, shown)


def gait9(seeds: list[int]) -> Iterator[Case]:
    file = cameras.ROOT / "cameras/gait9_bts/gait9.tdf"
    if file.is_file():
        tdf = read_tdf(file)
        assert tdf.rig and tdf.detections and tdf.trajectories
        reference = cameras.mended(tdf.trajectories.select([n for n in tdf.trajectories.names if cameras.is_name(n)]))
        first = max(int(np.isfinite(path.xyz[:, 0]).argmax()) for path in reference)
        template = SessionTemplate(learn_template(reference.frames(first, first + round(reference.rate))), ("itself",))
        wanted = np.isfinite(reference.xyz[..., 0])
        yield Case("gait9", tdf.detections, tdf.rig, template, reference.xyz, reference.names, wanted)


def figures(tracks: Tracks, names: tuple[str, ...], case: Case) -> Figures:
    """Tracks that bear names, against the truth."""
    owner, frame = cameras.owners(tracks, case.xyz), tracks.cloud.frame
    has = owner >= 0
    said = np.array([*names, ""], object)[tracks.id]
    right = has & (said == np.array([*case.names, ""], object)[owner])
    other = has & np.isin(said.astype(str), case.names) & ~right
    found, named = np.zeros(case.wanted.shape, bool), np.zeros(case.wanted.shape, bool)
    found[owner[has], frame[has]] = True
    named[owner[right], frame[right]] = True
    swaps, _ = cameras.changes(tracks.id, owner, frame)
    stray = int(((tracks.id >= 0) & ~has).sum())
    recall, share = (100 * float(one[case.wanted].mean()) for one in (found, named))
    return Figures(recall, share, int(other.sum()), stray / tracks.cloud.n_frames, swaps)


def compared(case: Case) -> tuple[Figures, Figures, str]:
    """Before and after, and what the pass did."""
    tracks, by = cameras.tracked(case.detections, case.rig), {"": case.template}
    found = name_tracks(tracks, by, how=Labelling())
    again = second_pass(found, tracks, by, Search(case.detections, case.rig, Simultaneous()))
    did = again.figures.get("second_pass", {})
    words = " ".join(f"{did.get(key, 0):4d}" for key in ("found", "renamed", "joined", "put_aside"))
    return figures(found.tracks, found.names, case), figures(again.tracks, again.names, case), words


def line(name: str, before: Figures, after: Figures, words: str) -> str:
    pairs = [f"{a:.2f} → {b:.2f}".rjust(17) for a, b in ((before[k], after[k]) for k in (0, 1))]
    pairs.append(f"{before.wrong} → {after.wrong}".rjust(12))
    pairs.append(f"{before.ghosts:.3f} → {after.ghosts:.3f}".rjust(16))
    pairs.append(f"{before.swaps} → {after.swaps}".rjust(12))
    return f"{name:46s}" + "".join(pairs) + "   " + words


def mean(all_of_them: list[Figures]) -> Figures:
    """The mean of shares, the sum of counts."""
    recall, named, wrong, ghosts, swaps = np.array(all_of_them, float).T
    return Figures(float(recall.mean()), float(named.mean()), int(wrong.sum()), float(ghosts.mean()), int(swaps.sum()))


PARTS = {"walks": walks, "scenes": scenes, "foot": foot, "gait9": gait9}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", help="of " + ", ".join(PARTS))
    parser.add_argument("--seeds", type=int, nargs="*", default=[20])
    asked = parser.parse_args()
    head = f"{'recall, %':>17s}{'named rightly, %':>17s}{'wrong':>12s}{'strays a frame':>16s}{'swaps':>12s}"
    print(f"{'':46s}{head}   found, renamed, joined, aside")
    for part in asked.parts or PARTS:
        done = []
        for case in PARTS[part](asked.seeds):
            done.append(compared(case))
            print(line(case.name, *done[-1]), flush=True)
        if len(done) > 1:
            before, after = mean([row[0] for row in done]), mean([row[1] for row in done])
            fewer = sum(row[1].recall < row[0].recall or row[1].wrong > row[0].wrong for row in done)
            print(line(f"all {len(done)}", before, after, f"worse in recall or names: {fewer}"), flush=True)


if __name__ == "__main__":
    main()
