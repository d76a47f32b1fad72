"""Joint angles of an open trial: with what was said and filled until now, by the session's model or another."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...data import KinemarkError, Origin, Trial
from ...data.array_types import Floats
from ...data.events import Events
from ...data.model_markers import model_names
from ...engine.angles.of_trial import TrialAngles, fits, missing, sided_model, trial_angles
from ...engine.angles.settings import AngleSettings
from ...engine.angles.spikes import spike_cause
from ...engine.keys import digest
from ...engine.naming.label_stage import static_of
from ...engine.um2as.flow import euler_files
from ...findings.plain import runs
from ...geometry import project
from ...io.model_toml import models
from ...io.um2as import ENDINGS
from ...kinematics import InverseCosines, Model, SignedAngles, Template, named_angles, static_template
from ...report.angles_page import angle_table, cycle_table
from ...report.stick import links
from . import angle_messages as a
from .cameras import finding, table
from .desk import OpenDocument
from .export_routes import free_name
from .gaps import chosen_fills
from .header import header
from .session_gait import MARKERS
from .shelf import NotThere


class Basis(NamedTuple):
    """What angles are taken from: the trial, the model, what clusters carry, and how; `choice` says it to the page."""

    trial: Trial
    model: Model
    template: Template | None
    settings: AngleSettings
    choice: a.AngleChoice


def angles_shown(document: OpenDocument, said: a.AngleChoice) -> a.AnglesShown:
    """The angles of a trial as the page shows them; why there are none, where there are none."""
    trial = trial_of(document)
    names = trial.trajectories.names
    shown = a.AnglesShown(
        models=[_model_row(document, name, names) for name in known_models(document)],
        chosen=said,
        words="",
        events=_events(trial.events),
        first_frame=trial.trajectories.first_frame,
        n_frames=trial.trajectories.n_frames,
        rate=trial.trajectories.rate,
        head=document.head,
    )
    try:
        basis = basis_of(document, trial, said)
        result = computed(document, basis)
    except NotThere:
        raise
    except KinemarkError as error:
        return shown.model_copy(update={"words": str(error)})
    return shown.model_copy(update=_result(result, basis))


def spike(document: OpenDocument, body: a.SpikeBody) -> a.Spike:
    """What made an angle leap; raises a KinemarkError where nothing can be said."""
    trial = trial_of(document)
    basis = basis_of(document, trial, a.AngleChoice(**body.model_dump(exclude={"joint", "turn", "frame"})))
    trajectories = trial.trajectories
    method = InverseCosines() if basis.settings.inverse_cosines else SignedAngles()
    found = spike_cause(
        trajectories, model=basis.model, joint=body.joint, turn=body.turn,
        index=body.frame - trajectories.first_frame, template=basis.template, method=method,
    )  # fmt: skip
    camera, residual, seen = worst_image(document, found.marker, found.at)
    frame = found.at + trajectories.first_frame
    words = f"{found.marker} made it in frame {frame}: without its leap the angle is {found.change_deg:.1f}° another. "
    return a.Spike(
        frame=frame, marker=found.marker, change_deg=found.change_deg, camera=camera, residual_px=residual,
        words=words + seen,
    )  # fmt: skip


def worst_image(document: OpenDocument, marker: str, index: int) -> tuple[str | None, float | None, str]:
    """The camera whose image of a marker is farthest from where it should be, by how many px, and it in words."""
    path = next(path for path in chosen_fills(document)[0] if path.name == marker)
    detections, rig = document.editing.timed or document.editing.detections, document.editing.rig
    if path.origin[index] != Origin.MEASURED:
        return None, None, f"It was {Origin(path.origin[index]).name.lower()} there, by no image."
    if detections is None or rig is None or path.detection.shape[1] != len(rig):
        return None, None, "Its images are not known."
    residual = {
        camera.name: float(np.linalg.norm(project(camera, path.xyz[index][None])[0] - detections.uv[row]))
        for camera, row in zip(rig, path.detection[index].tolist(), strict=True)
        if row >= 0
    }
    if not residual:
        return None, None, "Its images are not known."
    camera = max(residual, key=lambda name: residual[name])
    return (
        camera,
        residual[camera],
        f"{len(residual)} cameras saw it; the image of {camera} is farthest off, {residual[camera]:.1f} px.",
    )


def export(document: OpenDocument, said: a.AngleChoice) -> a.EulerFiles:
    """Write `.shd`, `.elb` and `.wst`; of a session's trial among its results, of a file beside it, over nothing.

    Raises:
        KinemarkError: the model has other joints, or a file cannot be written.
    """
    basis = basis_of(document, trial_of(document), said)
    found = computed(document, basis).angles
    if document.trial is not None:
        folder = document.trial.folder / "angles"
        folder.mkdir(parents=True, exist_ok=True)
        written, below = euler_files(found, folder / document.trial.name), f"results/{document.trial.name}/angles/"
    else:
        written, below = euler_files(found, _free_stem(document.place.path)), ""
    return a.EulerFiles(names=[below + path.name for path in written])


def _free_stem(given: Path) -> Path:
    """Beside a file, a name that no file has with any of the three endings."""
    first = given.with_suffix("")
    free = not any(first.with_name(first.name + ending).exists() for ending in ENDINGS.values())
    return first if free else free_name(given, ENDINGS["shoulder"]).with_suffix("")


def trial_of(document: OpenDocument) -> Trial:
    """The trial as people said it is, filled as far as that was chosen, with its events."""
    rows = header(document, None).events
    events = Events(
        tuple(row.label for row in rows), tuple(row.side for row in rows), np.array([row.time_s for row in rows])
    )
    return Trial(document.editing.name, chosen_fills(document)[0], events=events)


def known_models(document: OpenDocument) -> dict[str, str]:
    """Models by the names that the page may say: of Kinemark, and the session's own file."""
    found = {name: name for name in models()}
    if document.trial is not None and (table := document.trial.workspace.settings.angles) is not None:
        own = document.trial.workspace.root / table.model
        found |= {own.stem: str(own)} if own.is_file() else {}
    return found


