"""Random generators keyed by what is computed: any number of workers gives the same bits."""

import hashlib

import numpy as np


def generator(seed: int, *key: str | int) -> np.random.Generator:
    """The random generator of one piece of work, such as ``(seed, "metropolis", path_id, chain)``.

    Strings are hashed with SHA-256, not with Python's salted ``hash``. Type and order of the parts
    of the key matter: ``1`` and ``"1"`` are different work.

    >>> bool(generator(7, "F", 1).random() == generator(7, "F", 1).random())
    True
    """
    words = tuple(_word(part) for part in key)
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=words))


def _word(part: str | int) -> int:
    text = f"{type(part).__name__}:{part}"
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "little")
