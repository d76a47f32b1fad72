"""The gait report: what a clinician reads, on one page that prints to A4."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..data.gait_curves import GaitCurves, GaitReference
from .drawing_library import DrawingLibrary, drawing_library, inside
from .figures_gait import KINEMATICS, KINETICS, PLANES, UNITS, emg_figures, panels_figure, trunk_figure
from .formatting import identity_text, measure, number
from .tables import Table
from .templating import render, write_text

NAV = {
    "verdict": "Verdict", "time": "Time and distance", "kinematics": "Angles", "trunk": "Trunk",
    "kinetics": "Moments and powers", "keys": "Key values", "profile": "Profile", "emg": "Muscles",
    "uncertainty": "Uncertainty", "subject": "Subject", "terms": "Methods",
}  # fmt: skip
"""Sections of the page, in their order."""
NAMES = {
    "speed": "walking speed", "cadence": "cadence", "stride_length": "stride length", "stride_time": "stride time",
    "step_length": "step length", "step_time": "step time", "step_width": "step width", "foot_off": "foot off",
    "opposite_foot_off": "opposite foot off", "opposite_foot_strike": "opposite foot strike",
    "single_support": "single support", "double_support": "double support",
}  # fmt: skip
"""Of parameters, in the order of the table."""
WHOLE = {"trial": "its greatest value of the trial", "strides": "the mean of the strides' greatest values"}
"""What 100 % of the EMG are."""
SHOWN = {"mm": ("m", 1000.0, 2), "mm/s": ("m/s", 1000.0, 2), "s": ("s", 1.0, 2), "%": ("%", 1.0, 1),
         "steps/min": ("steps/min", 1.0, 0)}  # fmt: skip
"""How a unit is shown: as what, by what it is divided, with how many decimals."""


def write_gait_page(
    path: Path | str,
    *,
    figures: dict[str, Any],
    curves: Sequence[GaitCurves],
    reference: GaitReference | None = None,
    assets: Path | None = None,
) -> None:
    """Write the page, whole or not at all.

    Args:
        path: of the page, usually `gait.html`.
        figures: of `findings.gait_figures`. curves: what is drawn. reference: the grey band below it.
        assets: folder of the drawing library that pages share; None puts it inside the page.

    Raises:
        KinemarkError: the folder cannot be written.
    """
    write_text(
        path, gait_page(figures=figures, curves=curves, reference=reference, library=drawing_library(path, assets))
    )


def gait_page(
    *,
    figures: dict[str, Any],
    curves: Sequence[GaitCurves],
    reference: GaitReference | None = None,
    library: DrawingLibrary | None = None,
) -> str:
    """The page as text; the drawing library is inside where `library` is None."""
    trials = ", ".join(one["name"] for one in figures["trials"])
    emg = emg_figures(curves)
    trunk = trunk_figure(curves, reference)
    absent = {"emg": not emg, "profile": reference is None, "trunk": trunk is None}
    norm = {} if reference is None else reference.numbers
    return render(
        "gait.html",
        library=library or inside(),
        heading=f"{figures['subject'] or trials}: gait",
        below=f"{identity_text(figures.get('identity'))} · {trials} · Kinemark {figures['kinemark']}",
        nav={k: v for k, v in NAV.items() if not absent.get(k)},
        figures=figures,
        time_table=time_distance_table(figures, norm),
        ways=ways_table(figures),
        key_angles=key_values_table(figures, norm, angles=True),
        key_loads=key_values_table(figures, norm, angles=False),
        measures=measures_table(figures),
        body=body_text(figures),
        model=model_text(figures),
        kinematics=panels_figure(curves, KINEMATICS, reference, heads=PLANES),
        trunk=trunk,
        kinetics=panels_figure(curves, KINETICS, reference),
        emg=emg,
        emg_whole=WHOLE.get(whole := figures.get("emg_whole", "trial"), f"its greatest value in {whole}"),
        profile=profile_table(figures),
        causes=uncertainty_table(figures),
        consistency=consistency_table(figures),
        harmonics=harmonics_table(figures),
    )


Norm = Mapping[str, tuple[float, float]]
"""Mean and SD of numbers of the reference, by name."""


def time_distance_table(figures: dict[str, Any], norm: Norm | None = None) -> Table:
    """A row a parameter: left and right, mean ± spread between strides, the measurement's own deviation; the
    reference's mean ± SD."""
    rows = []
    numbers = [list(figures["time_distance"][side].values()) for side in ("left", "right")]
    for name, title in NAMES.items():
        unit, by, digits = SHOWN[figures["units"][name]]
        row = [f"{title} ({unit})"]
        for side in ("left", "right"):
            one = figures["time_distance"][side][name]
            row += [_mean_and_spread(one, by, digits), "–" if not one["sd"] else _small(one["sd"] / by, digits)]
        row += ["–" if name == "step_width" else number(_symmetry(figures, name), 1)]
        rows.append(row + ([_normal(norm, name, by, digits)] if norm else []))
    head = [*_sides_head(*numbers), "left − right (% of mean)", *(["reference"] if norm else [])]
    return Table(head, rows, kept_in="gait.json").known()


