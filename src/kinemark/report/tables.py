"""The tables and key figures of the report, as plain texts, and the lines above them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from .formatting import count, measure, number, percent
from .words import place_of_reason, reason_text
from .words.template import listed

MOST_ROWS = 200
"""Of a table on a page; chosen (see benchmarks/pages.py)."""


@dataclass(frozen=True, slots=True)
class Table:
    """A table of plain texts.

    Attributes:
        head: of the columns; the first column is the rows' heading.
        rows: of cells.
        marked: which rows are tinted; those beyond its end are not.
        absent: what stands in place of a table without rows.
        note: below it.
        texts: whether the cells are words, which begin on the left.
        kept_in: the file that has the rows which are too many for the page.
    """

    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    marked: Sequence[bool] = ()
    absent: str = ""
    note: str = ""
    texts: bool = False
    kept_in: str = "quality.json"

    @property
    def shown(self) -> Sequence[Sequence[str]]:
        """The rows that are on the page."""
        return self.rows[:MOST_ROWS]

    def is_marked(self, row: int) -> bool:
        """Whether a row is tinted."""
        return row < len(self.marked) and self.marked[row]

    def known(self) -> Table:
        """The same without columns that are dashes in every row, as those of a leg without markers."""
        kept = [k for k, cells in enumerate(zip(*self.rows, strict=True)) if k == 0 or set(cells) != {number(None)}]
        if not self.rows:
            return self
        return replace(self, head=[self.head[k] for k in kept], rows=[[row[k] for k in kept] for row in self.rows])


class Tile(NamedTuple):
    """A key figure, what it is, and what else there is to say."""

    value: str
    name: str
    more: str


def calibration_table(cameras: list[dict[str, Any]]) -> Table:
    """A row a camera: what it is and where it stands."""
    head = ["camera", "image (px)", "position x, y, z (mm)", "focal length x, y (px)", "calibration RMS (px)"]
    head += ["1 px at the subject (mm)"]
    return Table(head, [_calibrated(camera) for camera in cameras])


def _calibrated(camera: dict[str, Any]) -> list[str]:
    size = camera["size_px"]
    return [
        camera["name"],
        f"{size[0]} × {size[1]}" if size else "–",
        _list(camera["position_mm"], 0),
        _list(camera["focal_px"], 1),
        number(camera["calibration_residual_px"], 2),
        number(camera["pixel_at_subject_mm"], 2),
    ]


def camera_table(cameras: list[dict[str, Any]], inconsistent: Iterable[str]) -> Table:
    """A row a camera: what it saw and how well it agrees; the inconsistent ones are marked."""
    head = ["camera", "detections", "a frame: mean (least–most)", "frames without", "invalid", "used"]
    head += ["residual: median (px)", "RMS (px)", "95 % (px)", "offset u, v (px)"]
    inconsistent, before = set(inconsistent), [c["residual_as_calibrated_px"] for c in cameras]
    rows = [_saw(c) for c in cameras]
    if any(one is not None for one in before):
        head.append("median as calibrated (px)")
        rows = [[*row, "the same" if one is None else number(one, 2)] for row, one in zip(rows, before, strict=True)]
    return Table(head, rows, marked=[c["name"] in inconsistent for c in cameras])


def spots_table(cameras: list[dict[str, Any]]) -> Table:
    """A row a camera: how many spots, how many of them valid, and the others by reason."""
    reasons = list(cameras[0]["invalid"]) if cameras else []
    head = ["camera", "spots", "valid", "of them separated", *(reason.replace("_", " ") for reason in reasons)]
    rows = [
        [
            camera["name"],
            number(camera["detections"]),
            number(camera["detections"] - sum(camera["invalid"].values())),
            number(camera["separated"]),
            *(number(camera["invalid"][reason]) for reason in reasons),
        ]
        for camera in cameras
    ]
    return Table(head, rows)


def _saw(camera: dict[str, Any]) -> list[str]:
    seen = camera["detections_per_frame"]
    reasons = [f"{name.replace('_', ' ')} {percent(part)}" for name, part in camera["invalid_share"].items() if part]
    return [
        camera["name"],
        number(camera["detections"]),
        f"{number(seen['mean'], 1)} ({number(seen['min'])}–{number(seen['max'])})",
        percent(camera["frames_without_detection_share"]),
        ", ".join(reasons) or ("none" if camera["detections"] else "–"),
        percent(camera["used_share"]),
        *(number(camera[f"residual_{key}_px"], 2) for key in ("median", "rms", "95")),
        _list(camera["offset_px"], 2),
    ]


def marker_table(markers: list[dict[str, Any]], *, gap_s: float) -> Table:
    """A row a marker; those never seen or with a gap longer than `gap_s` are marked."""
    head = ["marker", "samples", "missing", "filled", "edited", "complete", "in view", "seen from–to (s)"]
    head += ["gaps", "longest", "σ (mm)", "σ 95 % (mm)", "jitter (mm)", "residual (mm)", "cameras"]
    marked = [not marker["samples"] or marker["longest_gap_s"] > gap_s for marker in markers]
    return Table(head, [_marker(marker) for marker in markers], marked=marked)


def _marker(marker: dict[str, Any]) -> list[str]:
    samples = [number(marker[f"{key}samples"]) for key in ("", "missing_", "filled_", "edited_")]
    shares = [percent(marker[f"completeness_{key}share"]) for key in ("", "in_view_")]
    span = "–".join(number(marker[f"{key}_seen_s"], 2) for key in ("first", "last")) if marker["samples"] else "never"
    longest = f"{number(marker['longest_gap_frames'])} ({measure(marker['longest_gap_s'], 2, 's')})"
    keys = ("sd_per_axis_mean_mm", "sd_per_axis_95_mm", "jitter_mm", "residual_mean_mm")
    exact = [number(marker[key], 2) for key in keys] + [number(marker["cameras_mean"], 1)]
    return [marker["name"], *samples, *shares, span, number(marker["gaps"]), longest if marker["gaps"] else "–", *exact]


def step_table(steps: list[dict[str, Any]]) -> Table:
    """A row a step with its parameters, so that it can be run again."""
    rows = [
        [
            step["stage"],
            step["method"],
            _parameters(step["parameters"]),
            step["version"],
            step["input"][:12],
            number(step["time_s"], 2),
        ]
        for step in steps
    ]
    return Table(["stage", "method", "parameters", "Kinemark", "input (hash)", "time (s)"], rows)


def _parameters(parameters: dict[str, Any]) -> str:
    return ", ".join(f"{key} = {json.dumps(value, ensure_ascii=False)}" for key, value in parameters.items()) or "none"


def _list(values: Sequence[float | None], decimals: int) -> str:
    known = all(value is not None for value in values)
    return ", ".join(number(value, decimals) for value in values) if known else "–"


def tiles(quality: dict[str, Any]) -> list[Tile]:
    """The key figures."""
    return [*_marker_tiles(quality), *_recording_tiles(quality)]


def _marker_tiles(quality: dict[str, Any]) -> list[Tile]:
    markers, points = quality["trajectories"], quality["points"]
    complete, whole = (percent(markers[f"completeness_{key}share"]) for key in ("in_view_", ""))
    longest = f"longest {measure(markers['longest_gap_s'], 2, 's')}, {count(markers['longest_gap_frames'], 'frame')}"
    median, rms = (measure(points[f"residual_{key}_px"], 2, "px") for key in ("median", "rms"))
    sd = measure(markers["sd_per_axis_mean_mm"], 2, "mm")
    known = markers["completeness_in_view_share"] is not None or not markers["samples"]
    return [
        Tile(
            complete, "complete in view", f"{whole} of the whole trial" if known else "not known: images are left over"
        ),
        Tile(number(markers["gaps"]), "gaps", longest if markers["gaps"] else "within what was seen"),
        Tile(median, "median residual", f"RMS {rms}; images far off count little"),
        Tile(sd, "σ of a position, per axis", _parts_of_sd(markers)),
    ]


def _parts_of_sd(markers: dict[str, Any]) -> str:
    """What of σ is noise, and what stays; only the noise where it is more than σ or that is unknown."""
    noise, steady = (measure(markers[key], 2, "mm") for key in ("jitter_median_mm", "steady_sd_mm"))
    return f"noise {noise}, errors that stay {steady}" if markers["steady_sd_mm"] else f"observed jitter {noise}"


def _recording_tiles(quality: dict[str, Any]) -> list[Tile]:
    recording, points, timing = quality["recording"], quality["points"], quality["timing"]
    tracks = f"{count(quality['tracks']['count'], 'track')}, {number(points['per_frame_mean'], 1)} points a frame"
    trajectories = quality["trajectories"]
    nameless = any(one["name"].startswith("*") for one in trajectories["markers"])
    worn = trajectories["markers_worn"] if nameless else trajectories["count"]
    few = f"{percent(points['fewer_than_3_cameras_share'])} of points in fewer than three"
    frames = f"{count(recording['frames'], 'frame')} at {number(recording['rate_hz'])} Hz"
    return [
        Tile(number(worn), "markers", tracks),
        Tile(number(len(quality["cameras"])), "cameras", few),
        Tile(measure(recording["duration_s"], 2, "s"), "recorded", frames),
        Tile(
            measure(timing["total_s"] or None, 1, "s"),
            "of computing",
            f"{number(timing['frames_per_s'], 0)} frames a second",
        ),
    ]


MOST_UNSURE = 100
"""Rows of unsure tracks that are shown; chosen for the page's size."""


