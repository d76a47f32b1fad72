"""Markers followed in the images of two cameras, and the paths brought together in space (KISS section 4)."""
