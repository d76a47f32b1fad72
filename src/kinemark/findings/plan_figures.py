"""A plan of cameras as plain numbers, and the verdict."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..calibrate.quality import VolumeMap
from ..data import Camera, Finding, Severity, make_finding
from ..data.array_types import Floats
from ..planning import BodyCoverage, CameraPlan
from ..version import __version__
from .plain import SCHEMA_VERSION, over_volume, plain, quantile
from .verdict import verdict_of

ALL_SHARE, MOST_SHARE = 0.99, 0.95
"""Shares of the samples that two cameras must measure for green and for amber, and three for green (the lesser);
chosen."""
LEAST_VIEWS = (2, 3, 4)
"""Numbers of cameras that shares are given for; by definition two measure and a third confirms."""


def plan_figures(plan: CameraPlan) -> dict[str, Any]:
    """Everything that the page says, as plain numbers."""
    volume, body = plan.prediction
    figures = plain({
        "kinemark": __version__,
        "schema_version": SCHEMA_VERSION,
        "asked": _asked(plan),
        "candidates": plan.candidates,
        "cameras": [_camera(plan, c) for c in range(len(plan.rig))],
        "volume": {"corners_mm": plan.room.volume} | _volume(volume),
        "body": body and _body(body),
        "map": _map(volume),
        "following": _following(plan),
    })  # fmt: skip
    findings = [_headline(figures), *_statements(figures, _calibrated(plan))]
    figures["findings"] = [found.as_dict() for found in findings]
    figures["verdict"] = verdict_of(findings, findings).as_dict()
    return figures


def _asked(plan: CameraPlan) -> dict[str, Any]:
    """What was asked for."""
    room, sensor, planning = plan.room, plan.sensor, plan.planning
    return {
        "cameras": planning.cameras,
        "marker_diameter_mm": planning.diameter_mm,
        "centroid_px": planning.centroid_px,
        "subject_mm": planning.subject_mm,
        "markers": planning.markers if planning.subject_mm else 0,
        "focal_px": sensor.focal_px,
        "size_px": sensor.size,
        "least_image_px": sensor.least_px,
        "height_mm": room.height_mm,
        "distance_mm": room.distance_mm,
        "walls_mm": room.walls,
    }


def _camera(plan: CameraPlan, c: int) -> dict[str, Any]:
    volume, body = plan.prediction
    without = {"sd_median_mm": over_volume(volume.without[c], 0.5)}
    if body is not None:
        without |= {"body_two_share": body.without[c, 0], "body_sd_median_mm": body.without[c, 1]}
    return {
        "name": plan.rig[c].name,
        "given": c < plan.given,
        **_place(plan.rig[c], plan.room.volume),
        "without": without,
    }


def _place(camera: Camera, volume: Floats) -> dict[str, Any]:
    """Where a camera stands, and how it is turned: heading counter-clockwise from +x, tilt upwards, and the point of
    its axis that is nearest to the middle of the volume."""
    ahead = camera.R[2]
    aim = camera.centre + ahead * float(ahead @ (volume.mean(0) - camera.centre))
    return {
        "position_mm": camera.centre,
        "height_mm": camera.centre[2] - volume[0, 2],
        "heading_deg": float(np.degrees(np.arctan2(ahead[1], ahead[0]))),
        "tilt_deg": float(np.degrees(np.arcsin(np.clip(ahead[2], -1, 1)))),
        "aims_at_mm": aim,
    }


def _volume(volume: VolumeMap) -> dict[str, Any]:
    shares = {f"seen_by_{n}_share": float((volume.seen >= n).mean()) for n in LEAST_VIEWS}
    return shares | {"sd_median_mm": over_volume(volume.sd, 0.5), "sd_95_mm": over_volume(volume.sd, 0.95)}


def _body(body: BodyCoverage) -> dict[str, Any]:
    """Of all samples, and marker by marker."""
    rows = [
        {"marker": name} | _samples(body._replace(views=body.views[m : m + 1], sd=body.sd[m : m + 1]))
        for m, name in enumerate(body.names)
    ]
    return _samples(body) | {"markers": rows}


def _samples(body: BodyCoverage) -> dict[str, Any]:
    shares = {f"seen_by_{n}_share": body.share(n) for n in LEAST_VIEWS}
    return shares | {"sd_median_mm": quantile(body.sd, 0.5), "sd_95_mm": quantile(body.sd, 0.95)}


def _map(volume: VolumeMap) -> dict[str, Any]:
    x, y, z = volume.axes
    return {"x_mm": x, "y_mm": y, "z_mm": z, "sd_mm": np.round(volume.sd, 5), "cameras": volume.seen}


def _following(plan: CameraPlan) -> dict[str, Any] | None:
    """Where one more camera would stand, and what it would bring."""
    if plan.following is None or plan.with_following is None:
        return None
    volume, body = plan.with_following
    return _place(plan.following, plan.room.volume) | {"volume": _volume(volume), "body": body and _samples(body)}


def _calibrated(plan: CameraPlan) -> int:
    """How many cameras state the error of their calibration."""
    return sum(bool(camera.cov.any()) for camera in plan.rig)


def _main(figures: dict[str, Any]) -> dict[str, Any]:
    """What the verdict is about: the body, or the volume where there is none."""
    main: dict[str, Any] = figures["body"] or figures["volume"]
    return main


def _headline(figures: dict[str, Any]) -> Finding:
    main = _main(figures)
    two, three = main["seen_by_2_share"] or 0.0, main["seen_by_3_share"] or 0.0
    severity: Severity = "red" if two < MOST_SHARE else "amber" if two < ALL_SHARE or three < MOST_SHARE else "info"
    return make_finding(
        "plan_covers", severity=severity, camera_count=len(figures["cameras"]), two_share=main["seen_by_2_share"],
        three_share=main["seen_by_3_share"], body=figures["body"] is not None,
    )  # fmt: skip


def _statements(figures: dict[str, Any], calibrated: int) -> Iterator[Finding]:
    main, volume, following = _main(figures), figures["volume"], figures["following"]
    yield make_finding(
        "plan_error", sd_median_mm=main["sd_median_mm"], sd_95_mm=main["sd_95_mm"],
        centroid_px=figures["asked"]["centroid_px"], body=figures["body"] is not None, calibrated=calibrated,
    )  # fmt: skip
    if figures["body"]:
        yield make_finding(
            "plan_volume", two_share=volume["seen_by_2_share"], three_share=volume["seen_by_3_share"],
            sd_median_mm=volume["sd_median_mm"],
        )  # fmt: skip
        yield _most_missed(figures["cameras"])
    if following:
        after = following["body"] or following["volume"]
        yield make_finding(
            "plan_following", three_share=main["seen_by_3_share"], three_share_after=after["seen_by_3_share"],
            sd_median_mm=main["sd_median_mm"], sd_median_after_mm=after["sd_median_mm"],
        )  # fmt: skip


def _most_missed(cameras: list[dict[str, Any]]) -> Finding:
    """The camera whose loss leaves fewest samples, and where several leave as many, the greatest error."""
    worst = min(cameras, key=lambda c: (c["without"]["body_two_share"], -(c["without"]["body_sd_median_mm"] or 0.0)))
    return make_finding(
        "plan_camera_most_missed", cameras=[worst["name"]], two_share=worst["without"]["body_two_share"],
        sd_median_mm=worst["without"]["body_sd_median_mm"],
    )  # fmt: skip
