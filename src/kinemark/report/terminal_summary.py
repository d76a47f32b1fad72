"""What was found, as a few lines for the terminal: a function for each command that prints figures."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ..detect.proposal import DetectionProposal, Reason
from .formatting import degrees, number, percent, signed
from .tables import digitised_line
from .words import TAGS, advice_of, evidence_text, frames_text, headline_of, open_gap_text, sentences_of, text_of


def summary(quality: dict[str, Any]) -> str:
    """A short plain text of what `quality` found: verdict, what was measured, a line a camera, what to do."""
    lines = [f"{quality['session']} / {quality['trial']}: {headline_of(quality['verdict'])}"]
    lines += [f"  {sentence}" for sentence in sentences_of(quality["verdict"])]
    if quality.get("digitising"):
        lines.append(f"  {digitised_line(quality['digitising'])}")
    lines += ["", *_cameras(quality["cameras"])]
    if quality["findings"]:
        lines.append("")
    lines += finding_lines(quality["findings"])
    if quality["timing"]["total_s"]:
        timing = quality["timing"]
        lines += ["", f"  {number(timing['total_s'], 1)} s of computing, {number(timing['frames_per_s'], 1)} frames/s."]
    return "\n".join(lines) + "\n"


def finding_lines(findings: Sequence[Mapping[str, Any]]) -> list[str]:
    """A line a finding: how severe, what, and what to do."""
    return [f"  {one['severity'].upper():5s} {text_of(one)} {advice_of(one)}".rstrip() for one in findings]


def _cameras(cameras: list[dict[str, Any]]) -> list[str]:
    width = max([len("camera"), *(len(camera["name"]) for camera in cameras)])
    head = f"  {'camera':{width}s}  seen/frame   used  median px   95 % px"
    return [head] + [
        f"  {camera['name']:{width}s}  {number(camera['detections_per_frame']['mean'], 1):>10s}"
        f"  {percent(camera['used_share']):>5s}  {number(camera['residual_median_px'], 2):>9s}"
        f"  {number(camera['residual_95_px'], 2):>8s}"
        for camera in cameras
    ]


def angle_summary(figures: dict[str, Any]) -> str:
    """A short plain text: verdict, a line an angle, findings."""
    rows = figures["angles"]
    width = max(len(f"{row['joint']} {row['name']}") for row in rows) if rows else 0
    lines = [f"{figures['trial']}: {headline_of(figures['verdict'])}"]
    lines += [f"  {sentence}" for sentence in sentences_of(figures["verdict"])]
    lines += ["", f"  {'angle, deg':{width}s}   least  greatest    SD  outside"]
    for row in rows:
        lines.append(
            f"  {row['joint'] + ' ' + row['name']:{width}s}  {number(row['least_deg'], 1):>6s}  "
            f"{number(row['greatest_deg'], 1):>8s}  {number(row['sd_median_deg'], 2):>4s}  "
            f"{number(row['outside_frames']):>7s}"
        )
    lines += ["", *finding_lines(figures["findings"])]
    return "\n".join(lines).rstrip() + "\n"


def calibration_summary(figures: dict[str, Any]) -> str:
    """Verdict, what was measured, a line a camera, what to do, and how it differs from the calibration before."""
    lines = [f"{figures['session']}: {headline_of(figures['verdict'])}"]
    lines += [f"  {sentence}" for sentence in sentences_of(figures["verdict"])]
    lines += ["", *_calibrated_cameras(figures["cameras"]), ""]
    lines += finding_lines(figures["findings"])
    return "\n".join(lines + _change(figures["change"])).rstrip() + "\n"


def _calibrated_cameras(cameras: list[dict[str, Any]]) -> list[str]:
    width = max([len("camera"), *(len(camera["name"]) for camera in cameras)])
    head = f"  {'camera':{width}s}  points  residual px  left out px  focal px  lost: error  lost: volume"
    return [head] + [
        f"  {camera['name']:{width}s}  {number(camera['points']):>6s}  {number(camera['residual_rms_px'], 3):>11s}"
        f"  {number(camera['left_out_rms_px'], 3):>11s}  {number(camera['focal_px'][0], 1):>8s}"
        f"  {'× ' + number(camera['without']['ratio_median'], 2):>11s}"
        f"  {percent(camera['without']['newly_unseen_share']):>12s}"
        for camera in cameras
    ]


def _change(change: dict[str, Any] | None) -> list[str]:
    if change is None:
        return []
    rows = [
        f"  {c['name']}: moved {number(c['moved_mm'], 2)} mm, turned {number(c['turned_deg'], 3)}°, focal length "
        f"{signed(100 * c['focal_share'], 2)} %, image shifted {number(c['image_px'], 2)} px"
        for c in change["cameras"]
    ]
    return ["", f"Since the calibration before, kept as {change['since']}:", *rows]


def filling_summary(figures: dict[str, Any]) -> str:
    """The figures as a few lines of text, with what needs attention and the gaps that stayed open."""
    names = ", ".join(f"{name} {n}" for name, n in figures["by_method"].items())
    lines = [f"{headline_of(figures['verdict'])}{': ' + names if names else ''}", *sentences_of(figures["verdict"])]
    lines += [f"  {TAGS[found['severity']]}: {text_of(found)}" for found in figures["findings"]]
    for gap in figures["list"]:
        if not gap["method"]:
            frames = f"frame{'' if gap['frames'] == 1 else 's'} {frames_text(gap)}"
            lines.append(f"  open: {gap['marker']}, {frames}: {open_gap_text(gap, figures['limit_mm'])}")
    return "\n".join(lines)


def plan_summary(figures: dict[str, Any]) -> str:
    """Verdict, and a line a camera."""
    verdict = figures["verdict"]
    lines = [headline_of(verdict), *(f"  {sentence}" for sentence in sentences_of(verdict))]
    if verdict["grade"] != "green":
        lines.append(f"  {advice_of(verdict['statements'][0])}")
    lines += ["", f"  {'camera':12s}        x (mm)  y (mm)  z (mm)   heading   tilt"]
    rows = [(row["name"], "stands" if row["given"] else "new", row) for row in figures["cameras"]]
    rows += [("one more", "next", figures["following"])] if figures["following"] else []
    for name, state, row in rows:
        x, y, z = (number(value, 0) for value in row["position_mm"])
        heading, tilt = number(row["heading_deg"], 0), number(row["tilt_deg"], 0)
        lines.append(f"  {name:12s} {state:6s} {x:>7s} {y:>7s} {z:>7s} {heading + '°':>9s} {tilt + '°':>6s}")
    return "\n".join(lines)


AREAS = "markers have {least_px2:.0f} to {greatest_px2:.0f} px², median {median_px2:.0f}"
REASONS = {
    "threshold": "background {background:.3g}, noise {noise:.2g}, markers' median peak {peak:.3g}{negative}; from "
    "{low:.3g} to {high:.3g} the number of groups hardly changes, {groups_per_frame:.3g} a frame",
    "min_area": AREAS + "; {smaller_per_frame:.2g} smaller groups a frame",
    "max_area": AREAS + "; {larger_per_frame:.2g} larger groups a frame",
    "min_width": "markers are {width_px:.3g} px wide and {height_px:.3g} px high, the median of each",
    "max_aspect": "half of the markers are below {median_aspect:.2f} to 1",
    "near_x": "0.6 of the median width",
    "small_area": "{rows} rows of 0.7 of the median width",
    "small_rows": "0.4 of the median height: rows above the notch of two markers side by side",
    "min_ratio": "{factor:.3g} times wider for its height than a marker is",
    "max_ratio": "{factor:.3g} times higher for its width than a marker is",
}
"""Why a parameter has its value, by the measured numbers of the reason."""


def reason_words(reason: Reason) -> str:
    """Why the parameter has that value."""
    measured: Mapping[str, object] = reason.measured
    negative = " (of the negative)" if measured.get("inverted") else ""
    template = REASONS[reason.parameter]
    for name, nothing in (("smaller_per_frame", "smaller"), ("larger_per_frame", "larger")):
        if name in measured and not measured[name]:
            template = f"{AREAS}; nothing {nothing} was seen"
    return template.format_map({**measured, "negative": negative})


def proposal_text(proposal: DetectionProposal, camera: str) -> str:
    """The proposal of a camera as part of a session file, its masks as part of a file of masks, commented out."""
    return "\n".join([*_proposal_lines(proposal), *_mask_lines(proposal, camera)]) + "\n"


def _mask_lines(proposal: DetectionProposal, camera: str) -> Iterator[str]:
    if not proposal.masks:
        return
    yield '# and in masks.toml, with file = "masks.toml" under [masks]:'
    yield "# [[camera]]"
    yield f"# name = {json.dumps(camera, ensure_ascii=False)}"
    yield f"# size = [{proposal.size[0]}, {proposal.size[1]}]"
    yield "# polygons = ["
    yield from (f"#     {mask.tolist()}," for mask in proposal.masks)
    yield "# ]"


def _proposal_lines(proposal: DetectionProposal) -> Iterator[str]:
    width, height = proposal.size
    yield f"# {proposal.frames} frames of {width} × {height} px, white is {proposal.white}"
    yield from (f"# ! {text_of(found)} {advice_of(found)}".rstrip() for found in proposal.findings)
    if not proposal.reasons:
        yield "# No parameters can be proposed."
        return
    yield "[detect]"
    if proposal.inverted:
        yield "inverted = true"
    kiss = False
    for reason in proposal.reasons:
        if not kiss and not hasattr(proposal.centroids, reason.parameter):
            kiss = True
            yield '# and for method = "kiss_scanning", in the place of min_width and max_aspect:'
        yield f"{'# ' if kiss else ''}{reason.parameter} = {reason.value:g}  # {reason_words(reason)}"


def sensitivity_summary(figures: dict[str, Any]) -> str:
    """Verdict and ranked table for the terminal."""
    n = figures["cycles"]
    lines = [f"{figures['session']} / {figures['trial']}: {headline_of(figures['verdict'])}"]
    lines += [f"  {sentence}" for sentence in sentences_of(figures["verdict"])]
    lines += ["", f"  {'source':18s}   px      mm   angle   mean of {n}   variance   how it is known"]
    for row in figures["ranking"]:
        lines.append(
            f"  {row['source']:18s} {number(row['px'], 3):>6s} {number(row['mm'], 2):>6s} {degrees(row['deg']):>7s} "
            f"{degrees(row['mean_deg']):>11s} {percent(row['variance_share']):>10s}   {evidence_text(row)}"
        )
    total = figures["total"]
    lines.append(
        f"  {'all together':18s} {'':6s} {number(total['mm'], 2):>6s} {degrees(total['deg']):>7s} "
        f"{degrees(total['mean_deg']):>11s}"
    )
    lines += [
        f"  {'without ' + row['camera']:18s} {'':6s} {number(row['mm'], 2):>6s} {degrees(row['deg']):>7s}"
        f"   of the cameras' part alone, {percent(row['gone_share'])} of points gone"
        for row in figures["lost"][:3]
    ]
    return "\n".join(lines) + "\n"