def _none_fits(known: Mapping[str, str], names: Sequence[str], *, of_file: bool = False) -> str:
    """That no model has all its markers, and what one lacks of which most are there."""
    wanted = {name: sided_model(file, None, names)[0] for name, file in known.items()}
    lacking = {name: missing(model, names) for name, model in wanted.items()}
    near = [name for name in known if 2 * len(lacking[name]) < len(wanted[name].markers)]
    lacks = "".join(f"; {name} lacks {', '.join(lacking[name])}" for name in near)
    if model_names(names).keys() >= MARKERS:
        of_session = "of its session: Gait report on Home makes it and shows it."
        return (
            "This trial has the markers of the gait model, whose angles stand in the gait report "
            f"{'that the command kinemark gait makes of the file.' if of_file else of_session}"
        )
    where = "to the command kinemark angles, by --model" if of_file else "in session.toml, under [angles]"
    return (
        f"No model has all its markers in this trial{lacks}. Name markers on the screen Labels, or state a model of "
        f"your own markers {where}."
    )


def basis_of(document: OpenDocument, trial: Trial, said: a.AngleChoice) -> Basis:
    """What angles are taken from.

    Raises:
        NotThere: there is no such model. KinemarkError: no model fits, or settings do not go together.
    """
    known, names = known_models(document), trial.trajectories.names
    own = None if document.trial is None else document.trial.workspace.settings.angles
    if said.model is not None and said.model not in known:
        raise NotThere(f"There is no model {said.model!r}. There are {', '.join(known)}.")
    usual = None if own is None else Path(own.model).stem if Path(own.model).stem in known else own.model
    fitting = [name for name, file in known.items() if fits(sided_model(file, None, names)[0], names)]
    name = said.model or usual or next(iter(fitting), None)
    if name is None:
        raise KinemarkError(_none_fits(known, names, of_file=document.trial is None))
    settings = AngleSettings() if own is None else own.settings()
    stated = {key: value for key, value in said.model_dump(exclude={"model"}).items() if value is not None}
    if stated.get("smoothing") == "none":
        stated["cutoff_hz"] = None
    if "cycle_event" in stated:
        stated["cycle"] = ()
    settings = replace(settings, **stated)
    chain, _ = sided_model(known[name], settings.side, names)
    choice = a.AngleChoice.like(settings, model=name, side=chain.side)
    return Basis(trial, chain, _template(document, chain), settings, choice)


