"""Scores of a model against the measurements, and where it fails."""
