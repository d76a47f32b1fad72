"""What a run shows of its input, for whoever recorded it."""