def _template(document: OpenDocument, chain: Model) -> Template | None:
    """What the session's static trial shows for the model's clusters."""
    earlier = () if document.inputs is None else document.inputs.earlier
    static = static_of(earlier) if chain.clusters else None
    return None if static is None else static_template(static, chain)


def computed(document: OpenDocument, basis: Basis) -> TrialAngles:
    """The angles, taken once for each version of the trial."""
    key = digest(document.head, document.ran, basis.choice.model_dump(), id(basis.trial.trajectories))
    with document.lock:
        known = document.kept.get("angles")
        if known is None or known[0] != key:
            result = trial_angles(basis.trial, model=basis.model, template=basis.template, settings=basis.settings)
            document.kept["angles"] = known = key, result, basis.trial  # so that its id is not given again
        found: TrialAngles = known[1]
        return found


def _result(result: TrialAngles, basis: Basis) -> dict[str, Any]:
    figures, angles, points = result.figures, result.angles, result.points
    pairs = [pair for pair in links(basis.model) if pair[0] in points and pair[1] in points]
    names = list(dict.fromkeys(name for pair in pairs for name in pair))
    tables = [table("Angles", "Tinted: beyond normal motion.", angle_table(figures))]
    if result.cycles is not None:
        tables.append(table("Cycles", "How the angles differ from cycle to cycle.", cycle_table(figures)))
    return {
        "chosen": basis.choice,
        "headline": figures["verdict"]["headline"],
        "sentences": figures["verdict"]["sentences"],
        "findings": [finding(one) for one in figures["findings"]],
        "tables": tables,
        "joints": [_joint(result, j) for j in range(len(angles.joints))],
        "limb": [a.LimbPoint(name=name, xyz=packed(points[name])) for name in names],
        "links": [(names.index(one), names.index(other)) for one, other in pairs],
        "euler": set(ENDINGS) <= set(angles.joints),
        "errors_stated": figures["noise_from"] == "stated",
    }


def _joint(result: TrialAngles, j: int) -> a.JointShown:
    angles, model, start = result.angles, result.model, result.figures["first_frame"]
    joint = model.joints[j]
    turns = ", ".join(letter + "′" * i for i, letter in enumerate(joint.sequence))
    return a.JointShown(
        index=j,
        name=joint.name,
        about=f"{joint.child} against {joint.parent}, turns about {turns}",
        locked=[(first + start, stop - 1 + start) for first, stop in runs(angles.locked[j])],
        curves=[_curve(result, j, one.turn, one.motion) for one in named_angles(model) if one.joint == j],
    )


def _curve(result: TrialAngles, j: int, turn: int, motion: Any) -> a.AngleCurve:
    angles, cycles = result.angles, result.cycles
    over = None
    if cycles is not None:
        over = a.CycleCurve(
            mean=packed(cycles.mean[j, :, turn]), spread=packed(cycles.spread[j, :, turn]),
            each=packed(cycles.deg[:, j, :, turn]), n=len(cycles.deg),
        )  # fmt: skip
    deg, sd = packed(angles.deg[j, :, turn]), packed(angles.sd[j, :, turn])
    return a.AngleCurve.like(motion, turn=turn, deg=deg, sd=sd, cycles=over)


def packed(values: ArrayLike | Floats) -> str:
    """Numbers as the page reads them."""
    return base64.b64encode(np.asarray(values, "<f4").tobytes()).decode()


def _events(events: Events) -> list[a.EventKind]:
    pairs = list(zip(events.label, events.side, strict=True))
    return [
        a.EventKind(label=label, side=side, times=pairs.count((label, side))) for label, side in dict.fromkeys(pairs)
    ]


def _model_row(document: OpenDocument, name: str, names: tuple[str, ...]) -> a.ModelRow:
    model, _ = sided_model(known_models(document)[name], None, names)
    wants = missing(model, names)
    return a.ModelRow(name=name, fits=not wants, wants=list(wants))
