"""Calibration of a camera from photos of a board with known points."""