def _normal(norm: Norm, name: str, by: float, digits: int) -> str:
    """Mean ± SD of the reference; a dash where it has none."""
    if name not in norm:
        return "–"
    return " ± ".join(number(value / by, digits) for value in norm[name])


KEY_DIGITS = {"deg": 1, "N/kg": 1}
"""Decimals of a key value by its unit; two of the others."""


def key_values_table(figures: dict[str, Any], norm: Norm | None = None, *, angles: bool) -> Table:
    """A row a key value, of angles or of loads: left and right, mean ± spread between strides, the measurement's
    deviation, the difference; the reference's mean ± SD."""
    rows = []
    keys = [one for one in figures["key_values"] if (one["unit"] == "deg") == angles]
    for key in keys:
        digits = KEY_DIGITS.get(key["unit"], 2)
        row = [f"{key['name']} ({UNITS.get(key['unit'], key['unit'])})"]
        for one in (left := key["left"], right := key["right"]):
            known = one is not None and one["sd"]
            row += ["–" if one is None else _mean_and_spread(one, 1.0, digits)]
            row += [number(one["sd"], digits) if known else "–"]
        row += ["–" if left is None or right is None else number(left["mean"] - right["mean"], digits)]
        rows.append(row + ([_normal(norm, key["name"], 1.0, digits)] if norm else []))
    head = [
        *_sides_head(*([one[side] for one in keys if one[side]] for side in ("left", "right"))),
        "left − right",
        *(["reference"] if norm else []),
    ]
    return Table(head, rows, absent="There are no whole strides.", kept_in="key_values.csv").known()


def _sides_head(left: Sequence[dict[str, Any]], right: Sequence[dict[str, Any]]) -> list[str]:
    """Of the columns of numbers of both sides, with how many strides these are of."""
    head = [""]
    for side, numbers in (("left", left), ("right", right)):
        least, most = (f({one["strides"] for one in numbers if one["strides"]}, default=0) for f in (min, max))
        of = f"mean ± SD of {least} to {most} strides" if least < most else f"mean ± SD of {most} strides"
        head += [f"{side}: {'1 stride' if most == 1 else of}", "measured to ±"]
    return head


def _mean_and_spread(one: dict[str, Any], by: float, digits: int) -> str:
    """As the tables show them; a dash where there is no mean."""
    spread = "" if one["spread"] is None else f" ± {number(one['spread'] / by, digits)}"
    return "–" if one["mean"] is None else number(one["mean"] / by, digits) + spread


def ways_table(figures: dict[str, Any]) -> Table | None:
    """A row a parameter: the means of left and right of each way that is walked; None where there is one."""
    each = figures.get("ways")
    if not each:
        return None
    head, rows = [""], []
    for way in each:
        head += [f"facing {number(way['facing_deg'], 0)}°: {side}" for side in ("left", "right")]
    for name, title in NAMES.items():
        unit, by, digits = SHOWN[figures["units"][name]]
        means = [way["time_distance"][side][name]["mean"] for way in each for side in ("left", "right")]
        rows.append([f"{title} ({unit})", *("–" if m is None else number(m / by, digits) for m in means)])
    count = [way["time_distance"][side]["stride_time"]["strides"] for way in each for side in ("left", "right")]
    rows.append(["strides", *(number(n) for n in count)])
    note = "Each direction of walking by itself; its angle is from the laboratory's x to the left."
    return Table(head, rows, note=note).known()


def _small(value: float, digits: int) -> str:
    """A deviation, with a decimal more where it would be written as nothing."""
    return number(value, digits if value >= 0.95 * 10.0**-digits else digits + 1)


