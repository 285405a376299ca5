"""A fitted model: what it is made of, draws of its parameters, and whether they have converged."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import import_module

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import Definition, Effect, Facts
from avahazard.effects.site import Site
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import Values, resistance_of
from avahazard.inference.model.choices import BLOCK, DEFAULT_METHOD, METHODS, MethodName
from avahazard.inference.model.friction_model import FrictionModel
from avahazard.inference.model.layout import Layout
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.model.volumes import VolumeNodes
from avahazard.notes import Note
from avahazard.physics.cells import Resistance
from avahazard.results.calibration import Calibration, Convergence

RHAT_LIMIT = 1.01
ESS_LIMIT = 400.0
TAIL_PROBABILITY = (0.05, 0.95)
STUCK_ACCEPTANCE = 0.01


def diagnose_chains(draws: Floats, acceptance: Floats | None = None) -> Convergence:
    """R-hat, bulk and tail ESS (Vehtari et al. 2021) and stuck chains.

    `draws` is [n_chains, n_draws, n_parameters], `acceptance` [n_chains] (None: every draw is
    accepted, as in Gibbs). A parameter with one value in all chains is a constant and is left
    out. A chain is stuck when one of the other parameters never moves in it, or when it accepts
    less than 1 % of its proposals. With a stuck chain or a draw that is not finite, there is no
    R-hat and the ESS is 0.
    """
    n_chains = draws.shape[0]
    rates = np.ones(n_chains) if acceptance is None else np.asarray(acceptance, dtype=np.float64)
    low, high = draws.min(axis=1), draws.max(axis=1)
    free = low.min(axis=0) != high.max(axis=0)
    stuck = np.any((low == high)[:, free], axis=1) | (rates < STUCK_ACCEPTANCE)
    n_stuck = int(stuck.sum())
    mean_rate = float(rates.mean())
    if n_stuck or not np.isfinite(draws).all():
        return Convergence(None, 0.0, 0.0, mean_rate, n_stuck, False)
    if not free.any():
        n = float(draws.shape[0] * draws.shape[1])
        return Convergence(1.0, n, n, mean_rate, 0, True)
    array_stats = import_module("arviz_stats.base").array_stats  # slow to import, so only here
    ary = np.moveaxis(draws[:, :, free], 2, 0)
    rhat = float(np.max(array_stats.rhat(ary)))
    bulk = float(np.min(array_stats.ess(ary, method="bulk")))
    tail = float(np.min(array_stats.ess(ary, method="tail", prob=TAIL_PROBABILITY)))
    converged = rhat < RHAT_LIMIT and bulk >= ESS_LIMIT and tail >= ESS_LIMIT
    known = rhat if np.isfinite(rhat) else None
    return Convergence(known, bulk, tail, mean_rate, 0, converged)


@dataclass(frozen=True, slots=True)
class Chains:
    """`draws` is [n_chains, n_draws, n_parameters], in the order and units of `names`, `units`.

    Without `acceptance` [n_chains] every draw is accepted.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    draws: Floats
    acceptance: Floats | None = None
    diagnostics: Convergence = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "diagnostics", diagnose_chains(self.draws, self.acceptance))

    def pooled(self) -> Floats:
        """All chains in a row, [n_chains * n_draws, n_parameters]."""
        return self.draws.reshape(-1, self.draws.shape[2])


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class FittedModel:
    """A model with draws of its parameters, all chains in a row.

    `definitions`, `facts` and `effects` are those of its effects. `draws` `[n_draws, n_slots]` are
    coordinates in the order of `friction.layout`; `offsets` `[n_draws]` are those of log friction
    by group (path, winter, storm), for the groups that it was fitted on. What scatters is
    friction, but for the method metropolis the stop's elevation.

    `columns` describe the events that it is of, those of its calibration unless it was put on
    others; `posterior` is their likelihood, where that is known.

    Of a calibration: `sampled`, the chains of the parameters that people read, the number of
    events that the method cannot use by reason (`left_out`), and sentences for people (`notes`).
    Of a stored model: its calibration as reported (`stored`), the `paths` that it was calibrated
    on (none: all), the `version` of the program that made it, and whether the records have changed
    since.
    """

    specification: Specification
    effects: tuple[Effect, ...]
    friction: FrictionModel
    columns: EventColumns
    draws: Floats
    offsets: Mapping[str, Floats]
    method: MethodName = DEFAULT_METHOD
    definitions: tuple[Definition, ...] = ()
    facts: dict[str, Facts] = field(default_factory=dict)
    likelihood: Posterior | None = None
    sampled: Chains | None = None
    left_out: Mapping[str, int] = field(default_factory=dict)
    notes: tuple[Note, ...] = ()
    stored: Calibration | None = None
    paths: tuple[str, ...] = ()
    version: str | None = None
    records_changed: bool = False

    @property
    def posterior(self) -> Posterior:
        """The likelihood of the events, and the posterior by it."""
        assert self.likelihood is not None, "the model has not been put on observations"
        return self.likelihood

    @property
    def observations(self) -> Observations:
        """The events that the model is of, as the likelihood has them."""
        return self.posterior.observations

    @property
    def chains(self) -> Chains:
        """The chains of a model that has just been calibrated."""
        assert self.sampled is not None, "the model comes from elsewhere than a sampler"
        return self.sampled

    @property
    def calibration(self) -> Calibration:
        """What is stored of its calibration."""
        assert self.stored is not None, "the model is not stored"
        return self.stored

    @property
    def name(self) -> str:
        """The name under which it is stored."""
        return self.calibration.model

    @property
    def n_events(self) -> int:
        """Number of events that it was calibrated on."""
        return len(self.columns) - sum(self.left_out.values())

    @property
    def layout(self) -> Layout:
        """Its coordinates."""
        return self.friction.layout

    @property
    def sigma_m(self) -> Floats | None:
        """Scatter of the stop's elevation in metres `[n_draws]`; None where friction scatters."""
        if not METHODS[self.method].in_metres:
            return None
        return np.asarray(np.exp(self.draws[:, self.layout.scatter]))

    @property
    def knows_errors(self) -> bool:
        """Whether it accounts for the errors of records, and so has a likelihood to test in."""
        return METHODS[self.method].knows_errors

    @property
    def takes_event_columns(self) -> bool:
        """Whether friction or front depends on columns of the event itself."""
        return any(entry.event_columns for entry in self.definitions)

    @property
    def ignores_volume(self) -> bool:
        """Whether every volume has the same runout, as it never has by a flow model."""
        return (
            self.specification.forward == BLOCK
            and not self.layout.law.uses_volume
            and self.specification.scatter == "constant"
            and not any(entry.uses_volume for entry in self.definitions)
        )

    def on(self, observations: Observations) -> FittedModel:
        """The same model and draws on other events. The paper's methods take volumes as exact."""
        if not self.knows_errors:
            observations = replace(observations, volumes=exact_volumes(observations))
        posterior = Posterior(observations, self.specification, self.effects, self.layout.arms)
        return replace(
            self,
            friction=posterior.friction,
            columns=observations.columns,
            draws=in_slots(posterior.layout, [s.name for s in self.layout.slots], self.draws),
            likelihood=posterior,
        )

    def resistance(self, site: Site, values: Values) -> Resistance:
        """The resistance on a site with the model's effects at these values."""
        return resistance_of(site, self.effects, values, float(self.specification.centrifugal))

    def thinned(self, n: int) -> NDArray[np.int64]:
        """Indices `[n]` of draws, thinned over all of them."""
        return np.linspace(0, len(self.draws) - 1, n).round().astype(np.int64)

    def group_offsets(self, rng: np.random.Generator) -> Floats | None:
        """Draws of offsets `[n_draws, n_offsets]`, of new groups too; None without groups."""
        plan = self.posterior.plan
        if not plan:
            return None
        tau = self.layout.spread_values(self.draws)
        columns = [
            self.offsets[name]
            if name in self.offsets
            else tau[:, g] * rng.standard_normal(len(tau))
            for name, g in zip(plan.names, plan.of, strict=True)
        ]
        return np.column_stack(columns) if columns else np.empty((len(tau), 0))

    def median_friction(self, volume: Floats, columns: EventColumns | None = None) -> Floats:
        """Posterior median `[n_events]` of the median friction of each event.

        Of the events of `columns`, by default the model's own; `volume` (m3) `[n_events]` is
        exact. A new group has no offset.
        """
        friction = self.friction
        events = friction.of_events(self.columns if columns is None else columns)
        at = volume[:, None]
        median = np.array(
            [friction.location_and_scatter(u, at, events)[0][:, 0] for u in self.draws]
        )
        if self.layout.log_scatter:
            median = np.exp(median)
        plan = events.plan
        if plan:
            none = np.zeros(len(self.draws))
            known = np.column_stack([self.offsets.get(name, none) for name in plan.names])
            median *= np.exp([plan.shift(row) for row in known])
        return np.asarray(np.median(median, axis=0))


