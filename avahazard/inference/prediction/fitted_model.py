"""A fitted model: its posterior over some events, and the draws of its parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.choices import MethodName
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.model.volumes import VolumeNodes


@dataclass(frozen=True, slots=True, eq=False)
class FittedModel:
    """A model on the events of `posterior`, with draws of its parameters, all chains in a row.

    `draws` `[n_draws, n_slots]` are coordinates in the order of the posterior's layout; `offsets`
    `[n_draws]` are those of log friction by group (path, winter, storm), for the groups that it
    was fitted on. What scatters is friction, but for the method metropolis the stop's elevation.
    """

    posterior: Posterior
    draws: Floats
    offsets: Mapping[str, Floats]
    method: MethodName = "marginal"

    @property
    def observations(self) -> Observations:
        """The events that the model is applied to."""
        return self.posterior.observations

    @property
    def specification(self) -> Specification:
        """What the model is made of."""
        return self.posterior.specification

    @property
    def sigma_m(self) -> Floats | None:
        """Scatter of the stop's elevation in metres `[n_draws]`; None where friction scatters."""
        if self.method != "metropolis":
            return None
        return np.asarray(np.exp(self.draws[:, self.posterior.layout.scatter]))

    def on(self, observations: Observations) -> FittedModel:
        """The same model and draws on other events."""
        if self.method != "marginal":
            observations = replace(observations, volumes=exact_volumes(observations))
        layout = self.posterior.layout
        grids = {slot.name: slot.grid for slot in layout.slots if slot.grid}
        posterior = Posterior(observations, self.specification, self.posterior.effects, grids)
        slots = [slot.name for slot in layout.slots]
        return fitted_model(posterior, slots, self.draws, self.offsets, self.method)

    def evenly(self, n: int) -> NDArray[np.int64]:
        """Indices `[n]` of draws, evenly over all of them."""
        return np.linspace(0, len(self.draws) - 1, n).round().astype(np.int64)

    def group_offsets(self, rng: np.random.Generator) -> Floats | None:
        """Draws of the groups' offsets `[n_draws, n_offsets]`, None where there are no groups.

        A group that the model has not seen gets offsets from the spread between groups.
        """
        plan = self.posterior.plan
        if not plan:
            return None
        tau = self.posterior.layout.spread_values(self.draws)
        columns = [
            self.offsets[name]
            if name in self.offsets
            else tau[:, g] * rng.standard_normal(len(tau))
            for name, g in zip(plan.names, plan.of, strict=True)
        ]
        return np.column_stack(columns) if columns else np.empty((len(tau), 0))

    def median_friction(self, volume: Floats) -> Floats:
        """Posterior median `[n_events]` of the median friction of each event.

        `volume` (m3) `[n_events]` is exact; a group that the model has not seen has no offset.
        """
        location = self.posterior.location_and_scatter
        median = np.array([location(u, volume[:, None])[0][:, 0] for u in self.draws])
        if self.posterior.layout.log_scatter:
            median = np.exp(median)
        plan = self.posterior.plan
        if plan:
            none = np.zeros(len(self.draws))
            known = np.column_stack([self.offsets.get(name, none) for name in plan.names])
            median *= np.exp([plan.shift(row) for row in known])
        return np.asarray(np.median(median, axis=0))


def fitted_model(
    posterior: Posterior,
    slots: Sequence[str],
    draws: Floats,
    offsets: Mapping[str, Floats],
    method: MethodName = "marginal",
) -> FittedModel:
    """A model from draws `[n_draws, n_slots]` whose columns are named by `slots`.

    Events with speeds have a slot for their scatter that those without have not; where the model
    was fitted without, it stays at the mean of its prior.
    """
    place = {slot: k for k, slot in enumerate(slots)}
    columns = [
        draws[:, place[slot.name]] if slot.name in place else np.full(len(draws), slot.mean)
        for slot in posterior.layout.slots
    ]
    return FittedModel(posterior, np.column_stack(columns), offsets, method)


def exact_volumes(observations: Observations) -> VolumeNodes:
    """One node at each recorded volume; an event without one keeps the middle of its path's.

    The paper's methods take volumes as exact, and so does what they predict.
    """
    recorded = observations.columns.log_volume
    mean = np.where(np.isfinite(recorded), recorded, observations.volumes.mean)
    return replace(
        observations.volumes,
        log_volume=mean[:, None],
        weight=np.ones((len(mean), 1)),
        mean=mean,
        sd=np.where(np.isfinite(recorded), 0.0, observations.volumes.sd),
    )