def _symmetry(figures: dict[str, Any], name: str) -> float | None:
    """% by which left exceeds right, of their mean."""
    left, right = (figures["time_distance"][side][name]["mean"] for side in ("left", "right"))
    return None if left is None or right is None or left + right == 0 else 200 * (left - right) / (left + right)


def measures_table(figures: dict[str, Any]) -> Table:
    """What is known of the subject's legs."""
    own = figures["measures"]
    rows = [
        ["leg length (mm)", *(number(own[side]["leg_mm"], 0) for side in ("left", "right"))],
        ["knee width (mm)", *(number(own[side]["knee_mm"], 0) for side in ("left", "right"))],
        ["ankle width (mm)", *(number(own[side]["ankle_mm"], 0) for side in ("left", "right"))],
    ]
    turned = {"thigh_wand_deg": "thigh wand outwards (°)", "shank_wand_deg": "shank wand outwards (°)",
              "torsion_deg": "tibial torsion outwards (°)"}  # fmt: skip
    for name, title in turned.items():
        if any(own[side][name] for side in ("left", "right")):
            rows.append([title, *(number(own[side][name], 1) for side in ("left", "right"))])
    return Table(["", "left", "right"], rows)


def body_text(figures: dict[str, Any]) -> str:
    """Mass, height and marker diameter of the subject, as far as they are known."""
    own = figures["measures"]
    said = (("Body mass", "mass_kg", 1, "kg"), ("Height", "height_mm", 0, "mm"),
            ("Marker diameter", "marker_diameter_mm", 0, "mm"))  # fmt: skip
    return " · ".join(f"{name} {measure(own.get(key), digits, unit)}" for name, key, digits, unit in said)


MODEL_WORDS: dict[str, str | dict[Any, str]] = {
    "name": {"physical": "moments by Newton and Euler", "plug_in_gait": "as Plug-in Gait computes it"},
    "hip_centre": "hip joint centre by {}", "inertia": "segments' inertia by {}", "smoothing": "markers smoothed by {}",
    "axes": {True: "axes of knees and ankles as the standing trial shows them",
             False: "axes of knees and ankles by wands and measures"},
    "cutoff_hz": "cut-off {} Hz", "force_cutoff_hz": "forces low-passed at {} Hz",
    "flat_foot": {True: "feet flat in the standing trial", False: "feet as they stood"},
}  # fmt: skip
"""How a parameter of the model is said; the others by their names."""
VALUE_WORDS = {
    "davis": "Davis et al. (1991)", "harrington": "Harrington et al. (2007)", "hara": "Hara et al. (2016)",
    "winter": "Winter (2009)", "de_leva_male": "de Leva (1996), male", "de_leva_female": "de Leva (1996), female",
    "plug_in_gait": "Plug-in Gait", "butterworth": "a Butterworth filter", "woltring": "Woltring's spline",
}  # fmt: skip
"""Names of methods, and their works."""


def model_text(figures: dict[str, Any]) -> str:
    """The method and its parameters, as a sentence."""
    return "; ".join(_model_part(name, value) for name, value in figures["method"].items())


def _model_part(name: str, value: Any) -> str:
    """One parameter of the model in words."""
    words = MODEL_WORDS.get(name, name.replace("_", " ") + " {}")
    if isinstance(words, dict):
        return words.get(value, f"{name.replace('_', ' ')} {value}")
    if name == "smoothing" and value == "none":
        return "markers not smoothed"
    if name == "force_cutoff_hz" and value is None:
        return "forces not filtered"
    if value is None:
        return words.removesuffix(" Hz").format("chosen from the data")
    if isinstance(value, bool):
        return words.format("yes" if value else "no")
    if isinstance(value, float):
        return words.format(f"{value:g}")
    return words.format(VALUE_WORDS.get(str(value), str(value).replace("_", " ")))


def uncertainty_table(figures: dict[str, Any]) -> Table:
    """A row a joint's first component: its standard uncertainty by cause."""
    rows_of = _in_order(figures["uncertainty"])
    causes = list(rows_of[0]["by_cause"]) if rows_of else []
    rows = []
    for row in rows_of:
        each = [row["by_cause"].get(cause, [None])[0] for cause in causes]
        if each.count(None) == len(each):  # of a leg without markers
            continue
        total = sum(value**2 for value in each if value is not None) ** 0.5
        title, digits = _titled(row["name"])
        rows.append([title, number(total, digits), *(number(value, digits) for value in each)])
    return Table(["", "all", *causes], rows, absent="No error bars were asked for.")


