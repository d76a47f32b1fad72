"""From a template and tracks to a label for each track: key frames, outwards, sweeps and exchanges."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..data.array_types import Bools, Floats, Ints
from .anatomy import Anatomy
from .arrange import arranged, score_by_places
from .evidence import PairScore
from .exchange import UNTOLD, Exchanger, best_moves
from .key_frames import Placing, frame_score, placings, search, settle
from .limbs import near_turns, score_with_sides
from .passed_on import passed_back
from .pool import pooled
from .runs import runs_put_right
from .side_pairs import mirrored
from .stretches import FREE, Stretches
from .sweeps import GOES_ON, continuity, evidence, expectation, outwards, places, sweep, total_score
from .template import Template

SWEEPS = 6
"""At most; chosen, most trials need two."""
ARRANGINGS = 2
"""Of another subject's template; chosen: the second time pieces are whole markers, as pooling gave them their
names; two of six pairs of children in 15 pieces rose by it from 95 to 100 % right, none fell."""
POOLINGS = 3
"""At most; chosen, most trials need one."""
BRIEF = 0.3
"""Share of the frames below which a marker is seen too little to be known by the trial; chosen."""
DOUBTFUL = 0.6
"""Fit of a track as a share of the median one, below which it is none of a brief marker's; chosen: ghosts have less."""
LEAST_KNOWN = 0.5
"""Share of the samples that must have a name before a trial may tell of the subject; chosen, as for a refusal."""
OFF = 0.3
"""The same for tracks of a marker that is known by the trial; chosen."""
LONGEST_CHAIN = 8
"""Rounds of it; chosen: so many pieces one after the other."""
TURNED = 0.7
"""Score as a share of what the template scores on its own data, below which the other sides of another subject's names
are tried as a whole; chosen: a body turned about had 0.62, right names of other children mostly have 0.7 to 1."""
PARTS = 3
"""Of a trial that are looked for, beside the first, that names do not reach; chosen, more cost time."""
LEAST_DARK = 0.05
"""Share of the frames that are such, below which none is looked for; chosen: sweeps and motion name fewer."""
LEAST_POINTS = 4
"""Of a key frame; by definition: three have no hand."""
PART = 0.7
"""Greatest number of points in a frame as a share of the labels, below which the search also begins elsewhere on the
body; chosen: legs alone, by the template of a whole body, have 0.4 to 0.5."""
STARTS = 3
"""From where it does, farthest from each other; chosen: a head, hands and feet."""
FEW = 0.1
"""Share of the names of a key frame that may differ from a labelling of the trial and lead to no other; chosen: sweeps
and exchanges settle so few."""
CLEARLY = 30.0
"""Nats a frame by which the names of another key frame must score more; chosen, as right limbs lose by an exchange: a
trunk and arms that were turned about gained 102, names by a template of another set, that nearly fitted, 5."""
LEAST_GAIN = 1.0
"""Of an exchange of labels, nats a frame; chosen."""


class Solution(NamedTuple):
    """(T) label of each track or −1; nats a frame of all pairs, and those that the template expects of as many.

    And how well distances agree with what is known of the subject after the trial: of pieces it tells more than the
    template, of whole labels it is no judge, as it was learnt from them.
    """

    label: Ints
    score: float
    expected: float
    after: PairScore | None = None


class Start(NamedTuple):
    """A labelled key frame: its score in nats, its row in the sampled frames, tracks and their labels."""

    score: float
    frame: int
    tracks: Ints
    labels: Ints


def solve(
    stretches: Stretches, template: Template, pairs: PairScore, *, key_frames: int, beam: int, least_fit: float
) -> Solution:
    """The labelling of the greatest score that was found; without a label for any track where no frame has points."""
    every = _outwards(stretches, template, pairs, key_frames, beam)
    if not every:
        return Solution(np.full(len(stretches), -1), 0.0, 0.0)
    done: dict[bytes, Solution] = {}
    found = _whole(every[0], stretches, template, pairs, key_frames, beam, least_fit, done)
    other = max(every, key=lambda label: total_score(stretches, label, pairs)[0])
    if total_score(stretches, other, pairs)[0] > found.score:
        best = _whole(other, stretches, template, pairs, key_frames, beam, least_fit, done)
        found = best if _clearly_better(best.label, found.label, stretches, template, pairs) else found
    after = found.after or pairs
    found = found._replace(label=runs_put_right(stretches, found.label, Exchanger.of(template, after)))
    kept = np.where(_doubtful(stretches, found.label, pairs, after), -1, found.label)
    return found._replace(label=_gone_on(stretches, kept, len(template)))


