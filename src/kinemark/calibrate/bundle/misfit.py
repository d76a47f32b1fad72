"""What is said where cameras that share enough views do not fit each other."""

from ...data import KinemarkError


class Misfit(KinemarkError):
    """Cameras do not fit each other: one of them may be late, mirrored, another one's, or have been moved meanwhile.

    Attributes:
        camera: the name of the one that fits worst, where it is told.
    """

    def __init__(self, text: str, camera: str | None = None) -> None:
        super().__init__(text)
        self.camera = camera


class NoBeginning(Misfit):
    """There are not even cameras to begin with, that might tell since when they do not fit."""


class Mirrored(NoBeginning):
    """A camera sees the points of the others mirrored, from whichever pair of them they come."""

    def __init__(self, camera: str) -> None:
        super().__init__(
            f"Camera {camera} sees the others' points mirrored. Check that its images are neither mirrored nor another "
            "camera's, that it is synchronous, and the order of its points; or leave it out.",
            camera,
        )
