"""Analog channels and force plates of a trial in a C3D document."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ...data import Analog, ForcePlate, same
from ...data.array_types import Bools, Floats
from .document import C3D, has_unsigned_analog, with_parameters
from .parameter_tables import matched, rows_from, with_descriptions, with_numbers, with_text
from .parameters import Parameter
from .points import mm_per_unit
from .storing_points import FULL_SCALE
from .to_trial import analog_names, analog_scaling, channels_of, plates_of


def with_analog(doc: C3D, source: C3D, analog: Analog | None, *, shift: int, floats: bool) -> C3D:
    """The document with channels; `source` gives the raw numbers and scales that still hold.

    Args:
        doc: the document, with its points. source: where the channels may come from.
        analog: all channels from the first frame to the last, as `analog_rates.on_frames` gives them; None for none.
        shift: the document's first frame, counted from the source's.
        floats: or integers.

    Raises:
        ValueError: samples are missing where the file is to hold integers.
    """
    if analog is None:
        unused = not source.samples or not len(source.analog)
        return replace(doc, analog=source.analog) if unused else replace(doc, samples=0)
    samples, had = analog.values.shape[1] // max(1, len(doc.points)), analog_names(source)
    rows = matched(analog.names, had)
    factor, offset = (rows_from(a, rows, x) for a, x in zip(analog_scaling(source), (1.0, 0.0), strict=True))
    raw, kept = _kept(analog, source, rows, shift, samples)
    factor[(factor == 0) & ~kept.all(1)] = 1.0
    for k, channel in enumerate(
        raw if raw is not source.analog else ()
    ):  # one by one: all at once take several times the file's memory
        with np.errstate(invalid="ignore", divide="ignore"):
            np.copyto(channel, analog.values[k] / factor[k] + offset[k], where=~kept[k])
        channel[:] = channel.astype(np.float32) if floats else channel
    raw = raw if floats else _integers(analog, raw, source, factor, offset, kept)
    doc = replace(doc, analog=raw, samples=samples)
    doc = with_text(doc, "ANALOG", "LABELS", analog.names, rows, had)
    units = (*doc.texts("ANALOG", "UNITS"), *[""] * len(had))[: len(had)]
    doc = with_text(doc, "ANALOG", "UNITS", analog.units, rows, units)
    doc = with_descriptions(doc, "ANALOG", rows, len(had))
    return _with_scaling(doc, rows, factor, offset)


def _kept(analog: Analog, source: C3D, rows: list[int], shift: int, samples: int) -> tuple[Floats, Bools]:
    """Raw numbers (A, N) of the source, and where its values are those of the trial, so that they stand.

    Where all stand they are the source's own, without a copy of what may be most of a file.
    """
    n, had = analog.values.shape[1], source.analog.shape[1]
    kept = np.zeros(analog.values.shape, np.bool_)
    if samples != source.samples:
        return np.zeros(kept.shape), kept
    low, high = (min(max(at, 0), n) for at in (-shift * samples, had - shift * samples))
    there, old = slice(low, high), slice(low + shift * samples, high + shift * samples)
    for row, values in enumerate(channels_of(source)):
        for i in (k for k, of in enumerate(rows) if of == row):
            new, was = analog.values[i, there], values[old]
            kept[i, there] = (new == was) | (np.isnan(new) & np.isnan(was))
    if kept.all() and n == had and rows == list(range(len(source.analog))):
        return source.analog, kept
    raw = np.zeros(kept.shape)
    for i, row in enumerate(rows):
        if row >= 0:
            raw[i, there] = source.analog[row, old]
    return raw, kept


def _integers(analog: Analog, raw: Floats, source: C3D, factor: Floats, offset: Floats, kept: Bools) -> Floats:
    """Raw numbers as integers; channels that do not fit get a factor and an offset of their own, in place."""
    if not np.isfinite(analog.values[~kept]).all():
        raise ValueError("analog has missing samples, which integers cannot hold; write floats")
    unsigned, general = has_unsigned_analog(source), _general(source)
    counts, least = np.rint(raw), 0 if unsigned else -32768
    odd = (counts < least).any(1) | (counts > least + 65535).any(1) | ~kept.any(1)
    if source.floats:
        odd |= (raw != counts).any(1)
    most = np.array([np.abs(np.nan_to_num(one)).max(initial=0.0) for one in analog.values]) / FULL_SCALE
    factor[odd] = (np.where(most > 0, most, 1.0) / general).astype(np.float32)[odd] * general
    offset[odd] = 32768.0 if unsigned else 0.0
    counts[odd] = np.rint(analog.values[odd] / factor[odd, None] + offset[odd, None])
    return counts


def _general(doc: C3D) -> float:
    """ANALOG:GEN_SCALE where it can be divided by, else 1."""
    general = doc.number("ANALOG", "GEN_SCALE", 1.0)
    return general if math.isfinite(general) and general != 0 else 1.0


def _with_scaling(doc: C3D, rows: list[int], factor: Floats, offset: Floats) -> C3D:
    """The document with these factors and offsets, and the other columns of its channels in the new order."""
    if same(analog_scaling(doc), (factor, offset)) and rows == list(range(len(rows))):
        return doc
    general = _general(doc)
    doc = with_parameters(doc, "ANALOG", [Parameter.real("GEN_SCALE", general)])
    doc = with_numbers(doc, "ANALOG", "SCALE", factor / general)
    doc = with_numbers(doc, "ANALOG", "OFFSET", offset, whole=True)
    if (gain := doc.get("ANALOG", "GAIN")) is not None and not gain.is_text:
        doc = with_numbers(doc, "ANALOG", "GAIN", rows_from(doc.numbers("ANALOG", "GAIN"), rows, 1.0), whole=True)
    return doc


def _zero(doc: C3D, plates: tuple[ForcePlate, ...]) -> list[int]:
    """The file's numbers of the first frames that all plates have as their baseline; 1 and 0 where one has none."""
    known = [plate.zero_frames for plate in plates if plate.zero_frames is not None]
    if len(known) < len(plates) or not known:
        return [1, 0]
    first, last = max(k[0] for k in known), min(k[1] for k in known)
    return [int(first) + doc.first_frame, int(last) + doc.first_frame] if first <= last else [1, 0]


