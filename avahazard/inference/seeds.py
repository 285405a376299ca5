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
    hashes = (hashlib.sha256(f"{type(part).__name__}:{part}".encode()).digest() for part in key)
    words = tuple(int.from_bytes(digest[:8], "little") for digest in hashes)
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=words))
