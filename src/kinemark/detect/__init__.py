"""From images to marker centroids."""

from ..data.masks import Masks
from .blobs import Blobs
from .centroids_method import Centroids
from .detect_frames import detect_frames
from .detect_recording import detect
from .frame_source import FrameSource
from .kiss import KissNearest, KissScanning
from .masks import combined_masks, learn_masks
from .proposal import DetectionProposal, propose
from .stage import DETECT

__all__ = [
    "DETECT",
    "Blobs",
    "Centroids",
    "DetectionProposal",
    "FrameSource",
    "KissNearest",
    "KissScanning",
    "Masks",
    "combined_masks",
    "detect",
    "detect_frames",
    "learn_masks",
    "propose",
]