def fitted_model(
    posterior: Posterior,
    draws: Floats,
    offsets: Mapping[str, Floats] | None = None,
    method: MethodName = DEFAULT_METHOD,
) -> FittedModel:
    """A model on the events of `posterior`, from draws `[n_draws, n_slots]` of its coordinates."""
    return FittedModel(
        specification=posterior.specification,
        effects=posterior.effects,
        friction=posterior.friction,
        columns=posterior.observations.columns,
        draws=draws,
        offsets=offsets or {},
        method=method,
        likelihood=posterior,
    )


def in_slots(layout: Layout, slots: Sequence[str], draws: Floats) -> Floats:
    """Draws `[n_draws, n_slots]` in the order of a layout; their columns are named by `slots`.

    Events with speeds have a slot for their scatter that those without have not; where the model
    was fitted without, it stays at the mean of its prior.
    """
    place = {slot: k for k, slot in enumerate(slots)}
    return np.column_stack(
        [
            draws[:, place[slot.name]] if slot.name in place else np.full(len(draws), slot.mean)
            for slot in layout.slots
        ]
    )


def exact_volumes(observations: Observations) -> VolumeNodes:
    """One node at each recorded volume; an event without one keeps the middle of its path's."""
    recorded = observations.columns.log_volume
    mean = np.where(np.isfinite(recorded), recorded, observations.volumes.mean)
    return replace(
        observations.volumes,
        log_volume=mean[:, None],
        weight=np.ones((len(mean), 1)),
        mean=mean,
        sd=np.where(np.isfinite(recorded), 0.0, observations.volumes.sd),
    )


def table_groups(parameters: Floats, n_groups: int) -> list[NDArray[np.int64]]:
    """Split draws `[n_draws, n_parameters]` into at most `n_groups` groups of like size.

    The group with the widest parameter (in standard deviations of all draws) is halved at its
    median until there are enough. A group can share one set of tables; the parameters that go
    along with those of the tables (friction falls where drag rises) stay with them.
    """
    groups = [np.arange(len(parameters))]
    spread = np.std(parameters, axis=0)
    known = parameters[:, spread > 0.0] / spread[spread > 0.0]
    if known.shape[1] == 0:
        return groups
    while len(groups) < n_groups:
        widths = [np.ptp(known[g], axis=0) * len(g) for g in groups]
        k = int(np.argmax([width.max() for width in widths]))
        if widths[k].max() == 0.0:
            break
        order = groups[k][np.argsort(known[groups[k], np.argmax(widths[k])], kind="stable")]
        half = len(order) // 2
        groups[k : k + 1] = [order[:half], order[half:]]
    return groups
