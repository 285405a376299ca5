"""Paths, profiles, events and speeds: what was recorded, checked on the way in."""