def label_line(labels: Mapping[str, Any]) -> str:
    """By what the markers were named, and how well it fits."""
    if labels["refused"]:
        return "Nothing is named: the template does not fit (see what needs attention)."
    parts = []
    if labels["sources"]:
        parts.append(f"Named by {listed(labels['sources'])}.")
    if labels["fit"] is not None:
        parts.append(f"The trial scores {number(labels['fit'], 2)} of what these score on their own data.")
    if labels.get("undecided"):
        parts.append(f"Not told apart: {'; '.join(listed(pair) for pair in labels['undecided'])}.")
    if labels.get("stated"):
        parts.append(f"{count(labels['stated'], 'track')} named by hand.")
    if labels.get("ghosts_removed"):
        parts.append(f"{count(labels['ghosts_removed'], 'track')} taken for ghosts and left out.")
    return " ".join(parts)


def label_table(labels: Mapping[str, Any]) -> Table:
    """A row a marker; those that are missing or not sure are marked."""
    head = ["marker", "probability", "state", "samples", "pieces", "runner-up"]
    markers = labels["markers"]
    rows = [
        [
            one["name"],
            percent(one["probability"]),
            one["state"],
            number(one["samples"]),
            number(one["pieces"]),
            one["runner_up"] or "–",
        ]
        for one in markers
    ]
    marked = [one["state"] in ("missing", "unsure") for one in markers]
    return Table(head, rows, marked=marked, absent="No marker has a name.")


