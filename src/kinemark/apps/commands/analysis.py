"""`kinemark angles`, `velocities`, `gait`, `gait-reference` and `sensitivity`: what follows from a trial."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ...data import KinemarkError
from ...data.errors import users_mistake
from ...engine.angles.settings import AngleSettings
from ...engine.clusters_said import clusters_of
from ...engine.gait.settings import GaitSettings
from ...io.notes import file_note_figures, file_note_text
from ..output import (
    FailOn,
    Json,
    LengthUnit,
    Partial,
    Rate,
    SelfContained,
    exit_by_verdict,
    print_errors,
    print_note,
    print_result,
)
from ..progress import at_work, progress


def angles(
    trial: Path,
    *,
    model: str | None = None,
    output: Annotated[Path | None, Parameter(alias="-o")] = None,
    static: Path | None = None,
    functional: Path | None = None,
    settings: Annotated[AngleSettings | None, Parameter(name="*")] = None,
    self_contained: SelfContained = False,
    fail_on: FailOn = "red",
    json: Json = False,
) -> None:
    """Joint angles of a trial with their standard deviation: CSV, C3D, a page with curves and a moving stick figure.

    Args:
        trial: a file of trajectories: C3D, TDF, TRC, CSV, HDF5 or TDC.
        model: um2as, isb_upper_limb, isb_shoulder, or a TOML file that describes one; where none is given, the one
            whose markers are all there. Of lower limbs the gait model's angles are taken, as kinemark gait does.
        output: folder of the results; beside the trial, its name and _angles, where none is given.
        static: trial that shows the points which clusters of markers carry.
        functional: trial whose motion shows the joint centres of the model.
        settings: how angles are taken.
    """
    from ...engine.angles.of_trial import angles_of_file, folder_beside, model_of_file
    from ...report.terminal_summary import angle_summary

    model = model or model_of_file(trial, static=static, settings=settings)
    if model is None:
        gait(
            trial, static=static, functional=functional, output=output or folder_beside(trial),
            self_contained=self_contained, fail_on=fail_on, json=json,
        )  # fmt: skip
        return
    with at_work() as tell:
        tell(f"angles of {trial}")
        result = angles_of_file(
            trial, model=model, folder=output, static=static, functional=functional, settings=settings,
            self_contained=self_contained,
        )  # fmt: skip
    if json:
        print_result(result.figures)
    else:
        notes = "".join(f"\nnote:     {file_note_text(note)}" for note in result.notes)
        print_result(f"{angle_summary(result.figures)}{notes}\nresults:  {result.folder}")
    exit_by_verdict([result.figures["verdict"]["grade"]], fail_on)


def velocities(
    trial: Path,
    output: Path,
    *,
    length_unit: LengthUnit = None,
    rate_hz: Rate = None,
    partial: Partial = False,
    json: Json = False,
) -> None:
    """Velocities and accelerations of markers with their standard deviations, as CSV.

    Args:
        trial: a file of trajectories: C3D, TDF, TRC, CSV, HDF5 or TDC.
        output: the CSV file; an existing one is not replaced.
    """
    from ...engine.derivative_files import derivatives_of_file

    figures = derivatives_of_file(trial, output, rate_hz=rate_hz, length_unit=length_unit, partial=partial)
    if json:
        print_result(figures)
        return
    rows = [
        f"  {one['name']:16} {one['noise_mm']:8.2f} mm {one['velocity_sd_mm_s']:8.1f} mm/s "
        f"{one['acceleration_sd_mm_s2']:9.0f} mm/s²"
        if one["noise_mm"] is not None
        else f"  {one['name']:16} too few samples"
        for one in figures["markers"]
    ]
    heading = "Standard deviations along an axis, medians: noise of positions, velocity, acceleration"
    print_result("\n".join([heading, *rows, f"results:  {output}"]))


def sensitivity(
    session: Path,
    *,
    trial: str | None = None,
    placement_mm: float = 5.0,
    cycles: int = 6,
    centroid_px: float | None = None,
    model: str | None = None,
    markers: Path | None = None,
    rate_hz: Rate = None,
    length_unit: LengthUnit = None,
    partial: Partial = False,
    self_contained: SelfContained = False,
    json: Json = False,
) -> None:
    """Say what limits the accuracy of a trial: noise, lenses, calibration, marker placement, or a camera that is lost.

    Args:
        session: a folder with a session.toml, or such a file.
        trial: its name; the first of the session where none is given.
        placement_mm: how far, along each axis, a marker sits from its landmark (standard deviation).
        cycles: how many cycles a mean is taken over.
        centroid_px: standard deviation of a centroid, px; as the trial's residuals show it where none is given.
        model: rank the joint angles of this model (its name, or a TOML file); else the directions of segments.
        markers: a file of trajectories (C3D, TDF, TRC, CSV, HDF5 or TDC) of the same recording with the names that the
            model wants; the trial's own names where none is given.
    """
    from ...engine.error_budget import error_budget
    from ...report.terminal_summary import sensitivity_summary
    from ...sensitivity import ErrorBudget

    with users_mistake():
        asked = ErrorBudget(placement_mm=placement_mm, cycles=cycles, centroid_sd=centroid_px)
    with progress() as tell:
        found = error_budget(
            session, trial=trial, method=asked, model=model, markers=markers, rate_hz=rate_hz,
            length_unit=length_unit, partial=partial, self_contained=self_contained, progress=tell,
        )  # fmt: skip
    print_result(found.figures if json else f"{sensitivity_summary(found.figures)}\nresults:  {found.page}")


def gait(
    *walks: Path,
    static: Path | None = None,
    functional: Path | None = None,
    measures: Path | None = None,
    marker: tuple[str, ...] = (),
    cluster: tuple[str, ...] = (),
    reference: Path | None = None,
    mvc: Path | None = None,
    output: Annotated[Path | None, Parameter(alias="-o")] = None,
    exports: str = "",
    settings: Annotated[GaitSettings | None, Parameter(name="*")] = None,
    self_contained: SelfContained = False,
    fail_on: FailOn = "red",
    json: Json = False,
) -> None:
    """Gait of walks with named markers: angles, moments, powers, events, time and distance, with error bars.

    Args:
        walks: trials of one subject: C3D or another file of trajectories; or a folder, for all its C3D, TRC, TDF and
            TDC files but those of --static, --functional and --mvc; of a recording in two formats one, C3D first.
        static: a standing trial, for the feet.
        functional: a motion that turns the hips in all directions, which shows their centres.
        measures: TOML file of the subject's measures; as the files state them, else estimated, where none is given.
        marker: the file's name of one of the gait model's markers, as SACR=sacrum; may be given for each marker.
        cluster: three or more markers that carry a segment, calibrated in the static trial, as "left thigh=A,B,C"; may
            be given for the pelvis, and for thigh, shank and foot of each side.
        reference: band of controls, as kinemark gait-reference writes it: drawn grey, and scored against.
        mvc: trial of the muscles' greatest contractions, which are 100 % of the EMG.
        output: folder of the results; beside the first walk, its name and _gait, where none is given.
        exports: for other programs, as "trc,mot,sto,gcd".
        settings: how gait is computed.
    """
    from ...engine.folders import trials_in
    from ...engine.gait.files import gait_of_files
    from ...engine.gait.trial_files import SubjectFiles, one_of_each
    from ...report.gait_text import gait_summary

    others = (static, functional, mvc)
    every = trials_in(walks, besides=others, say=print_note)
    trials, left_out = one_of_each(every, (*walks, *others))
    with at_work() as tell:
        tell(f"gait of {', '.join(map(str, trials))}")
        given = SubjectFiles(
            trials, left_out, static, functional, mvc, measures, reference, _pairs(marker), clusters_of(cluster)
        )
        result = gait_of_files(given, folder=output, exports=exports, settings=settings, self_contained=self_contained)
    if json:
        print_result(result.figures | {"notes": file_note_figures(result.notes)})
    else:
        notes = "".join(f"\nnote:     {file_note_text(note)}" for note in result.notes)
        print_result(f"{gait_summary(result.figures)}{notes}\nresults:  {result.folder}")
    if result.unusable:
        print_errors({str(path): error for path, error in result.unusable.items()})
        sys.exit(1)
    exit_by_verdict([result.figures["verdict"]["grade"]], fail_on)


def _pairs(markers: tuple[str, ...]) -> dict[str, str]:
    """Names by the model's, of texts such as "SACR=sacrum"."""
    pairs = [text.partition("=") for text in markers]
    if wrong := ["".join(parts) for parts in pairs if not (parts[0].strip() and parts[2].strip())]:
        raise KinemarkError(
            f"--marker {wrong[0]} is not understood. Write the model's name, then the file's: SACR=sacrum."
        )
    return {ours.strip(): theirs.strip() for ours, _, theirs in pairs}


