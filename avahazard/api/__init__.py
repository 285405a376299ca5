"""Regions and models as objects, for notebooks and scripts."""
