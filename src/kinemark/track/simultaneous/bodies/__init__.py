"""Rigid bodies among the tracks, by whose places broken tracks are told."""
