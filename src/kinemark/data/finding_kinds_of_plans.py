"""Kinds of findings on planned cameras."""

from __future__ import annotations

from .finding import FindingKind as Kind

PLAN_KINDS = (
    Kind("plan_covers", "plan", "info", "The verdict: shares of the walking body's markers (of the places of the "
         "volume where there is no body) that at least two, and at least three cameras measure. Red below 95 % by two, "
         "amber below 99 % by two or 95 % by three.",
         {"camera_count": "count", "two_share": "share", "three_share": "share", "body": "flag"}),
    Kind("plan_error", "plan", "info", "Median and 95th percentile of the predicted standard deviation of a marker's "
         "position, per axis, and the centroids' it was predicted from; calibrated: cameras that state their own "
         "calibration's error.",
         {"sd_median_mm": "mm", "sd_95_mm": "mm", "centroid_px": "px", "body": "flag", "calibrated": "count"}),
    Kind("plan_volume", "plan", "info", "The same shares of the empty volume, and the median standard deviation there.",
         {"two_share": "share", "three_share": "share", "sd_median_mm": "mm"}),
    Kind("plan_following", "plan", "info", "What one more camera would bring, at the best place for it.",
         {"three_share": "share", "three_share_after": "share", "sd_median_mm": "mm", "sd_median_after_mm": "mm"}),
    Kind("plan_camera_most_missed", "plan", "info", "The camera without which fewest is measured: the share that two "
         "cameras measure then, and the median standard deviation.", {"two_share": "share", "sd_median_mm": "mm"}),
)  # fmt: skip
