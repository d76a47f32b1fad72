"""C3D: angles, moments, powers and forces are quantities with units; nothing of them is lost on the way."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import KinemarkError, MarkerTrajectory, Signal, Signals, Trajectories, Trial, same
from kinemark.io.c3d import (
    Parameter,
    decode_document,
    document_of,
    encode_document,
    read_c3d,
    stored,
    trial_of,
    with_parameters,
)
from support.shared import ROOT, shared_data

RATE, N = 100.0, 30
GAIT = ("pig_gait_child/HC030A05", "pig_gait_3plates_emg/PiG_Motion3_FF", "pig_wholebody/Movement_trial")
UNITS = {"angle": "deg", "force": "N", "moment": "Nmm", "power": "W", "scalar": "mm"}
"""What these files state; Plug-in Gait's moments and powers are per kg all the same."""


def again(trial):
    return trial_of(decode_document(encode_document(document_of(trial)), name="made"), name=trial.name)


def numbers(seed=0, axes=3):
    """(N, axes) as single precision holds them."""
    return np.random.default_rng(seed).normal(0, 50, (N, axes)).astype(np.float32).astype(float)


def trial_with(*signals, names="AB"):
    paths = tuple(MarkerTrajectory.measured(name, 4 * numbers(k)) for k, name in enumerate(names))
    return Trial("t", Trajectories(paths, RATE, 5), signals=Signals(signals))


def known(signal, sd):
    """The signal with standard deviations (N, A)."""
    return replace(signal, cov=sd[..., None] ** 2 * np.eye(sd.shape[1]))


# Real files


@pytest.mark.parametrize("name", GAIT)
def test_outputs_of_plug_in_gait_are_signals_in_the_units_of_the_file(name):
    trial = read_c3d(shared_data(f"mocap3d/{name}.c3d"))
    doc = trial.source
    for kind, listed in (("angle", "ANGLES"), ("force", "FORCES"), ("moment", "MOMENTS"), ("power", "POWERS")):
        found = trial.signals.of_kind(kind)
        assert len(found) > 5 and set(found.names) <= set(doc.texts("POINT", listed))
        assert {signal.unit for signal in found} == {UNITS[kind]}
    labels = doc.texts("POINT", "LABELS")
    for signal in trial.signals:
        raw = doc.points[:, labels.index(signal.name)]
        seen = np.isfinite(signal.values).all(1)
        assert np.array_equal(signal.values[seen], raw[seen])  # per kg or not, the numbers are the file's
        assert signal.rate == trial.trajectories.rate and len(signal) == trial.trajectories.n_frames
        assert signal.description == doc.texts("POINT", "DESCRIPTIONS")[labels.index(signal.name)]
    outputs = {
        label for kind in ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS") for label in doc.texts("POINT", kind)
    }
    assert not outputs & set(trial.trajectories.names)
    assert len(trial.trajectories) + len(trial.signals) == doc.points.shape[1]


@pytest.mark.parametrize(
    "path", sorted(str(p.relative_to(ROOT)) for p in ROOT.glob("mocap3d/pig*/*.c3d")) or ["mocap3d"]
)
def test_signals_come_back_from_a_file_of_their_own(path):
    """Without the source, so that all of it is written anew."""
    trial = read_c3d(shared_data(path))
    back = again(replace(trial, source=None))
    assert [same(a, b) for a, b in zip(trial.signals, back.signals, strict=True)].count(False) == 0
    assert back.trajectories.names == trial.trajectories.names
    assert same(again(back).signals, back.signals)


# Laws


def test_units_kinds_axes_and_deviations_come_back():
    angle = known(Signal.of("elbow", "angle", "deg", numbers(1), rate=RATE, axes=("flexion", "angle 2", "pronation")),
                  1 + np.abs(numbers(2)))  # fmt: skip
    many = (
        angle,
        Signal.of("knee", "angle", "rad", numbers(3), rate=RATE),
        Signal.of("moment", "moment", "N·m", numbers(4), rate=RATE),
        Signal.of("per kg", "moment", "N·m/kg", numbers(5), rate=RATE),
        Signal.of("envelope", "emg", "mV", numbers(6, 1), rate=RATE, axes=("tibialis anterior",)),
        replace(
            Signal.of("speed", "scalar", "m/s", numbers(7, 2), rate=RATE, axes=("x", "y")), description="of the belt"
        ),
        Signal.of("silent", "force", "", numbers(8), rate=RATE),
    )
    trial = trial_with(*many)
    doc, notes = stored(trial)
    back = trial_of(doc, name="t")
    assert not notes and same(back.trajectories.xyz, trial.trajectories.xyz)
    assert back.signals.names == trial.signals.names
    for old, new in zip(trial.signals, back.signals, strict=True):
        assert same(replace(old, cov=np.full_like(old.cov, np.nan)), replace(new, cov=np.full_like(new.cov, np.nan)))
    assert np.allclose(back.signals["elbow"].sd, angle.sd, rtol=1e-6)
    assert back.signals["elbow"].axes == angle.axes and "elbow SD" in doc.texts("POINT", "ANGLES")
    assert same(again(back).signals, back.signals) and same(again(back).trajectories, back.trajectories)


