"""Calibration of a model on observations, by whichever method."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from avahazard.arrays import Floats
from avahazard.effects.effect import Definition, Facts
from avahazard.inference.likelihood.assemble import assemble, definitions_of
from avahazard.inference.model.choices import DEFAULT_METHOD, METHODS, MethodName
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.paper.calibration import calibrate_paper
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.inference.samplers.marginal import sample

N_CHAINS = 4


def calibrate_model(
    observations: Observations,
    specification: Specification,
    facts: dict[str, Facts],
    *,
    method: MethodName = DEFAULT_METHOD,
    n_chains: int = N_CHAINS,
    n_draws: int = METHODS[DEFAULT_METHOD].n_draws,
    seed: int = 0,
    own: Sequence[Definition] = (),
    start: Floats | None = None,
    progress: Callable[[float], None] = lambda _share: None,
) -> FittedModel:
    """Calibrate a model on observations; nothing is stored.

    `specification` and `facts` are those of `with_effects`, `own` the user's definitions among
    its effects; `start` `[n_slots]` is where the mode is sought from. Raises `AvahazardError`
    where the method cannot do it.
    """
    if method != DEFAULT_METHOD:
        return calibrate_paper(
            observations, specification, method, n_chains=n_chains, n_draws=n_draws, seed=seed
        )
    posterior = assemble(observations, specification, facts, own)
    model = sample(
        posterior, n_chains=n_chains, n_draws=n_draws, seed=seed, start=start, progress=progress
    )
    # What the draws came from is in the nodes; the runs of all blocks hold much memory.
    model.posterior.nodes.forget_runs()
    return replace(model, definitions=definitions_of(specification, own), facts=facts)
