"""The world of the demo: what is hidden in it, and how much there is of it."""

from __future__ import annotations

HIDDEN = "snow-type"
STRENGTH = 2.0
"""Strong enough that few events and few worlds show it, and quickly."""
SEED, N_EVENTS, N_PATHS = 0, 120, 6
