"""Where markers are expected in the next image, and which of its images they take (UM²AS figure 3.14).

With c the places without the image's shift s, by (1) and (2) of `machine`:

1. **Markers** are expected where a straight line through the latest two places takes them, in the image at

       p = c₂ + (c₂ − c₁) (f − f₂) / (f₂ − f₁) + s                       (3)

   With `history` 2 these are the two frames before, f₂ = f − 1 and f₁ = f − 2, and a marker that was not in both is not
   looked for.
2. **The search** takes the white pixel nearest to p on a square of 5 × 5, which grows to 10 × 10, 15 × 15 and so on up
   to 50 × 50 (4). Of all pairs of a marker and an image that a square holds, the nearest is settled first, and an
   image serves one marker (5): a hidden marker so does not take the image of a visible neighbour, which claims its
   own in a smaller square. UM²AS does not say what it does there. Where two images run together and part again the
   wrong one may be the nearer. So with d the distance of centroids from p, marker m is **ambiguous** about its image i,
   and asked for, if another image j that is nobody's, or that of marker n, has

       d_mj < k d_mi   or   d_mj + d_ni < k (d_mi + d_nj)               (6)

   with k the parameter `ambiguity_ratio`.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Bools, Floats
from .image_markers import ImageMarkers, nearest_free
from .semi_automatic import SemiAutomatic
from .state import DigitisedFrame, DigitisingState, MarkerStatus


def searched(
    draft: DigitisedFrame, places: Floats, image_markers: ImageMarkers, method: SemiAutomatic
) -> DigitisedFrame:
    """The frame with the markers found about the places (M, 2) px where they are expected, by (4), (5) and (6)."""
    free = image_markers.usable & ~images_taken(draft, image_markers)
    image_of: dict[int, int] = {}
    for k in range(1, method.expansions + 1):
        while True:
            pairs = []
            for m in np.flatnonzero(draft.found == MarkerStatus.OPEN):
                near = nearest_free(image_markers, places[m], free=free, side=method.grid * k)
                if near is not None:
                    pairs.append((*near, int(m)))
            if not pairs:
                break
            _, image, marker = min(pairs)  # (5)
            draft = draft.put(marker, image_markers.uv[image], MarkerStatus.AUTOMATIC)
            free[image] = False
            image_of[marker] = image
    for ambiguous in _ambiguous(image_of, places, image_markers, free, method):
        draft = draft.put(ambiguous, None, MarkerStatus.AMBIGUOUS)
    return draft


def _ambiguous(
    image_of: dict[int, int], places: Floats, image_markers: ImageMarkers, free: Bools, method: SemiAutomatic
) -> list[int]:
    """The markers of those found, each with its image, that (6) holds for; `free` (B) images are nobody's."""
    owner = {image: m for m, image in image_of.items()}
    reach, k = method.grid * method.expansions / 2, method.ambiguity_ratio
    found = []
    for m, i in image_of.items():
        away = np.hypot(*(image_markers.uv - places[m]).T)
        near = [int(j) for j in np.flatnonzero(np.abs(image_markers.uv - places[m]).max(1) <= reach) if j != i]
        alone = [j for j in near if free[j] and away[j] < k * away[i]]
        both = [
            j
            for j in near
            if j in owner and _swappable(away[j], away[i], image_markers.uv[[i, j]], places[owner[j]], k)
        ]
        if k > 1 and (alone or both):
            found.append(m)
    return found


def _swappable(other: float, own: float, uv: Floats, place: Floats, k: float) -> bool:
    """The second of (6): d_mj, d_mi, the images i and j (2, 2), and where n is expected (2,)."""
    swapped, kept = np.hypot(*(uv - place).T)
    return bool(other + swapped < k * (own + kept))


def images_taken(draft: DigitisedFrame, image_markers: ImageMarkers) -> Bools:
    """(B) which markers of the image serve one of the frame already."""
    uv = draft.uv[np.isfinite(draft.uv[:, 0])]
    return np.asarray((np.abs(image_markers.uv[:, None] - uv).max(-1, initial=0.0) < 1e-9).any(1))


def expected(state: DigitisingState, method: SemiAutomatic) -> Floats:
    """(M, 2) px where markers are expected in the present frame by (3); NaN where too little is known of one."""
    first = max(state.frame - method.history, 0)
    past = [(f, s) for f, s in enumerate(state.saved[first : state.frame], first) if s is not None]
    out = np.full((len(method.markers), 2), np.nan)
    for m in range(len(out)):
        seen = [(f, s.uv[m] - s.shift) for f, s in past if np.isfinite(s.uv[m]).all()]  # (2)
        if len(seen) >= 2 and m != method.fixed:
            (f1, c1), (f2, c2) = seen[-2:]
            out[m] = c2 + (c2 - c1) * (state.frame - f2) / (f2 - f1) + state.draft.shift  # (3)
    if method.fixed >= 0:
        out[method.fixed] = constant_place(state, method)
    return out


def constant_place(state: DigitisingState, method: SemiAutomatic) -> Floats:
    """(2,) px where the reference marker is without a shift; NaN where nobody said it yet."""
    if state.constant is not None:
        return state.constant
    first = state.saved[0] if state.frame else state.draft
    return np.full(2, np.nan) if first is None else first.uv[method.fixed]


def shift_of(state: DigitisingState, method: SemiAutomatic) -> Floats:
    """(2,) px by (1) of `machine`: how far the image has shifted."""
    if method.fixed < 0:
        return np.zeros(2)
    shift = state.draft.uv[method.fixed] - constant_place(state, method)
    if np.isfinite(shift).all():
        return shift
    before = state.saved[state.frame - 1] if state.frame else None
    return np.zeros(2) if before is None else before.shift
