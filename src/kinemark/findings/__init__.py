"""Figures and verdicts as data: what a trial, a calibration or a filled gap shows, before it is put into words."""
