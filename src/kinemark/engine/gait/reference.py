"""A reference band from a laboratory's own controls: what `kinemark gait-reference` does."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ...data import KinemarkError
from ...data.gait_curves import GaitReference
from ...gait.gait_cycles import reference_of
from ...gait.gait_trial import REACTION, REACTION_AXES
from ...io.files import check_new
from ...io.gait_reference import control_axes, control_curves, control_numbers, read_reference, write_reference


def reference_of_files(controls: Sequence[Path], *, output: Path, source: str) -> GaitReference:
    """Read the `gait.json` of each control, one a subject, and write their band.

    Raises:
        KinemarkError: there are fewer than two, one is given twice, a file cannot be read or was made by an earlier
            version along other axes, or the band exists or cannot be written.
    """
    if len(controls) < 2:
        raise KinemarkError("A reference wants the gait.json of two or more controls, one a subject.")
    paths = [path.resolve() for path in controls]
    if twice := [path.name for path in controls if paths.count(path.resolve()) > 1]:
        raise KinemarkError(f"{twice[0]} is given twice, and would count as two subjects. Give each control once.")
    if output.resolve() in paths:
        raise KinemarkError(f"{output} is one of the controls. Give another -o: what you gave is never overwritten.")
    check_new(output)
    axes = {name[1:]: own for name, own in control_axes(controls).items()}
    band = reference_of([control_curves(p) for p in controls], source, [control_numbers(p) for p in controls])
    band = band._replace(axes={name: axes[name] for name in band.mean})
    write_reference(output, band)
    return band


def read_band(path: Path) -> GaitReference:
    """A band whose ground reactions, where it has any, are along the way of walking.

    Raises:
        KinemarkError: the file is no band, or its reactions are along other axes, as those of earlier versions.
    """
    band = read_reference(path)
    if REACTION in band.mean and band.axes.get(REACTION) != REACTION_AXES:
        raise KinemarkError(
            f"{path} does not say that its {REACTION} is {', '.join(REACTION_AXES)}: earlier versions had it along the "
            "axes of the laboratory. Make the band again from its controls, state its axes, or take the curve out."
        )
    return band