def with_plates(doc: C3D, plates: tuple[ForcePlate, ...]) -> C3D:
    """The document with these force plates, whose channels it holds.

    Raises:
        ValueError: a channel of a plate is not among the analog channels.
    """
    if same(plates_of(doc), plates):
        return doc
    factor, names = mm_per_unit(doc), analog_names(doc)
    if lacking := sorted({c for plate in plates for c in plate.channels} - set(names)):
        raise ValueError(f"force plates name the channels {lacking}, which the analog data lack; there are {names}")
    width = max((len(plate.channels) for plate in plates), default=0)
    numbers = [[names.index(c) + 1 for c in plate.channels] for plate in plates]
    table = [row + [0] * (width - len(row)) for row in numbers]
    if len(plates) > 255:
        raise ValueError(f"C3D holds 255 force plates, found {len(plates)}")
    parameters = [
        Parameter.whole("USED", len(plates)),
        Parameter.whole("TYPE", [plate.type for plate in plates]),
        Parameter.whole("CHANNEL", np.array(table, np.int64).reshape(len(plates), width)),
        Parameter.real("CORNERS", np.array([plate.corners / factor for plate in plates]).reshape(-1, 4, 3)),
        Parameter.real("ORIGIN", np.array([plate.origin / factor for plate in plates]).reshape(-1, 3)),
    ]
    if doc.get("FORCE_PLATFORM", "ZERO") is None:
        parameters.append(Parameter.whole("ZERO", _zero(doc, plates)))
    if any(plate.calibration is not None for plate in plates):
        parameters.append(Parameter.real("CAL_MATRIX", _matrices(plates)))
    return with_parameters(doc, "FORCE_PLATFORM", parameters)


def _matrices(plates: tuple[ForcePlate, ...]) -> Floats:
    """(plates, columns, rows) calibrations; zeros where a plate has none."""
    known = [plate.calibration for plate in plates if plate.calibration is not None]
    out = np.zeros((len(plates), max(c.shape[1] for c in known), max(c.shape[0] for c in known)))
    for table, plate in zip(out, plates, strict=True):
        if plate.calibration is not None:
            table[: plate.calibration.shape[1], : plate.calibration.shape[0]] = plate.calibration.T
    return out
