"""The ways to a calibration and the numbers that people measure for them, in words."""

WAYS = {
    "file": "a ready-made calibration",
    "control_points": "control balls at measured places",
    "control_frame": "hanging rods of markers at measured places",
    "wand": "a wand, waved through the volume",
    "single_marker": "a single marker, moved through the volume",
}
"""By the keys of `[calibration]`."""

NUMBERS = {
    "wand.lengths_mm": ("Gaps between neighbouring markers of the wand, centre to centre, mm", 1, 4, False),
    "wand.marker_diameter_mm": ("Diameter of the wand's spheres, mm", 1, 1, True),
    "l_frame.arms_mm": ("From the L-frame's corner to the marker on its long and short arm, mm", 2, 2, False),
    "l_frame.height_mm": ("Height of the L-frame's markers above the floor, mm", 1, 1, True),
    "control_points.marker_diameter_mm": ("Diameter of the control balls, mm", 1, 1, True),
    "world_points.marker_diameter_mm": ("Diameter of the balls that give the world, mm", 1, 1, True),
    "single_marker.distance.mm": ("Distance of the two markers that give the scale, mm", 1, 1, False),
    "linearisation.pitch_mm": ("Distance of neighbours in the lens grid, mm", 1, 1, False),
}
"""By the key within `[calibration]`: what it is, how many numbers at least and at most, whether it may be left out."""
