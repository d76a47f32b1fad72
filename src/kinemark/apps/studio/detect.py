"""Detection of a trial, as its screen shows and tries it."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...data import KinemarkError, Validity
from ...data.errors import users_mistake
from ...data.method import Method, parameters_of
from ...detect import Centroids
from ...detect.centroids_method import grey_scale
from ...engine.detection.open_detection import Draft, InFrame, OpenDetection, threshold_of
from ...engine.detection.why import why
from ...engine.settings import STAGES
from . import detect_messages as m
from .shelf import Place

SHOWN = ("threshold", "min_area", "max_area", "min_width", "max_aspect", "inverted")
"""Parameters that the screen changes, as far as the method has them."""
MOST_MARKS = 3000
"""Of one image, that are sent; chosen: more cannot be told apart on a screen."""
STATES: dict[Validity, m.MarkState] = {
    Validity.VALID: "marker", Validity.TOO_SMALL: "too small", Validity.TOO_LARGE: "too large",
    Validity.NOT_ROUND: "not round", Validity.AT_EDGE: "at edge", Validity.MASKED: "masked",
}  # fmt: skip
OPERATED = "An operator digitises this trial: change this before the first answer, or the answers may fit no more."


def detection(opened: OpenDetection, place: Place) -> m.Detection:
    """How markers are detected, as the session says it."""
    every = STAGES["detect"].of(_every(opened))
    own = opened.table.get("cameras", {})
    drawn = opened.drawn()
    cameras = []
    for name, source in opened.sources.items():
        there = drawn.polygons[drawn.cameras.index(name)] if drawn and name in drawn.cameras else ()
        masks = [[(float(x), float(y)) for x, y in polygon] for polygon in there]
        width, height = source.size
        said = {key: value for key, value in own.get(name, {}).items() if key in SHOWN}
        tall = bool(source.interlaced)
        cameras.append(m.DetectCamera(name=name, width=width, height=height, tall=tall, own=said, masks=masks))
    return m.Detection(
        trial=place.name, session=opened.session.settings.name, method=every.name, first=opened.first,
        last=opened.first + opened.n_frames - 1, parameters=_parameters(opened), cameras=cameras,
        learned=not opened.operated, every=opened.every, words=OPERATED if opened.operated else "",
    )  # fmt: skip


def found_in(opened: OpenDetection, body: m.DetectFrameBody) -> m.DetectFrame:
    """What is found in a frame; raises a KinemarkError where there is no such camera, or it says what cannot be."""
    draft = draft_of(body.draft)
    opened.methods(draft)
    names = body.cameras or list(opened.sources)
    return m.DetectFrame(frame=body.frame, cameras=[_camera(opened, name, body.frame, draft) for name in names])


def why_there(opened: OpenDetection, body: m.WhyBody) -> m.PlaceWhy:
    """Why there is a marker or none at a place; raises a KinemarkError where there is no such place."""
    found = opened.detected(body.camera, body.frame, draft_of(body.draft))
    with users_mistake():
        said = why(found, body.u, body.v, v_offset=opened.sources[body.camera].v_offset(body.frame - 1))
    return m.PlaceWhy(words=said.words, parameter=said.parameter, value=said.value)


def draft_of(said: m.DetectDraft) -> Draft:
    """What the page tries, as the engine has it."""
    masks = {name: tuple(np.array(polygon, float) for polygon in of) for name, of in said.masks.items()}
    if not all(np.isfinite(polygon).all() for of in masks.values() for polygon in of):
        raise KinemarkError("The corners of a mask are finite numbers, px.")
    return Draft(said.every, said.cameras, masks)


def _camera(opened: OpenDetection, name: str, frame: int, draft: Draft) -> m.CameraFound:
    try:
        found = opened.detected(name, frame, draft)
    except KinemarkError as error:
        image = opened.image(name, frame)
        return m.CameraFound(
            name=name, threshold=None, inverted=False, ground=False, limits={}, marks=[],
            histogram=_histogram(image), refused=str(error),
        )  # fmt: skip
    offset = opened.sources[name].v_offset(frame - 1)
    return m.CameraFound(
        name=name, threshold=None if found.method is None else _shown_level(found), inverted=found.inverted,
        ground=found.ground, limits=_limits(found.method), marks=_marks(found, offset),
        histogram=_histogram(found.image),
    )  # fmt: skip


def _marks(found: InFrame, offset: float) -> list[m.Mark]:
    blobs = found.blobs
    columns = zip(blobs.uv, blobs.width, blobs.height, blobs.validity, blobs.merged, strict=True)
    return [
        m.Mark(u=uv[0], v=uv[1] - offset, width=w, height=h, state=STATES[Validity(state)], merged=bool(merged))
        for (uv, w, h, state, merged), _ in zip(columns, range(MOST_MARKS), strict=False)
    ]


def _shown_level(found: InFrame) -> float:
    """The threshold in the grey levels of the picture that is shown."""
    assert found.method is not None
    return threshold_of(found.method) * grey_scale(found.image.dtype) / 2 ** OpenDetection.shift(found.image)


def _histogram(image: Any) -> list[int]:
    shown = image >> OpenDetection.shift(image) if image.dtype != np.uint8 else image
    counts: list[int] = np.bincount(np.minimum(shown, 255).reshape(-1), minlength=256).tolist()
    return counts


def _limits(method: Method | None) -> dict[str, float]:
    """Threshold and sizes that were used, with what was learned."""
    used = method.limits._asdict() if isinstance(method, Centroids) else {}
    return {name: float(used.get(name, getattr(method, name, np.nan))) for name in SHOWN[:-1] if hasattr(method, name)}


def _every(opened: OpenDetection) -> Method:
    return opened.session.settings.detect


def _parameters(opened: OpenDetection) -> list[m.DetectParameter]:
    every, found = _every(opened), []
    for one in parameters_of(type(every)):
        if one.name in SHOWN:
            low, high = one.range.low, one.range.high
            high = one.range.below if high is None else high
            found.append(
                m.DetectParameter(
                    name=one.name, whole=one.kind == "whole number", flag=one.kind == "true or false", unit=one.unit,
                    low=low, high=None if high is None or np.isinf(high) else high, meaning=one.meaning,
                    stated=getattr(every, one.name),
                )
            )  # fmt: skip
    return found
