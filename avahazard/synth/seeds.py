"""Random numbers keyed by what they are for, so that one more draw here moves nothing there."""

from __future__ import annotations

import zlib

import numpy as np


def generator(seed: int, key: str) -> np.random.Generator:
    """Generator of the stream `key` of the world `seed`."""
    return np.random.default_rng(np.random.SeedSequence([seed, zlib.crc32(key.encode())]))
