"""A trial as a C3D document, with all that its own file held besides.

What the trial and its source agree on is taken from the source, number by number; so an untouched trial gives its
file back, gaps coded as they were. What differs is written anew: gaps as zeros with −1, residual and cameras in the
fourth number, names at the end of their tables.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from ...data import Trial
from ...version import __version__
from ..notes import FileNote
from .about import subjects_in, with_about, with_prefixes
from .analog_rates import on_frames
from .document import C3D, with_parameters
from .numbers import ByteOrder
from .parameter_tables import matched, rows_from, too_long, with_numbers, with_text
from .parameters import Parameter
from .points import point_names
from .rotations import with_rotations
from .sample_table import with_table
from .storing_analog import with_analog, with_plates
from .storing_points import with_points
from .to_trial import events_of
from .writing import with_counts, write_document


def write_c3d(
    path: Path | str, trial: Trial, *, order: ByteOrder | None = None, floats: bool | None = None
) -> tuple[FileNote, ...]:
    """Write a trial as a C3D file; returns what the file could not hold as it was.

    Filled samples have the residual 0 and no camera, as C3D wants it; a group KINEMARK names them where that does not
    tell. Covariances of markers and what was edited stand in a section of our own (`sample_table`). Signals become
    points (`signal_points`), channels go on one clock (`analog_rates`). What C3D has no place for is not written: the
    steps, the images behind samples, and cameras beyond the seventh.

    Args:
        path: the file.
        trial: what to write; a trial that came from a C3D file keeps all that its file held.
        order: processor whose numbers to write; the source's, or Intel.
        floats: floats or 16-bit integers; as the source, or floats.

    Raises:
        ValueError: the trial holds what C3D cannot, such as missing samples of channels among integers.
        KinemarkError: the file cannot be written, or a marker and a signal have one name.
    """
    doc, notes = stored(trial, order=order, floats=floats)
    write_document(path, doc)
    return notes


def document_of(trial: Trial, *, order: ByteOrder | None = None, floats: bool | None = None) -> C3D:
    """The document that `write_c3d` writes.

    Raises:
        ValueError: as `write_c3d`.
        KinemarkError: a marker and a signal have one name.
    """
    return stored(trial, order=order, floats=floats)[0]


def stored(
    trial: Trial, *, order: ByteOrder | None = None, floats: bool | None = None
) -> tuple[C3D, tuple[FileNote, ...]]:
    """The document of a trial, and what it could not hold as it was."""
    own = isinstance(trial.source, C3D)
    source: C3D = trial.source if own else blank_document()
    floats = source.floats if floats is None else floats
    rate, first = trial.trajectories.rate, trial.trajectories.first_frame
    doc = replace(source, order=source.order if order is None else order, rate=rate)
    doc, about_signals = with_points(doc, source, trial, floats=floats)
    analog, about_analog = on_frames(trial.analog, rate, len(doc.points))
    doc = with_analog(doc, source, analog, shift=first - source.first_frame, floats=floats)
    doc = with_events(with_plates(doc, trial.plates), trial)
    doc, about_poses = with_rotations(doc, source, trial.poses, shift=first - source.first_frame)
    doc = with_about(with_table(doc, trial.trajectories), trial.about)
    had = point_names(source)  # of a file that has prefixes without saying so, they stay unsaid
    new = [name for name in trial.trajectories.names if name not in had]
    doc = with_prefixes(doc, subjects_in(trial.about), new)
    changed = doc.points.shape != source.points.shape or doc.analog.shape != source.analog.shape
    notes = (*about_signals, *about_analog, *about_poses, *_shortened(trial))
    return with_counts(doc) if changed or not own else doc, notes


def _shortened(trial: Trial) -> list[FileNote]:
    """What names of the trial do not fit."""
    channels = [name for a in trial.analog for name in a.names]
    have = {"markers": trial.trajectories.names, "signals": trial.signals.names, "channels": channels}
    cut = {what: tuple(name for name in names if too_long(name)) for what, names in have.items()}
    return [FileNote("shortened", what, names) for what, names in cut.items() if names]


def with_events(doc: C3D, trial: Trial) -> C3D:
    """The document with the trial's events in the EVENT group, and none in the header where they changed."""
    old, new = events_of(doc), trial.events
    if (old.label, old.side) == (new.label, new.side) and np.array_equal(old.time, new.time, equal_nan=True):
        return doc
    keys = [list(zip(e.label, e.side, e.time.tolist(), strict=True)) for e in (new, old)]
    rows = matched(*([str(key) for key in part] for part in keys))
    doc = with_parameters(replace(doc, header_events=()), "EVENT", [Parameter.whole("USED", len(new))])
    for name, texts in (("CONTEXTS", new.side), ("LABELS", new.label)):
        doc = with_text(doc, "EVENT", name, texts, rows, doc.texts("EVENT", name))
    for name in ("DESCRIPTIONS", "SUBJECTS"):
        had = doc.texts("EVENT", name)
        if had:
            picked = [had[r] if 0 <= r < len(had) else "" for r in rows]
            doc = with_text(doc, "EVENT", name, picked, rows, had)
    for name in ("ICON_IDS", "GENERIC_FLAGS"):
        if doc.get("EVENT", name) is not None:
            doc = with_numbers(doc, "EVENT", name, rows_from(doc.numbers("EVENT", name), rows, 0), whole=True)
    minutes = np.floor(new.time / 60)
    return with_numbers(doc, "EVENT", "TIMES", np.column_stack([minutes, new.time - 60 * minutes]))


def blank_document() -> C3D:
    """A document without points, with the groups of a file of our own in the order that readers know."""
    none = np.zeros((0, 0))
    doc = C3D(ByteOrder.INTEL, True, 0.0, np.zeros((0, 0, 3)), none, none, 0, ())
    empty = [Parameter.text("LABELS", []), Parameter.text("DESCRIPTIONS", [])]
    doc = with_parameters(doc, "POINT", [Parameter.text("UNITS", "mm"), *empty])
    doc = with_parameters(doc, "ANALOG", [Parameter.real("GEN_SCALE", 1.0), *empty])
    doc = with_parameters(doc, "FORCE_PLATFORM", [Parameter.whole("USED", 0)])
    doc = with_parameters(doc, "EVENT", [Parameter.whole("USED", 0)])
    doc = with_parameters(doc, "TRIAL", [])
    names = (("COMPANY", "Kinemark"), ("SOFTWARE", "Kinemark"), ("VERSION_LABEL", __version__))
    return with_parameters(doc, "MANUFACTURER", [Parameter.text(name, text) for name, text in names])