def unsure_table(labels: Mapping[str, Any], first_frame: int) -> Table:
    """A row for each track whose name is not sure, so that it has none; `first_frame` is the recording's."""
    unsure: Sequence[Mapping[str, Any]] = labels["unsure"]
    rows = [
        [
            one["name"],
            percent(one["probability"]),
            one["runner_up"] or "no marker",
            f"{number(one['first_frame'] + first_frame)}–{number(one['last_frame'] + first_frame)}",
            number(one["samples"]),
        ]
        for one in unsure[:MOST_UNSURE]
    ]
    more = f"And {len(unsure) - MOST_UNSURE} more, in quality.json." if len(unsure) > MOST_UNSURE else ""
    return Table(["probably", "probability", "or", "frames", "samples"], rows, absent="None.", note=more)


MOST_DECISIONS = 200  # shown; chosen for the page's size
MOST_TIMES = 6
"""Of one row; the others are counted; chosen."""

SILENT = "This method of tracking does not tell which of its decisions were close; the method simultaneous does."

Decisions = Sequence[dict[str, Any]]


def ambiguous_table(decisions: Decisions, *, listed: bool) -> Table:
    """A row for each reason about the same markers, reasons that are wrong most often first, and of one the earliest;
    `listed`: whether the tracking tells any."""
    rows = [_decision(own) for own in sorted(grouped(decisions), key=place_of_reason)] if listed else []
    more = f"And {len(rows) - MOST_DECISIONS} more, in quality.json." if len(rows) > MOST_DECISIONS else ""
    head = ["trajectories", "possible", "times", "when (s)", "what was seen"]
    return Table(head, rows[:MOST_DECISIONS], absent="None." if listed else SILENT, note=more, texts=True)


def grouped(decisions: Decisions) -> list[Decisions]:
    """Decisions of one kind about the same trajectories that were close for the same reason."""
    groups: dict[tuple[Any, ...], list[dict[str, Any]]] = {}
    for decision in decisions:
        key = decision["kind"], *decision["trajectories"], decision["reason"]
        groups.setdefault(key, []).append(decision)
    return list(groups.values())


def _decision(own: Decisions) -> list[str]:
    """The cells of one group."""
    first = own[0]
    times = [number(decision["time_s"], 2) for decision in own[:MOST_TIMES]]
    when = ", ".join(times) + (f" … {number(own[-1]['time_s'], 2)}" if len(own) > MOST_TIMES else "")
    return [" ".join(first["trajectories"]), first["kind"], str(len(own)), when, reason_text(own)]


REASONS = {
    "first_two_frames": "in the first two frames",
    "not_found": "markers not found",
    "ambiguous": "ambiguous",
    "reference": "reference",
}


def digitised_line(digitising: dict[str, Any]) -> str:
    """One sentence; `digitising` is that of quality.json, which is empty where files were digitised elsewhere."""
    cameras = digitising["cameras"].values()
    images = sum(camera["frames"] * camera["markers"] for camera in cameras)
    corrected, absent = (sum(camera[key] for camera in cameras) for key in ("corrected", "not_present"))
    return (
        f"An operator digitised this trial: {count(digitising['questions'], 'question')} for {number(images)} images "
        f"of markers ({percent(digitising['questions'] / max(images, 1))}), {count(corrected, 'place')} corrected, "
        f"{number(absent)} not present."
    )


def digitised_table(digitising: dict[str, Any]) -> Table:
    """A row a camera."""
    head = ["camera", "frames", "markers", "questions", *REASONS.values()]
    head += ["proposals taken", "without a question", "corrected", "not present"]
    keys = ("proposals_confirmed", "proposals_taken_unasked", "corrected", "not_present")
    rows = [
        [
            name,
            *(number(camera[key]) for key in ("frames", "markers", "questions")),
            *(number(camera["questions_by_reason"][key]) for key in REASONS),
            *(number(camera[key]) for key in keys),
        ]
        for name, camera in digitising["cameras"].items()
    ]
    return Table(head, rows)
