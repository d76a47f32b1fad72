"""Lenses from pictures of plane grids: the points of a picture in their order, and the lens terms that they support."""
