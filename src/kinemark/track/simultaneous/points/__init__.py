"""Positions from images and motion, and points that a later pass finds."""
