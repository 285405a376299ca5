"""Constants of nature and of the numerics."""

GRAVITY = 9.81
"""Acceleration of gravity, m/s²."""

KEEPS_NAN = {"contract"}
"""Fast-math flags of the kernels: products and sums may fuse; NaN and inf keep their meaning."""
