"""The detection of KISS (Shafiq, Tümer and Güler 2001), whole: the present method, and the former one."""

from .kiss_methods import KissNearest, KissScanning
from .steps import detect_nearest, detect_scanning

__all__ = ["KissNearest", "KissScanning", "detect_nearest", "detect_scanning"]
