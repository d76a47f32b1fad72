"""EMG of walks: which channels of a trial are EMG, and what of each is 100 %."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from contextlib import suppress

import numpy as np

from ...data import Analog, KinemarkError, Trial
from ...gait.emg import Emg, emg, peak_of

MUSCLE = re.compile(
    r"(?i)\brect|rectus|vast|ham(s\b|string)|bicep|tricep|semi(t|m)|gastroc|(^|[lr_ .])gast\b|soleus|"
    r"tib[a-z]*[ _.-]*(ant|post)|perone|fibularis|glut|adductor|gracil|sartor|deltoid|trapez|erector|latissimus|"
    r"pectoral|brachi"
)
"""Names of muscles, whole and as they are usually cut short, by which a channel without a unit is EMG; conventional."""
SHORT = re.compile(
    r"(?i)([lr][ _.-]?)?(ta|tp|gm|gl|mg|lg|gas|sol|rf|vl|vm|vi|bf|st|sm|pl|pb|gmax|gmed|ham|quad|add)([ _.-]?[lr])?"
)
"""Letters of muscles, with a side or without one, as the whole name of a channel without a unit; conventional."""
NO_MUSCLE = re.compile(r"(?i)(^|[^a-z])([fmc][xyz]\d*( ?\[\d+\])?$|pin ?\d+)|foot.?switch|sync|trigger|gonio")
"""Names of channels in volts that are no EMG: a plate's before it is scaled, bare pins of a converter, switches."""

MILLIVOLT = {"V": 1000.0, "MV": 1.0, "UV": 0.001, "ΜV": 0.001}
"""mV of the units of EMG, in capitals; by definition."""
UNUSED = re.compile(r"(?i)(^|[^a-z])(spare|unused|not[ _-]?(used|connected))([^a-z]|$)")
"""Names of sockets of EMG into which nothing is plugged; conventional."""


def greatest_contractions(mvc: Trial, wanted: Collection[str]) -> dict[str, float]:
    """Greatest value of the envelope of each channel of a trial of greatest contractions.

    Raises:
        KinemarkError: a channel of the walks is not in it.
    """
    found = {name: peak_of(one.envelope) for name, one in emg_of(mvc).items()}
    if absent := sorted(set(wanted) - set(found)):
        raise KinemarkError(
            f"{mvc.name}: the trial of greatest contractions lacks the channels {', '.join(absent)}; it has "
            f"{', '.join(sorted(found)) or 'none'}. Give one that has all, or leave it out."
        )
    return found


def emg_of(trial: Trial) -> dict[str, Emg]:
    """Of each channel that says EMG, or is in volts and nothing else by its name (`NO_MUSCLE`), or has no unit and the
    name or the letters of a muscle, and no plate's; none whose name says that nothing is plugged in (`UNUSED`).

    One that is no EMG by its samples, too few or too slow, is left out: the rest of the trial is as good without it.
    In mV where the file says a unit, so that recordings of different units can be held against each other.
    """
    found: dict[str, Emg] = {}
    for name, record in _candidates(trial):
        millivolt = MILLIVOLT.get(_letters(record.units[record.names.index(name)]), 1.0)
        with suppress(KinemarkError):
            found[name] = emg(record[name] * millivolt, rate=record.rate, start=record.start)
    return found


def left_out_of(trial: Trial, found: Collection[str]) -> dict[str, str]:
    """Why channels that `emg_of` looks at are not among those that it found, by name."""
    why: dict[str, str] = {}
    for name, record in _candidates(trial):
        if name not in found:
            try:
                emg(record[name], rate=record.rate, start=record.start)
            except KinemarkError as error:
                why[name] = str(error)
    return why


def _candidates(trial: Trial) -> Iterator[tuple[str, Analog]]:
    """Names and records of what `emg_of` looks at."""
    plates = {name for plate in trial.plates for name in plate.channels}
    for record in trial.analog:
        for name, unit in zip(record.names, record.units, strict=True):
            in_volts = _letters(unit) in MILLIVOLT
            named = in_volts or (not _letters(unit) and bool(MUSCLE.search(name) or SHORT.fullmatch(name)))
            is_emg = "EMG" in name.upper() or (named and not NO_MUSCLE.search(name))
            if name not in plates and is_emg and not UNUSED.search(name) and np.ptp(record[name]) > 0:
                yield name, record


def _letters(unit: str) -> str:
    """Of a unit, in capitals."""
    return "".join(c for c in unit.upper() if c.isalpha())
