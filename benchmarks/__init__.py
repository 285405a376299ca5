"""Benchmarks and studies; every process of one has one thread (read before numpy is loaded)."""

import os

for _library in ("OMP", "OPENBLAS", "MKL", "NUMBA"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")
