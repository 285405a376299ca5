"""What a sampler hands back: draws of named parameters and whether they converged."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.inference.samplers.convergence import Diagnostics, diagnose_chains


@dataclass(frozen=True, slots=True)
class Chains:
    """`draws` is [n_chains, n_draws, n_parameters], in the order and units of `names`, `units`."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    draws: NDArray[np.float64]
    acceptance: NDArray[np.float64]
    diagnostics: Diagnostics

    def pooled(self) -> NDArray[np.float64]:
        """All chains in a row, [n_chains * n_draws, n_parameters]."""
        return self.draws.reshape(-1, self.draws.shape[2])


def chains(
    names: tuple[str, ...],
    units: tuple[str, ...],
    draws: NDArray[np.float64],
    acceptance: NDArray[np.float64] | None = None,
) -> Chains:
    """`Chains` with their diagnostics; without `acceptance` every draw is accepted."""
    rates = np.ones(draws.shape[0]) if acceptance is None else acceptance
    return Chains(names, units, draws, rates, diagnose_chains(draws, rates))
