"""Key values of a stride: what clinicians and statisticians read off the curves, a number a stride.

The greatest, least or mean value, or the range, of one component over a phase of the stride. With foot off at o % the
phases are those of the gait cycle (Perry 1992), told by the foot's events alone:

    stance 0 … o,  its halves 0 … o/2 and o/2 … o,  swing o … 100,  about foot off o/2 … (o + 100)/2              (1)

Which values are taken is a choice after Benedetti et al. (1998), powers after Winter (1991): the burst of the hip
extensors H1 and flexors H3, of the ankle A2, and the absorption of the knee K3.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from ..data import Signals
from ..data.array_types import Floats
from ..data.gait_curves import GaitCurves, KeyValue
from ..data.strides import Stride
from ..data.subject_measures import SIDES
from .gait_cycles import POINTS, gait_curves

Phase = Literal["stride", "strike", "stance", "first half of stance", "second half of stance", "foot off", "swing"]
How = Literal["greatest", "least", "mean", "range"]


class Key(NamedTuple):
    """What is read off a curve.

    Attributes:
        name: of the value, without side. curve, axis: the quantity, without side, and its component.
        how: it is read. phase: of the stride, by (1).
    """

    name: str
    curve: str
    axis: int
    how: How
    phase: Phase


KEYS = (
    Key("pelvic tilt, mean", "PelvisAngles", 0, "mean", "stride"),
    Key("pelvic tilt, range", "PelvisAngles", 0, "range", "stride"),
    Key("pelvic obliquity, range", "PelvisAngles", 1, "range", "stride"),
    Key("pelvic rotation, range", "PelvisAngles", 2, "range", "stride"),
    Key("hip flexion at strike", "HipAngles", 0, "mean", "strike"),
    Key("hip flexion, least in stance", "HipAngles", 0, "least", "stance"),
    Key("hip flexion, greatest in swing", "HipAngles", 0, "greatest", "swing"),
    Key("hip flexion, range", "HipAngles", 0, "range", "stride"),
    Key("hip adduction, greatest in stance", "HipAngles", 1, "greatest", "stance"),
    Key("hip adduction, least in swing", "HipAngles", 1, "least", "swing"),
    Key("hip rotation, mean in stance", "HipAngles", 2, "mean", "stance"),
    Key("knee flexion at strike", "KneeAngles", 0, "mean", "strike"),
    Key("knee flexion, greatest in first half of stance", "KneeAngles", 0, "greatest", "first half of stance"),
    Key("knee flexion, least in second half of stance", "KneeAngles", 0, "least", "second half of stance"),
    Key("knee flexion, greatest in swing", "KneeAngles", 0, "greatest", "swing"),
    Key("knee flexion, range", "KneeAngles", 0, "range", "stride"),
    Key("ankle dorsiflexion at strike", "AnkleAngles", 0, "mean", "strike"),
    Key("ankle dorsiflexion, greatest in stance", "AnkleAngles", 0, "greatest", "stance"),
    Key("ankle dorsiflexion, least about foot off", "AnkleAngles", 0, "least", "foot off"),
    Key("ankle dorsiflexion, greatest in swing", "AnkleAngles", 0, "greatest", "swing"),
    Key("ankle dorsiflexion, range", "AnkleAngles", 0, "range", "stride"),
    Key("foot progression, mean in stance", "FootProgressAngles", 1, "mean", "stance"),
    Key("hip extensor moment, greatest in first half of stance", "HipMoment", 0, "greatest", "first half of stance"),
    Key("hip extensor moment, least about foot off", "HipMoment", 0, "least", "foot off"),
    Key("hip abductor moment, greatest in stance", "HipMoment", 1, "greatest", "stance"),
    Key("knee extensor moment, greatest in first half of stance", "KneeMoment", 0, "greatest", "first half of stance"),
    Key("knee extensor moment, least in second half of stance", "KneeMoment", 0, "least", "second half of stance"),
    Key("knee abductor moment, greatest in stance", "KneeMoment", 1, "greatest", "stance"),
    Key("ankle plantarflexor moment, greatest in stance", "AnkleMoment", 0, "greatest", "stance"),
    Key("hip power, greatest in first half of stance (H1)", "HipPower", 0, "greatest", "first half of stance"),
    Key("hip power, greatest about foot off (H3)", "HipPower", 0, "greatest", "foot off"),
    Key("knee power, least about foot off (K3)", "KneePower", 0, "least", "foot off"),
    Key("ankle power, greatest in stance (A2)", "AnklePower", 0, "greatest", "stance"),
    Key("vertical reaction, first peak", "GroundReactionForce", 2, "greatest", "first half of stance"),
    Key("vertical reaction, second peak", "GroundReactionForce", 2, "greatest", "second half of stance"),
)  # fmt: skip
"""All that are taken, in the order of tables; chosen, see above. Signs are those of the curves."""


def key_values(signals: Signals, strides: Sequence[Stride]) -> tuple[KeyValue, ...]:
    """All key values of the strides of one trial, by `KEYS`, then side, then stride; none of curves that are not there.

    Args:
        signals: as `analyse_gait` gives them. strides: of both sides, that count.
    """
    wanted = {key.curve for key in KEYS}
    read = Signals(tuple(signal for signal in signals if signal.name[1:] in wanted))
    curves = {(one.name[1:], one.side): one for one in gait_curves(read, strides)}
    found: list[KeyValue] = []
    for key in KEYS:
        for side in SIDES:
            if (curve := curves.get((key.curve, side))) is not None and key.axis < len(curve.axes):
                first = [stride.first for stride in strides if stride.side == side]
                found += (_value(key, curve, k, t) for k, t in enumerate(first))
    return tuple(found)


def _value(key: Key, curve: GaitCurves, stride: int, first: float) -> KeyValue:
    """Of one stride of a curve."""
    y, sd = curve.values[stride, :, key.axis], curve.sd[stride, :, key.axis]
    part = _samples(key.phase, float(curve.foot_off[stride]))
    value, at, u = (np.nan, np.nan, np.nan) if part is None else _read(key.how, y[part], sd[part])
    start = 0 if part is None else part.start
    return KeyValue(key.name, curve.side, first, curve.unit, value, at + start, u)


def _samples(phase: Phase, off: float) -> slice | None:
    """Of a curve that belong to a phase (1); None where foot off is not known."""
    if phase == "stride":
        return slice(0, POINTS)
    if phase == "strike":
        return slice(0, 1)
    if not 0 < off < 100:
        return None
    low, high = {
        "stance": (0.0, off), "first half of stance": (0.0, off / 2), "second half of stance": (off / 2, off),
        "foot off": (off / 2, (off + 100) / 2), "swing": (off, 100.0),
    }[phase]  # fmt: skip
    return slice(int(np.ceil(low)), int(np.floor(high)) + 1)


def _read(how: How, y: Floats, sd: Floats) -> tuple[float, float, float]:
    """Value, its place among the samples, and its standard uncertainty; a systematic one does not average out."""
    if not len(y) or not np.isfinite(y).all():
        return np.nan, np.nan, np.nan
    if how == "range":
        return float(np.ptp(y)), np.nan, np.nan
    if how == "mean":
        return float(y.mean()), 0.0 if len(y) == 1 else np.nan, float(np.sqrt(np.mean(sd**2)))
    k = int(np.argmax(y) if how == "greatest" else np.argmin(y))
    return float(y[k]), float(k), float(sd[k])