def _clearly_better(other: Ints, label: Ints, stretches: Stretches, template: Template, pairs: PairScore) -> bool:
    """Whether another labelling scores clearly more, and by another subject's template also more by places.

    By such a one distances carry a chain of wrong names, as each supports the next.
    """
    new, old = (score_with_sides(stretches, one, template, pairs) for one in (other, label))
    if new <= old + CLEARLY:
        return False
    if not np.any(template.doubt):
        return True
    new, old = (score_by_places(stretches, one, template, pairs) for one in (other, label))
    return new > old


def _outwards(stretches: Stretches, template: Template, pairs: PairScore, n: int, beam: int) -> list[Ints]:
    """(T) labels outwards from key frames, that of the greatest score first, without those that lead to the same.

    A body that is turned about, or whose limbs have each other's names, can score more in one frame than the right one
    does in any, and less in the trial.
    """
    tried: list[Ints] = []
    for start in _starts(stretches, template, pairs, n, beam, np.ones(len(stretches.frame), bool)):
        if not any((label[start.tracks] != start.labels).sum() <= FEW * len(start.labels) for label in tried):
            tried.append(outwards(stretches, start.frame, start.tracks, start.labels, pairs))
    return tried


def _whole(
    label: Ints,
    stretches: Stretches,
    template: Template,
    pairs: PairScore,
    key_frames: int,
    beam: int,
    least_fit: float,
    done: dict[bytes, Solution],
) -> Solution:
    """The labelling that labels (T) by a key frame lead to, with whole bodies and limbs the right way about.

    Args:
        done: what settled labels led to already, to which this one is added: most key frames settle alike.
    """
    label = _further(label, stretches, template, pairs, key_frames, beam)
    label = _settled(stretches, label, template, pairs, least_fit)
    label = _right_way_about(stretches, label, template, pairs, least_fit)
    if label.tobytes() not in done:
        found = _from_settled(label, stretches, template, pairs, least_fit)
        doubtful = np.any(template.doubt) and found.score < TURNED * found.expected * template.own_fit
        if found.score > 0 and doubtful:
            found = _turned(found, mirrored(template.names), stretches, template, pairs, least_fit)
        done[label.tobytes()] = limbs_turned(found, stretches, template, pairs, least_fit)
    return done[label.tobytes()]


def _right_way_about(stretches: Stretches, label: Ints, template: Template, pairs: PairScore, least_fit: float) -> Ints:
    """(T) settled labels, or what they settle to with all sides exchanged, where these have the greater score.

    Distances hardly tell a body from its mirror image. What is learnt of the trial from names of the other side, and
    limbs that are then put right one by one, would leave it turned in part.
    """
    other = mirrored(template.names)
    turned = np.where(label >= 0, other[label], -1)
    least = score_with_sides(stretches, label, template, pairs)
    if (stretches.fixed != FREE).any() or score_with_sides(stretches, turned, template, pairs) <= least:
        return label
    turned = _settled(stretches, turned, template, pairs, least_fit)
    return turned if score_with_sides(stretches, turned, template, pairs) > least else label


def _further(
    label: Ints, stretches: Stretches, template: Template, pairs: PairScore, key_frames: int, beam: int
) -> Ints:
    """(T) labels, also from key frames of the parts of the trial that a first one does not reach.

    Where few cameras see the body, too few markers are seen before and after a moment to carry the names over it.
    """
    for _ in range(PARTS):
        points = np.isfinite(stretches.xyz[..., 0])
        could = np.minimum(points.sum(0), len(template))
        dark = (could >= LEAST_POINTS) & (points[label >= 0].sum(0) < LEAST_KNOWN * could)
        if dark.mean() < LEAST_DARK:
            break
        score, expected = total_score(stretches, label, pairs)
        if score < LEAST_KNOWN * expected:  # a template that does not fit where names are tells nothing of the rest
            break
        known = replace(stretches, fixed=np.where(label >= 0, label, stretches.fixed))
        starts = _starts(known, template, pairs, key_frames, beam, dark)
        new = outwards(known, starts[0].frame, starts[0].tracks, starts[0].labels, pairs) if starts else label
        if total_score(stretches, new, pairs)[0] <= score:
            break
        label = new
    return label


