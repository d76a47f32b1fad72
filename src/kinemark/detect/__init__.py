"""From images to marker centroids."""

from .blobs import Blobs
from .frames import detect_frames
from .kiss import KissNearest, KissScanning
from .masks import Masks, combined_masks, learn_masks
from .method import Centroids
from .proposal import Proposal, propose
from .recording import detect
from .source import Source

__all__ = [
    "Blobs",
    "Centroids",
    "KissNearest",
    "KissScanning",
    "Masks",
    "Proposal",
    "Source",
    "combined_masks",
    "detect",
    "detect_frames",
    "learn_masks",
    "propose",
]