def test_numbers_that_did_not_change_keep_their_bytes_when_others_do():
    sd = 1 + np.abs(numbers(9))
    elbow = known(Signal.of("elbow", "angle", "deg", numbers(1), rate=RATE), sd)
    first = again(trial_with(elbow, Signal.of("GRF", "force", "N", numbers(2), rate=RATE)))
    moved = replace(first.signals["GRF"], values=first.signals["GRF"].values + 1)
    back = again(replace(first, signals=first.signals.updated(Signals((moved,)))))
    assert same(back.trajectories, first.trajectories) and same(back.signals["elbow"], first.signals["elbow"])
    assert np.array_equal(back.signals["GRF"].values, moved.values.astype(np.float32))


def test_a_marker_between_angles_stays_there_and_new_ones_come_last():
    kept = again(trial_with(Signal.of("knee", "angle", "deg", numbers(1), rate=RATE)))
    labels = ("A", "knee", "B")
    doc = with_parameters(kept.source, "POINT", [Parameter.text("LABELS", labels)])
    order = [0, 2, 1]
    trial = trial_of(replace(doc, points=doc.points[:, order], word=doc.word[:, order]), name="t")
    assert trial.trajectories.names == ("A", "B") and document_of(trial).texts("POINT", "LABELS") == labels
    more = replace(
        trial, signals=trial.signals.updated(Signals((Signal.of("hip", "angle", "deg", numbers(2), rate=RATE),)))
    )
    assert document_of(more).texts("POINT", "LABELS") == (*labels, "hip")
    without = again(replace(trial, signals=Signals()))
    assert not len(without.signals) and without.trajectories.names == ("A", "B")


def test_a_kind_that_no_longer_is_is_not_listed():
    trial = again(trial_with(Signal.of("knee", "angle", "deg", numbers(1), rate=RATE)))
    marker = MarkerTrajectory.measured("knee", numbers(3))
    as_marker = replace(trial, signals=Signals(), trajectories=replace(trial.trajectories, paths=(marker,)))
    assert again(as_marker).trajectories.names == ("knee",)
    (signal,) = trial.signals
    as_moment = again(replace(trial, signals=Signals((replace(signal, kind="moment", unit="N·m"),))))
    assert (as_moment.signals["knee"].kind, as_moment.signals["knee"].unit) == ("moment", "N·m")


# What three numbers a frame cannot hold


def said(*signals):
    return [(note.kind, note.what) for note in stored(trial_with(*signals))[1]]


def test_other_rates_and_starts_are_laid_on_the_frames_and_said():
    line = np.arange(400)[:, None] / 250.0 * [1.0, -2.0, 0.5]
    signal = Signal.of("m", "moment", "N·m", line, rate=250.0)
    back = again(trial_with(signal)).signals["m"]
    assert np.allclose(back.values, np.arange(N)[:, None] / RATE * [1.0, -2.0, 0.5], atol=1e-6)
    assert said(signal) == [("resampled", "signals"), ("cut", "signals")]
    late = replace(Signal.of("m", "moment", "N·m", numbers(1)[:10], rate=RATE), start=0.05)
    found = again(trial_with(late)).signals["m"].values
    assert np.isnan(found[:5]).all() and np.array_equal(found[5:15], numbers(1)[:10]) and np.isnan(found[15:]).all()
    assert said(late) == []


def test_what_is_left_out_is_said():
    holed = numbers(1)
    holed[3, 1] = np.nan
    full = np.broadcast_to(np.eye(3) + 0.5, (N, 3, 3))
    axes = ("a", "b", "c", "d")
    assert said(Signal.of("s", "force", "N", holed, rate=RATE)) == [("incomplete", "signals")]
    assert said(Signal.of("s", "force", "N", numbers(1, 4), rate=RATE, axes=axes)) == [
        ("not_written", "components beyond the third of")
    ]
    assert said(replace(Signal.of("s", "force", "N", numbers(1), rate=RATE), cov=full)) == [
        ("not_written", "correlations between components of")
    ]


def test_a_marker_and_a_signal_of_one_name_are_refused():
    with pytest.raises(KinemarkError, match="marker called A, as a signal is"):
        document_of(trial_with(Signal.of("A", "angle", "deg", numbers(1), rate=RATE)))


def test_nonsense_in_our_group_is_passed_over():
    trial = again(trial_with(Signal.of("knee", "angle", "deg", numbers(1), rate=RATE, axes=("p", "q", "r"))))
    for kind, axes in (("nonsense", "p;q;r"), ("angle", "p;q;r;s")):
        rows = {"SIGNALS": ["knee"], "SIGNAL_KINDS": [kind], "SIGNAL_UNITS": ["x"], "SIGNAL_AXES": [axes]}
        doc = with_parameters(trial.source, "KINEMARK", [Parameter.text(n, rows[n]) for n in rows])
        found = trial_of(doc, name="t").signals["knee"]
        assert (found.kind, found.unit, found.axes) == ("angle", "deg", ("x", "y", "z"))
