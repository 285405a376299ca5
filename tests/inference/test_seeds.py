"""Seeds depend on what is computed and on nothing else."""

from __future__ import annotations

import subprocess
import sys

import numpy as np

from avahazard.inference.seeds import generator


def test_same_key_gives_the_same_numbers() -> None:
    first = generator(3, "metropolis", "Gurraz", 2).random(5)
    again = generator(3, "metropolis", "Gurraz", 2).random(5)
    np.testing.assert_array_equal(first, again)


def test_every_part_of_the_key_matters() -> None:
    keys: list[tuple[str | int, ...]] = [("a", 1), ("a", 2), ("b", 1), (1, "a"), ("a", "1"), ("a",)]
    states = {tuple(generator(0, *key).integers(2**62, size=2)) for key in keys}
    states |= {tuple(generator(1, *key).integers(2**62, size=2)) for key in keys}
    assert len(states) == 2 * len(keys)


def test_another_process_gives_the_same_numbers() -> None:
    code = "from avahazard.inference.seeds import generator as g; print(g(1, 'é', 4).integers(1e9))"
    outputs = {
        subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True
        ).stdout
        for _ in range(2)
    }
    assert outputs == {f"{generator(1, 'é', 4).integers(1e9)}\n"}
