"""Streams of random numbers."""

from __future__ import annotations

from avahazard.synth.settings import generator


def test_a_stream_depends_on_its_seed_and_key_alone() -> None:
    draws = {
        (seed, key): generator(seed, key).integers(1 << 60)
        for seed in (0, 1)
        for key in ("volumes", "dates")
    }
    assert len(set(draws.values())) == 4
    assert generator(1, "dates").integers(1 << 60) == draws[1, "dates"]
