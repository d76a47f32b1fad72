"""Gait for other programs: TRC, `.mot` and `.sto` by OpenSim's conventions, GCD.

OpenSim has y up: (x, y, z) of a laboratory with z up is (x, z, −y) there. Lengths of markers are mm, of pressure m.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from ...data import KinemarkError, Trial
from ...data.array_types import Floats
from ...data.gait_curves import GaitCurves
from ...data.subject_measures import SIDES
from ...findings.gait_records import GaitOfTrial
from ...gait.gait_trial import ground_contact
from ...gait.time_distance import averages
from ...io.gcd import write_gcd
from ...io.opensim_storage import write_storage
from ...io.trc import write_trc

Export = Literal["trc", "mot", "sto", "gcd"]
ENDINGS = {
    "trc": (".trc",), "mot": ("_angles.mot", "_reaction.mot"), "sto": ("_moments.sto",), "gcd": (),
}  # fmt: skip
"""What follows the name of a walk in the name of each file of an export; by definition."""
GCD = "gait.gcd"
"""Of all walks."""
Y_UP = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
"""OpenSim's axes as rows in a laboratory with z up; conventional."""


def exports_of(text: str) -> tuple[str, ...]:
    """Of a text such as "trc,mot".

    Raises:
        KinemarkError: one is unknown.
    """
    asked = tuple(part.strip().lower() for part in text.split(",") if part.strip())
    if unknown := [one for one in asked if one not in get_args(Export)]:
        raise KinemarkError(f"There is no export {unknown[0]!r}. Known are {', '.join(get_args(Export))}.")
    return asked


def export_files(folder: Path, kinds: Sequence[str], names: Sequence[str]) -> list[Path]:
    """All files that `write_exports` may write.

    Args:
        folder: of the results. kinds: of `Export`. names: of the walks.
    """
    each = [folder / f"{name}{ending}" for name in names for kind in kinds for ending in ENDINGS[kind]]
    return [*each, *([folder / GCD] if "gcd" in kinds else [])]


def write_exports(
    folder: Path, kinds: Sequence[str], walks: Sequence[tuple[str, Trial, GaitOfTrial]], curves: Sequence[GaitCurves],
    *, counts: Sequence[str], mass_kg: float | None,
) -> None:  # fmt: skip
    """Write the files that were asked for.

    Args:
        folder: of the results. kinds: of `Export`. walks: name of file, trial and result of each. curves: of all.
        counts: reasons for which a contact counts. mass_kg: of the body.

    Raises:
        KinemarkError: a file cannot be written.
    """
    for stem, trial, one in walks:
        rate = trial.trajectories.rate
        files = {ending: folder / f"{stem}{ending}" for each in ENDINGS.values() for ending in each}
        if "trc" in kinds:
            paths = tuple(replace(p, xyz=p.xyz @ Y_UP.T) for p in trial.trajectories)
            write_trc(files[".trc"], replace(trial.trajectories, paths=paths))
        if "mot" in kinds:
            write_storage(files["_angles.mot"], _of_kind(one, "angle"), rate=rate, in_degrees=True)
            if reactions := _reactions(one, counts):
                write_storage(files["_reaction.mot"], reactions, rate=rate)
        if "sto" in kinds and mass_kg is not None and (moments := _of_kind(one, "moment", times=mass_kg)):
            write_storage(files["_moments.sto"], moments, rate=rate)
    if "gcd" in kinds:
        strides = [stride for *_, one in walks for stride in one.counted]
        means: dict[str, dict[str, float]] = {
            side: {name: mean for name, (mean, _, _) in averages(strides, side).items()} for side in SIDES
        }
        write_gcd(folder / GCD, curves, means)


def _of_kind(one: GaitOfTrial, kind: str, times: float = 1.0) -> dict[str, Floats]:
    """(F) by "LKneeAngles_flexion"."""
    return {
        f"{signal.name}_{axis}".replace(" ", "_"): times * signal.values[:, k]
        for signal in one.gait.signals if signal.kind == kind for k, axis in enumerate(signal.axes)
    }  # fmt: skip


def _reactions(one: GaitOfTrial, counts: Sequence[str]) -> Mapping[str, Floats]:
    """(F) N, m and N·m of both feet, y up; 0 in the air."""
    found: dict[str, Floats] = {}
    for side in SIDES if one.gait.reactions else ():
        contact = ground_contact(side, one.gait.reactions, one.gait.contacts, counts)
        places = np.nan_to_num(contact.centre) / 1000.0
        for name, values in (("ground_force_{}_v", contact.force), ("ground_force_{}_p", places),
                             ("ground_torque_{}_", contact.free_moment)):  # fmt: skip
            turned = values @ Y_UP.T
            found |= {name.format(side) + axis: turned[:, k] for k, axis in enumerate("xyz")}
    return found
