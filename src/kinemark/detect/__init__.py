"""From images to marker centroids."""

from .blobs import Blobs
from .frames import detect_frames
from .method import Centroids
from .recording import Source, detect

__all__ = ["Blobs", "Centroids", "Source", "detect", "detect_frames"]