_ROWS = {"PelvisAngles": "pelvic tilt", "HipAngles": "hip flexion", "KneeAngles": "knee flexion",
         "AnkleAngles": "ankle dorsiflexion", "HipMoment": "hip extension moment",
         "KneeMoment": "knee extension moment", "AnkleMoment": "ankle plantarflexion moment"}  # fmt: skip


def _in_order(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Of joints from the pelvis to the foot, left beside right."""
    order = list(_ROWS)
    return sorted((r for r in rows if r["name"][1:] in _ROWS), key=lambda r: (order.index(r["name"][1:]), r["name"]))


def _titled(name: str) -> tuple[str, int]:
    """What a row is called, and how many decimals its unit wants."""
    side, moment = {"L": "left", "R": "right"}[name[0]], name.endswith("Moment")
    return f"{side} {_ROWS[name[1:]]} ({'N·m/kg' if moment else '°'})", 3 if moment else 1


def consistency_table(figures: dict[str, Any]) -> Table:
    """A row a quantity: strides, spread, consistency of its first component."""
    rows = []
    for one in _in_order(figures["curves"]):
        spread = [value for row in one["spread"] if (value := row[0]) is not None]
        mean = sum(spread) / len(spread) if spread else None
        title, digits = _titled(one["name"])
        rows.append([title, number(one["strides"]), number(mean, digits), number(one["consistency"][0], 2)])
    few = all(one["strides"] < 2 for one in figures["curves"])
    absent = "One stride of a side says nothing of how strides differ. Give several walks together."
    return Table(["", "strides", "mean spread", "consistency (CMC)"], [] if few else rows, absent=absent)


HARMONIC_ROWS = {"PelvisAngles": 1, "HipAngles": 0, "KneeAngles": 0, "AnkleAngles": 0}
"""Components whose harmonics are shown: pelvic obliquity, as tilt goes twice a stride, and flexions."""


def harmonics_table(figures: dict[str, Any]) -> Table:
    """A row a quantity: amplitude of its first harmonics, and how much of the motion they are."""
    rows, found = [], {(one["name"], one["component"]): one for one in figures["harmonics"]["angles"]}
    for curve in _in_order(figures["curves"]):
        if (axis := HARMONIC_ROWS.get(curve["name"][1:])) is None:
            continue
        one = found[curve["name"], curve["axes"][axis]]
        share = [value for value in one["share"] if value is not None]
        joint = curve["name"][1:].removesuffix("Angles").lower().replace("pelvis", "pelvic")
        title = f"{curve['side']} {joint} {curve['axes'][axis]} (°)"
        held = 100 * sum(share[:3]) if share else None
        rows.append([title, *(number(value, 1) for value in one["amplitude"]), number(held, 0)])
    hz = {side: value for side, value in figures["harmonics"]["stride_hz"].items() if value is not None}
    each = ", ".join(f"{number(value, 2)} Hz on the {side}" for side, value in hz.items())
    note = f"A stride's frequency is {each}." if each else ""
    head = ["amplitude", *(f"{h}×" for h in range(1, 7)), "first three, % of the power"]
    return Table(head, rows, note=note, absent="There are no whole strides.")


def profile_table(figures: dict[str, Any]) -> Table | None:
    """Movement analysis profile and gait profile score of both sides; None without a reference."""
    profile = figures["profile"]
    if profile is None:
        return None
    each = {side: profile[side] for side in ("left", "right")}
    rows = [[name, *(number(each[side]["variables"][name], 1) for side in each)] for name in each["left"]["variables"]]
    rows.append(["gait profile score", *(number(each[side]["score"], 1) for side in each)])
    if any(one["scaled_score"] is not None for one in each.values()):
        rows.append(["score, 100 ± 10 in the controls", *(number(each[side]["scaled_score"], 0) for side in each)])
    both = profile.get("overall_score")
    overall = "" if both is None else f" Overall gait profile score, of both sides: {number(both, 1)}°."
    note = f"Reference: {profile['source']}, {profile['subjects']} subjects.{overall}"
    return Table(["RMS distance from the reference (°)", "left", "right"], rows, note=note).known()
