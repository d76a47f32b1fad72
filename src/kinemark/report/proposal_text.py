"""What images propose for `[detect]`, as part of a session file with the reasons beside the values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from ..detect.proposal import DetectionProposal, Reason
from .words import advice_of, text_of

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


def proposal_text(proposal: DetectionProposal) -> str:
    """The proposal as part of a session file."""
    return "\n".join(_lines(proposal)) + "\n"


def _lines(proposal: DetectionProposal) -> Iterator[str]:
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
