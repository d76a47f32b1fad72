"""The detection of KISS (Shafiq, Tümer and Güler 2001), whole: the present method, and the former one."""

from .detect import detect_nearest, detect_scanning
from .method import KissNearest, KissScanning

__all__ = ["KissNearest", "KissScanning", "detect_nearest", "detect_scanning"]