def gait_compare(
    first: Path,
    second: Path,
    *,
    output: Annotated[Path, Parameter(alias="-o")],
    same_markers: bool = False,
    self_contained: SelfContained = False,
    json: Json = False,
) -> None:
    """Two conditions of a subject over each other, as before and after: which differences exceed their own error.

    Args:
        first: gait.json of the first condition, or its folder.
        second: gait.json of the second, or its folder.
        output: folder of the results.
        same_markers: they stayed on the subject in between, with one static trial.
    """
    from ...engine.gait.comparison import compare_gait
    from ...report.gait_text import comparison_summary

    found = compare_gait(first, second, folder=output, same_markers=same_markers, self_contained=self_contained)
    print_result(found.figures if json else f"{comparison_summary(found.figures)}\nresults:  {found.folder}")


def gait_reference(
    *controls: Path,
    output: Annotated[Path, Parameter(alias="-o")],
    source: str = "the laboratory's own controls",
    json: Json = False,
) -> None:
    """A reference band of gait from a laboratory's own controls.

    Args:
        controls: the gait.json of each, one a subject.
        output: file of the band, JSON; an existing one is not replaced.
        source: where the controls are from, as the report will say it.
    """
    from ...engine.gait.reference import reference_of_files

    band = reference_of_files(controls, output=output, source=source)
    said = f"{output}: {len(band.mean)} quantities of {band.subjects} subjects"
    figures = {"written": str(output), "subjects": band.subjects, "quantities": sorted(band.mean)}
    print_result(figures if json else said)
