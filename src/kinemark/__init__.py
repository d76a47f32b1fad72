"""Kinemark: marker-based optical motion capture."""

from .version import __version__

__all__ = ["__version__"]
