"""The methods of detection, each in a file of its own beside this one.

They are called as `function(images, first, method=…)` with frames (n, H, W) of grey levels, of which the first has
the number `first`, and give `Blobs`. A method that has a parameter `relative_threshold`, beside `threshold` and
`inverted`, may leave its threshold to what a camera shows (`levels`).
"""

from ..data.method import Stage

DETECT = Stage("detect", "kinemark.detect", default="centroids", meaning="markers in images")


def check_areas(least: int, greatest: int) -> None:
    """Refuse areas of markers of which the least is greater than the greatest.

    Raises:
        ValueError: it is.
    """
    if least > greatest:
        raise ValueError(f"areas are {least} … {greatest}, wanted min_area no greater than max_area")
