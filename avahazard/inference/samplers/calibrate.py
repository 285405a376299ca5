"""Calibration of a model on observations, by whichever method."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from avahazard.arrays import Floats
from avahazard.effects.effect import Definition, Facts
from avahazard.inference.likelihood.assemble import assemble
from avahazard.inference.model.choices import MethodName
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.paper.calibration import calibrate_paper
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.inference.samplers.calibrated import Calibrated
from avahazard.inference.samplers.marginal import sample

N_CHAINS = 4
N_DRAWS: dict[MethodName, int] = {"marginal": 1000, "metropolis": 5000, "gibbs": 5000}
"""Draws of each chain where the user names none; the marginal method's are nearly independent."""


def calibrate_model(
    observations: Observations,
    specification: Specification,
    facts: dict[str, Facts],
    *,
    method: MethodName = "marginal",
    n_chains: int = N_CHAINS,
    n_draws: int = N_DRAWS["marginal"],
    seed: int = 0,
    own: Sequence[Definition] = (),
    start: Floats | None = None,
    progress: Callable[[float], None] = lambda _share: None,
) -> Calibrated:
    """Calibrate a model on observations; nothing is stored.

    `specification` and `facts` are those of `with_effects`, `own` the user's definitions among
    its effects; `start` `[n_slots]` is where the mode is sought from. Raises `AvahazardError`
    where the method cannot do it.
    """
    if method != "marginal":
        return calibrate_paper(
            observations, specification, method, n_chains=n_chains, n_draws=n_draws, seed=seed
        )
    posterior = assemble(observations, specification, facts, own)
    drawn = sample(
        posterior, n_chains=n_chains, n_draws=n_draws, seed=seed, start=start, progress=progress
    )
    # What the draws came from is in the nodes; the runs of all blocks hold much memory.
    drawn.posterior.nodes.forget_runs()
    model = FittedModel(
        drawn.posterior,
        drawn.coordinates.reshape(-1, drawn.coordinates.shape[2]),
        drawn.offsets_by_group(),
    )
    return Calibrated(model, facts, drawn.chains, observations.n_events)
