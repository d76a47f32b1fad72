"""Small images of discs, and an operator who knows where they are."""

from functools import cache

import numpy as np

from kinemark.digitise import (
    Absent,
    Accept,
    DigitisingPhase,
    Point,
    SemiAutomatic,
    Yes,
    advance,
    begin,
    drive,
    find_markers,
    result,
)

SIZE = (160, 120)
RADIUS = 4
V, U = np.mgrid[: SIZE[1], : SIZE[0]]


def image(places):
    """White discs at (n, 2) px on black."""
    out = np.full(U.shape, 10, np.uint8)
    for u, v in np.asarray(places, float).reshape(-1, 2):
        if np.isfinite(u):
            out[np.hypot(U - u, V - v) <= RADIUS] = 220
    return out


def film(paths):
    """Looks of (M, F, 2) px."""

    @cache
    def image_markers(f):
        return find_markers(image(paths[:, f]))

    return image_markers


def straight(n_frames, *, start=((40.0, 40.0), (100.0, 80.0)), speed=((2.0, 1.0), (-1.0, 0.0))):
    f = np.arange(n_frames)[:, None]
    return np.array(start)[:, None] + np.array(speed)[:, None] * f


def method(n, **options):
    return SemiAutomatic(tuple(f"m{k + 1}" for k in range(n)), **options)


class Shown:
    """An operator who knows the paths (M, F, 2), and says what is not there."""

    def __init__(self, paths):
        self.paths, self.asked = paths, []

    def __call__(self, question, state):
        self.asked.append(question)
        if question.phase is DigitisingPhase.REVIEW:
            return Accept()
        if question.phase in (DigitisingPhase.REFERENCE, DigitisingPhase.VERIFY):
            return Yes()
        place = self.paths[question.marker, question.frame]
        return Point(*np.rint(place)) if np.isfinite(place).all() else Absent()

    def pointed(self):
        return [(q.frame, q.marker) for q in self.asked if q.phase is DigitisingPhase.POINT]


def run(paths, m, shown=None, **options):
    operator = Shown(paths if shown is None else shown)
    state = drive(operator, film(paths), n_frames=paths.shape[1], method=m, **options)
    return result(state, method=m), operator


def third_frame(paths, m, images):
    """The state after two frames were digitised by hand."""
    state = begin(paths.shape[1], images, method=m)
    for f in range(2):
        for place in paths[:, f]:
            state = advance(state, Point(*np.rint(place)), images, method=m)
        state = advance(state, Accept(), images, method=m)
    return state
