"""Constants of nature."""

from __future__ import annotations

GRAVITY = 9.81
"""Acceleration of gravity, m/s²."""
