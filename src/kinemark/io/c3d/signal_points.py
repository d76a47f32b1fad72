"""Quantities among the points of a C3D file, as Plug-in Gait stores its own: a point each, listed by kind.

POINT:ANGLES lists the labels of angles, POINT:ANGLE_UNITS says their unit, and so for forces, moments, powers and
scalars; these are the five kinds that C3D knows. A point holds three numbers at every frame. A quantity whose standard
deviation is known has a second point, its name with ` SD`, listed beside it. What that cannot say stands in a group of
our own, a row a quantity: KINEMARK:SIGNALS their labels, SIGNAL_KINDS, SIGNAL_UNITS and SIGNAL_AXES what they are.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from ...data import Signal, Signals
from ...data.array_types import Floats
from ...data.signals import XYZ
from ..notes import FileNote
from .analog_rates import SAME_RATE, SAME_TIME, seconds_beyond
from .document import C3D, with_parameters
from .parameter_tables import with_text
from .parameters import Parameter
from .points import kinds_of
from .provenance import GROUP

SD = " SD"
TYPES = {"angle": "ANGLES", "force": "FORCES", "moment": "MOMENTS", "power": "POWERS", "scalar": "SCALARS"}
KIND_OF = {listed: kind for kind, listed in TYPES.items()}
BETWEEN = ";"
"""Between the axes of one quantity in SIGNAL_AXES."""


class SignalPoint(NamedTuple):
    """One point that is no marker: label, the parameter that lists it, numbers (F, 3), NaN: missing, and text."""

    name: str
    listed: str
    xyz: Floats
    description: str | None = None


def type_of(kind: str) -> str:
    """The parameter that lists quantities of a kind; SCALARS has those that C3D does not know."""
    return TYPES.get(kind, "SCALARS")


def unit_of(doc: C3D, listed: str) -> str:
    """The unit of all points that a parameter lists; empty where the file states none."""
    return next(iter(doc.texts("POINT", _unit_name(listed))), "")


def _unit_name(listed: str) -> str:
    return f"{listed[:-1]}_UNITS"


# Reading


def signals_of(doc: C3D, names: Sequence[str], kinds: Sequence[str], xyz: Floats) -> Signals:
    """The quantities among the points.

    Args:
        doc: the document.
        names: (M) of all points. kinds: (M) LENGTH for markers, else the parameter that lists them.
        xyz: (M, F, 3) NaN where missing.
    """
    row = {name: i for i, name in enumerate(names) if kinds[i] in KIND_OF}
    sd = {name: row[name + SD] for name in _with_sd(row, kinds)}
    stated, texts = stated_signals(doc), doc.texts("POINT", "DESCRIPTIONS")
    found = []
    for name, i in row.items():
        if i in sd.values():
            continue
        kind, unit, axes = stated.get(name, (KIND_OF[kinds[i]], unit_of(doc, kinds[i]), XYZ))
        a = len(axes)
        cov = np.broadcast_to(np.nan, (len(xyz[i]), a, a))
        if name in sd:
            cov = cov.copy()
            cov[:, range(a), range(a)] = xyz[sd[name], :, :a] ** 2
        text = texts[i] if i < len(texts) else ""
        found.append(Signal(name, kind, unit, axes, doc.rate, xyz[i, :, :a], cov, description=text))
    return Signals(tuple(found))


def _with_sd(row: dict[str, int], kinds: Sequence[str]) -> list[str]:
    """The names that have a point with their standard deviation, of the same kind and not one itself."""
    having: list[str] = []
    for name in sorted(row, key=len):
        own = name.removesuffix(SD) in having and name.endswith(SD)
        if not own and name + SD in row and kinds[row[name + SD]] == kinds[row[name]]:
            having.append(name)
    return having


def stated_signals(doc: C3D) -> dict[str, tuple[str, str, tuple[str, ...]]]:
    """Kind, unit and axes of the quantities in the group of our own; rows that make no sense are passed over."""
    columns = [doc.texts(GROUP, name) for name in ("SIGNALS", "SIGNAL_KINDS", "SIGNAL_UNITS", "SIGNAL_AXES")]
    found = {}
    for name, kind, unit, text in zip(*columns, strict=False):
        axes = tuple(text.split(BETWEEN))
        if kind in (*TYPES, "emg") and 1 <= len(axes) <= 3:
            found[name] = (kind, unit, axes)
    return found


# Writing


def points_of(signals: Signals, rate: float, n_frames: int) -> tuple[list[SignalPoint], tuple[FileNote, ...]]:
    """The points that hold the quantities, those of their standard deviations last, and what that changed.

    Args:
        signals: of a trial.
        rate: of its frames, Hz. n_frames: their number.
    """
    points, deviations, notes = [], [], []
    for signal in signals:
        values, own = _on_frames(signal, signal.values, rate, n_frames)
        points.append(SignalPoint(signal.name, type_of(signal.kind), values, signal.description))
        notes += [*own, *_not_held(signal)]
        if np.isfinite(signal.sd).any():
            sd, _ = _on_frames(signal, signal.sd, rate, n_frames)
            deviations.append(SignalPoint(signal.name + SD, type_of(signal.kind), sd))
    return points + deviations, tuple(notes)


def _on_frames(signal: Signal, values: Floats, rate: float, n: int) -> tuple[Floats, list[FileNote]]:
    """(F, 3) the first three components (N, A) at the frames, zeros for those that there are not, NaN: missing."""
    out, notes, names = np.zeros((n, 3)), [], (signal.name,)
    wide = min(3, values.shape[1])
    first = signal.start * rate
    if abs(signal.rate - rate) <= SAME_RATE * rate and abs(first - round(first)) <= SAME_TIME:
        row = np.arange(n) - round(first)
        there = (row >= 0) & (row < len(values))
        out[there, :wide] = values[row[there], :wide]
        out[~there] = np.nan
    else:
        at = (np.arange(n) / rate - signal.start) * signal.rate
        for a in range(wide):
            out[:, a] = np.interp(at, np.arange(len(values)), values[:, a], np.nan, np.nan) if len(values) else np.nan
        notes.append(FileNote("resampled", "signals", names, {"rate_hz": signal.rate, "stored_rate_hz": rate}))
    beyond = seconds_beyond(signal.start, len(values) / signal.rate, n / rate)
    if beyond * signal.rate > 1 - SAME_TIME:
        notes.append(FileNote("cut", "signals", names, {"seconds": beyond}))
    out[~np.isfinite(out).all(1)] = np.nan  # C3D marks a sample as missing, not a component
    return out, notes


def _not_held(signal: Signal) -> Iterable[FileNote]:
    """What three numbers a frame leave out."""
    known, a = np.isfinite(signal.values), len(signal.axes)
    if (known.any(1) & ~known.all(1)).any():
        yield FileNote("incomplete", "signals", (signal.name,))
    if a > 3:
        yield FileNote("not_written", "components beyond the third of", (signal.name,))
    if a > 1 and np.nan_to_num(signal.cov[:, ~np.eye(a, dtype=bool)]).any():
        yield FileNote("not_written", "correlations between components of", (signal.name,))


def with_listed(doc: C3D, names: Sequence[str], listed: Sequence[str]) -> C3D:
    """The document whose parameters list each point by what it is; `listed` is LENGTH or one of `KIND_OF`."""
    if kinds_of(doc, names) == tuple(listed):
        return doc
    for kind in KIND_OF:
        had = list(doc.texts("POINT", kind))
        other = {name for name, own in zip(names, listed, strict=True) if own != kind}
        now = [name for name in had if name not in other]
        now += [name for name, own in zip(names, listed, strict=True) if own == kind and name not in had]
        if now != had:
            doc = with_text(doc, "POINT", kind, now, [-1] * len(now), had)
    return doc


def with_stated(doc: C3D, signals: Signals) -> C3D:
    """The document with the unit of every kind, and in our own group what POINT cannot say of the quantities."""
    for listed in KIND_OF:
        units = [s.unit for s in signals if type_of(s.kind) == listed]
        if units and unit_of(doc, listed) not in units:
            doc = with_parameters(doc, "POINT", [Parameter.text(_unit_name(listed), units[0])])
    plain = {listed: (kind, unit_of(doc, listed), XYZ) for kind, listed in TYPES.items()}
    odd = [s for s in signals if (s.kind, s.unit, s.axes) != plain[type_of(s.kind)]]
    columns = {
        "SIGNALS": [s.name for s in odd],
        "SIGNAL_KINDS": [s.kind for s in odd],
        "SIGNAL_UNITS": [s.unit for s in odd],
        "SIGNAL_AXES": [BETWEEN.join(s.axes[:3]) for s in odd],
    }
    for name, texts in columns.items():
        had = doc.texts(GROUP, name)
        if list(had) != texts:
            doc = with_text(doc, GROUP, name, texts, [-1] * len(texts), had)
    return doc
