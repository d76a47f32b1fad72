"""`kinemark aspect`: what makes a camera's pixels square."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ...data.errors import users_mistake
from ..output import Json, print_result


def aspect(
    images: Annotated[list[Path], Parameter(negative="")],
    *,
    threshold: Annotated[float | None, Parameter(help="Grey level above which a pixel is white, 0 to 255.")] = None,
    inverted: Annotated[bool, Parameter(negative="", help="Black markers on a white background.")] = False,
    json: Json = False,
) -> None:
    """Find the aspect ratio of pixels from a bar of markers that is turned before a camera.

    The bar is turned in steps, in a plane that faces the camera. What V must be multiplied by is then said to
    kinemark um2as as --aspect-ratio, or in a session as aspect_ratio of [cameras].

    Args:
        images: a video, or images as 'bar/%04d.png'; several, each of a camera.
        threshold: of white pixels; each image's own without it.
        inverted: the threshold's type.
    """
    from ...detect import Centroids
    from ...engine.bar_aspect import bar_aspect_of_file

    with users_mistake():
        method = Centroids(threshold=threshold, inverted=inverted)
    found = {str(one): bar_aspect_of_file(one, method=method) for one in images}
    if json:
        print_result({name: one.figures() for name, one in found.items()})
    else:
        print_result("\n".join(f"{name}: {one.said()}" for name, one in found.items()))
