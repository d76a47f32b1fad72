"""Cases of the shift law: edits of trajectories."""

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.data.edits import Claim, Entry, Erase, GapChoice, Put, Stretch, Trim, Witness
from kinemark.edit import anchored, connection, cropped, difference, replay, stretch_of
from kinemark.edit.probable_errors import (
    Paths,
    breaks,
    changes,
    fillings,
    ghosts,
    leaps,
    pieces,
    places,
    spikes,
    unbroken,
)
from kinemark.engine.editing.editing import Editing
from kinemark.engine.editing.journal import Journal
from kinemark.engine.problems import filled_gaps, problems
from kinemark.fill import Linear, piece_matches, prepare
from support.edited import entries, paths_without_images
from support.filling import swaying
from support.shift_law import Answer, law, moved
from support.walked import clean, trajectories, with_xyz


def stretch_moved(where, by):
    """A stretch, said in a world moved by `by`."""
    return replace(where, witnesses=tuple(Witness(w.frame, tuple(np.add(w.xyz, by).tolist())) for w in where.witnesses))


def said(by) -> list[Entry]:
    whole = paths_without_images()
    where = stretch_moved(stretch_of(whole, "*1", first=30, last=150), by)
    return entries(
        Claim(where, "A"), Erase("A", 40, 60), Put("A", 50, tuple((by + 700.0).tolist()), 1.0), Trim(20, 180)
    )


def trial(by):
    return moved(paths_without_images(), by)


@law(stretch_of, mm=1e-2)
def _(by):
    where: Stretch = stretch_of(trial(by), "*2", first=9, at=77)
    return Answer(np.array([w.xyz for w in where.witnesses]), [w.frame for w in where.witnesses])


@law(anchored, mm=1e-2)
def _(by):
    whole = trial(by)
    whole = replace(whole, paths=tuple(replace(p, name=n) for p, n in zip(whole, "ABCD", strict=True)))
    edits = [anchored(edit, whole, None, "") for edit in (Erase("A", 40, 60), GapChoice("B", 61, 80, "best"))]
    found = [(one.outcome, one.samples) for one in replay(whole, entries(*edits)).applied]
    return Answer(np.array([w.xyz for edit in edits for w in edit.where.witnesses]), found)


@law(replay, mm=1e-6)
def _(by):
    edited = replay(trial(by), said(by))
    return Answer(edited.trajectories.xyz, [(one.outcome, one.samples) for one in edited.applied])


@law(cropped)
def _(by):
    edited = replay(trial(by), said(by))
    return Answer(cropped(edited.trajectories, edited).xyz)


@law(connection, share=1e-6)
def _(by):
    one, other = trial(by).paths[:2]
    missing = np.arange(len(one)) >= 90
    first = replace(one, xyz=np.where(missing[:, None], np.nan, one.xyz), origin=np.where(missing, 0, one.origin))
    return Answer(rest=connection(first, other, rate=100.0)._asdict())


@law(piece_matches, share=1e-5)
def _(by):
    whole = swaying(markers_=6, frames=200)[0]
    lost, piece = whole.xyz.copy(), np.full((200, 3), np.nan)
    piece[120:] = lost[0, 120:]
    lost[:2, 90:] = np.nan
    paths = [MarkerTrajectory.measured(name, xyz) for name, xyz in zip(whole.names, lost, strict=True)]
    pieces = Trajectories((*paths, MarkerTrajectory.measured("*7", piece)), 100.0)
    return Answer(rest=[one[2:4] for one in piece_matches(moved(pieces, by), "*7")])


@law(difference, mm=1e-6)
def _(by):
    found = difference(trial(by), replay(trial(by), said(by)).trajectories)
    return Answer(rest=[one[:5] for one in (*found.renamed, *found.changed)])


@law(changes, places, spikes, leaps, pieces, ghosts, share=1e-2)
def _(by):
    whole = trial(by)
    paths = Paths.of(whole)
    some = [*changes(paths, places(paths)), *spikes(paths), *leaps(paths), *pieces(paths), *ghosts(paths, whole)]
    return Answer(rest=[round(one.wrong, 2) for one in some])


@law(fillings, share=1e-2)
def _(by):
    walk = clean()
    xyz = np.round(walk.xyz * 256) / 256  # as other places here, so that no move rounds them
    xyz[6, 150:200] = xyz[6, 149]
    found = fillings(Paths.of(moved(with_xyz(walk, dict(enumerate(xyz))), by)))
    assert found
    return Answer(rest=[(one.path, one.first, one.last, one.still, round(one.wrong, 2)) for one in found])


@law(breaks, unbroken, share=1e-2, mm=1e-3)
def _(by):
    xyz = np.round(clean().xyz * 256) / 256  # as other places here, so that no move rounds them
    whole = moved(trajectories(np.delete(xyz, slice(151, 155), axis=1), clean().names), by)
    paths = Paths.of(whole)
    found = breaks(paths)
    assert found
    rest = [(one.kind, one.before, one.after, one.frames, round(one.wrong, 2)) for one in found]
    return Answer([unbroken(paths, whole.names, found)[0].xyz], rest)


@law(problems, filled_gaps, share=1e-2)
def _(by):
    whole = replay(trial(by), said(by)).trajectories
    with TemporaryDirectory() as folder:
        editing = Editing("walk", Journal.of(Path(folder), "walk"), whole)
        found = problems(editing, gaps=filled_gaps(editing)).items
    return Answer(rest=sorted((one.kind, one.first, one.last, round(one.wrong, 2)) for one in found))


@law(prepare, mm=1e-6)
def _(by):
    whole = replay(trial(by), said(by)).trajectories
    best = prepare(whole).candidates("A", 45, methods=(Linear(),))[0]
    return Answer(best.xyz, round(best.expected_mm, 6))