def _from_settled(
    label: Ints, stretches: Stretches, template: Template, pairs: PairScore, least_fit: float
) -> Solution:
    """The labelling that a first one (T), after sweeps and exchanges, leads to."""
    found = Solution(label, 0.0, 0.0)
    doubted = bool(np.any(template.doubt))
    for _ in range(ARRANGINGS if doubted else 1):
        before = found.label
        label = before
        if doubted:
            label = passed_back(stretches, arranged(stretches, before, template, pairs), template, pairs)
        found = _pooled(stretches, label, template, pairs, least_fit)
        if (found.label == before).all():  # as it would be once more
            break
    return found


def _turned(
    found: Solution, other: Ints, stretches: Stretches, template: Template, pairs: PairScore, least_fit: float
) -> Solution:
    """What other names (L) of labels lead to, where that has the greater score; the labelling as it was otherwise.

    Nearly all distances of a body are those of its mirror image, so that a search can end in a body that is turned
    about, with left names on the right, or with the names of each leg on the other one; no move of a few labels leads
    out of it.
    """
    if (other == np.arange(len(other))).all():
        return found
    label = np.where(found.label >= 0, other[found.label], -1)
    label = _settled(stretches, label, template, pairs, least_fit)
    least = score_with_sides(stretches, found.label, template, pairs)
    if score_with_sides(stretches, label, template, pairs) <= least - CLEARLY:  # pooling may still mend a few names
        return found
    label = _settled(stretches, label, template, pairs, least_fit)
    turned = _from_settled(label, stretches, template, pairs, least_fit)
    return turned if score_with_sides(stretches, turned.label, template, pairs) > least else found


def limbs_turned(
    found: Solution, stretches: Stretches, template: Template, pairs: PairScore, least_fit: float
) -> Solution:
    """The labelling, with limbs that had each other's names put back where that has the greater score."""
    for turn in near_turns(places(stretches, found.label, len(template)), template, pairs, stretches.fixed):
        found = _turned(found, turn, stretches, template, pairs, least_fit)
    return found


def _gone_on(stretches: Stretches, label: Ints, L: int) -> Ints:
    """(T) labels, also of tracks that go on, by motion, from a marker's tracks: in a posture that is new for a moment.

    A marker's name must be free in all their frames, and no other's tracks may go on with them nearly as well.
    """
    label = label.copy()
    for _ in range(LONGEST_CHAIN):
        nats = continuity(stretches, label, L)
        nats[label >= 0] = 0.0
        first = np.argsort(-nats.max(1), kind="stable")
        named = 0
        for t in first[nats.max(1)[first] > GOES_ON].tolist():
            a = int(nats[t].argmax())
            taken = (stretches.seen[label == a] & stretches.seen[t]).any()
            if not taken and nats[t, a] - np.delete(nats[t], a).max(initial=0.0) > GOES_ON / 2:
                label[t], named = a, named + 1
        if not named:
            break
    return label


def solve_with_facts(
    stretches: Stretches, template: Template, pairs: PairScore, *, key_frames: int, beam: int, least_fit: float
) -> Solution:
    """The better of two labellings with what was stated: of a search that begins with it, and of one without it.

    Labels that were stated do not change places, so that the first alone would miss what exchanges find.
    """
    options: dict[str, Any] = {"key_frames": key_frames, "beam": beam, "least_fit": least_fit}
    own = solve(stretches, template, pairs, **options)
    plain = solve(replace(stretches, fixed=np.full(len(stretches), FREE)), template, pairs, **options)
    other = _settled(stretches, sweep(stretches, plain.label, pairs, least_fit), template, pairs, least_fit)
    score, expected = total_score(stretches, other, pairs)
    if score <= total_score(stretches, own.label, pairs)[0]:
        return own
    return Solution(other, score, expected, plain.after)


def _settled(stretches: Stretches, label: Ints, template: Template, pairs: PairScore, least_fit: float) -> Ints:
    """(T) labels after sweeps and exchanges, those of the greatest score."""
    best, most, tried = label, -np.inf, False
    anatomy = Anatomy.of(template.names)
    for _ in range(SWEEPS):
        label = sweep(stretches, label, pairs, least_fit)
        score, _ = total_score(stretches, label, pairs)
        settled = score <= most + 1e-6 * abs(most)
        best, most = (best, most) if settled else (label, score)
        if settled and tried:
            break
        if settled:
            moves = Exchanger.of(template, pairs).keeping(stretches.fixed)
            turn = best_moves(places(stretches, best, len(template)), moves, LEAST_GAIN, anatomy)
            tried = True
            if (turn == np.arange(len(turn))).all():
                break
            label = np.where(best >= 0, turn[best], -1)
            score, _ = total_score(stretches, label, pairs)
            old, new = (score_with_sides(stretches, one, template, pairs) for one in (best, label))
            better = score > most or (score > most - UNTOLD and new > old)
            best, most = (label, score) if better else (best, most)
    return best


