"""What is said where cameras that share enough views do not fit each other."""

from ...data import KinemarkError


class Misfit(KinemarkError):
    """Cameras do not fit each other: one of them may be late, mirrored, another one's, or have been moved meanwhile."""


class NoBeginning(Misfit):
    """There are not even cameras to begin with, that might tell since when they do not fit."""
