"""Constants of nature and of the numerics."""

from __future__ import annotations

from typing import Any

GRAVITY = 9.81
"""Acceleration of gravity, m/s²."""

KEEPS_NAN = {"contract"}
"""Fast-math flags of the kernels: products and sums may fuse; NaN and inf keep their meaning."""

KERNEL: dict[str, Any] = {"cache": True, "error_model": "numpy", "fastmath": KEEPS_NAN}
"""How kernels are compiled: once for all processes; a division by zero gives inf or nan."""