def _pooled(stretches: Stretches, label: Ints, template: Template, pairs: PairScore, least_fit: float) -> Solution:
    """After sweeps by what is known of the subject after the trial."""
    judged, after = total_score(stretches, label, pairs), pairs  # what comes now is fitted to this labelling
    could = np.minimum(stretches.seen.sum(0), len(template)).sum()
    if stretches.seen[label >= 0].sum() < LEAST_KNOWN * could:
        return Solution(label, *judged, after)
    for _ in range(POOLINGS):
        after = PairScore.of_template(pooled(template, places(stretches, label, len(template))))
        new = sweep(stretches, label, after, least_fit, take_over=True)
        if (new == label).all():
            break
        label = new
    return Solution(label, *judged, after)


def _doubtful(stretches: Stretches, label: Ints, pairs: PairScore, after: PairScore) -> Bools:
    """(T) tracks that take an absent marker's name and do not move with its body, or not as the marker's others do.

    What is known after the trial tells of markers that are seen for long; of the rest only what was known before.
    """
    named = np.flatnonzero(label >= 0)
    brief = _share_of_frames(stretches, label, len(pairs.distance)) < BRIEF
    out = np.zeros(len(label), bool)
    for score, whole, share in ((pairs, brief, DOUBTFUL), (after, ~brief, OFF)):
        if not whole[label[named]].any():
            continue
        nats, expected = evidence(stretches, label, score), expectation(stretches, label, score)
        fit = nats[named, label[named]] / np.maximum(expected[named, label[named]], 1e-9)
        out[named] |= (fit < share * np.median(fit) if len(fit) else fit < 0) & whole[label[named]]
    return out


def _share_of_frames(stretches: Stretches, label: Ints, L: int) -> Floats:
    """(L) of the trial's frames, those in which each label is."""
    return np.array([stretches.seen[label == a].any(0).mean() for a in range(L)])


def _starts(stretches: Stretches, template: Template, pairs: PairScore, n: int, beam: int, among: Bools) -> list[Start]:
    """`n` key frames, evenly spread over those with points among (K) some, the best first; none where none has any."""
    points = np.isfinite(stretches.xyz[..., 0]).sum(0)
    orders = _orders(template, pairs, int(points.max(initial=0)))
    usable = np.flatnonzero((points >= min(LEAST_POINTS, points.max(initial=1))) & among)
    if not len(usable):
        return []
    stated = np.isfinite(stretches.xyz[stretches.fixed >= 0, :, 0]).sum(0)[usable]
    usable = usable[stated == stated.max()]  # all, where nothing was stated
    some = np.unique(usable[np.linspace(0, len(usable) - 1, n).round().astype(int)])
    found = [_labelled(stretches, int(k), template, pairs, orders, beam) for k in some]
    return sorted(found, key=lambda one: -one.score)


def _orders(template: Template, pairs: PairScore, most: int) -> list[list[Placing]]:
    """In which labels are placed, where frames have that many points at most.

    Where a part of the body wears no markers at all and labels of it came first, the beam is full of points that do not
    belong there before one comes that does.
    """
    orders = [placings(pairs, template.handed, template.sign)]
    if most < PART * len(template):
        begun, D = [orders[0][0].label], np.nan_to_num(template.distance)
        for _ in range(STARTS):
            begun.append(int(D[begun].min(0).argmax()))
        orders += [placings(pairs, template.handed, template.sign, [a]) for a in begun[1:]]
    return orders


def _labelled(
    stretches: Stretches, k: int, template: Template, pairs: PairScore, orders: list[list[Placing]], beam: int
) -> Start:
    """The labelling of one frame."""
    here = np.flatnonzero(np.isfinite(stretches.xyz[:, k, 0]))
    xyz = stretches.xyz[here, k]
    fixed = stretches.fixed[here]
    if (fixed >= 0).any():
        orders = [*orders, placings(pairs, template.handed, template.sign, fixed[fixed >= 0].tolist())]
    points = [settle(xyz, search(xyz, pairs, one, beam, fixed), pairs, fixed) for one in orders]
    scores = [frame_score(xyz, point, pairs, template.handed, template.sign) for point in points]
    point, score = points[int(np.argmax(scores))], max(scores)
    labels = np.flatnonzero(point >= 0)
    return Start(score, k, here[point[labels]], labels)
