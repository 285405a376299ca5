"""Frequency of volumes and bounds of the runout."""
