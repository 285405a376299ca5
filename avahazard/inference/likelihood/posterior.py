"""Marginal likelihood and posterior density of a model (docs/theory/likelihood.md)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from copy import copy
from dataclasses import replace
from functools import cached_property, partial
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Bools, Floats, Ints
from avahazard.effects.effect import Effect, KindsEffect, VolumeErrorEffect, of_kind, shapes_tables
from avahazard.effects.site import Site
from avahazard.inference.likelihood.node_charts import NodeCharts
from avahazard.inference.likelihood.nodes import Nodes, by_wrong_share
from avahazard.inference.likelihood.offsets import Offsets, newton_offsets, pulls_of_groups
from avahazard.inference.likelihood.predicted import Values, keep, record_sigma, resistance_of
from avahazard.inference.likelihood.terms import EventTerms, event_terms, event_terms_kernel
from avahazard.inference.model.friction_model import EventFriction, OffsetPlan, friction_model
from avahazard.inference.model.layout import Arms, Layout, with_arms
from avahazard.inference.model.observations import Observations, part_of
from avahazard.inference.model.specification import Specification
from avahazard.inference.model.volumes import VolumeNodes, rescaled
from avahazard.physics.cells import Resistance
from avahazard.workers import ordered_map

T = TypeVar("T")

KEPT_VOLUMES = 32
"""Factors of the volumes' errors for which the volumes are kept."""
MOST_NUMBERS = 1_000_000
"""Numbers of one array where many coordinates are taken at once."""
EVENTS_AT_ONCE = 1000
"""Events whose nodes stand in the cache of a processor, 1 kB each."""
WORTH_SHARING = 5000
"""Numbers (events times their volumes) of one call from which on it goes to another thread."""


class Posterior:
    """Log likelihood and posterior of one model on one observations.

    `friction` is the model of friction, `of_events` what it takes of these events. `nodes` holds
    what the records say of friction, on the star of the parameters that shape the tables, whose
    arms are `arms`, else the effects' own.
    """

    def __init__(
        self,
        observations: Observations,
        specification: Specification,
        effects: tuple[Effect, ...],
        arms: Arms | None = None,
    ) -> None:
        self.observations = observations
        self.specification = specification
        self.effects = effects
        speeds = bool(observations.speeds)
        self.friction = friction_model(specification, effects, arms, speeds=speeds)
        self._volume_errors = of_kind(effects, VolumeErrorEffect)
        self._volumes: dict[float, VolumeNodes] = {}
        self._keep: Bools = np.ones(observations.n_events, dtype=np.bool_)
        self.nodes = self._charts()

    def _charts(self) -> NodeCharts:
        curvature = float(self.specification.centrifugal)
        return NodeCharts(self.observations, self.effects, self.layout, curvature)

    @property
    def layout(self) -> Layout:
        """The coordinates of the model."""
        return self.friction.layout

    @cached_property
    def of_events(self) -> EventFriction:
        """What friction takes of the events."""
        return self.friction.of_events(self.observations.columns)

    @property
    def plan(self) -> OffsetPlan:
        """The groups of the events."""
        return self.of_events.plan

    @cached_property
    def _covariate(self) -> Floats | None:
        return self.friction.line_covariate(self.observations.volumes.volume)

    def restricted(self, keep: Bools) -> Posterior:
        """The posterior given only the events in `keep` `[n_events]`; tables are shared."""
        part = copy(self)
        part._keep = keep
        return part

    def of_part(self, events: Ints) -> Posterior:
        """The posterior of the same model on these `events` `[n]` alone."""
        other = copy(self)
        other.observations = part_of(self.observations, events)
        other._keep, other._volumes = np.ones(len(events), dtype=np.bool_), {}
        for name in ("of_events", "_covariate"):
            other.__dict__.pop(name, None)
        other.nodes = other._charts()
        return other

    def pinned(self, u: Floats) -> Posterior:
        """The posterior where the parameters that shape the tables are held at those of u."""
        other = copy(self)
        other.nodes = self.nodes.pinned(u)
        return other

    def on_star(self, arms: Arms, like: NodeCharts | None = None) -> Posterior:
        """The same posterior on another star, the very one of `like` if given."""
        other = copy(self)
        other.friction = replace(self.friction, layout=with_arms(self.layout, arms))
        other.nodes = self.nodes.on_star(other.layout, like)
        return other

    def exactly(self) -> Posterior:
        """The same posterior by tables made on the spot wherever it is asked."""
        other = copy(self)
        other.nodes = self.nodes.exactly()
        return other

    def on_star_of(self, other: Posterior) -> Posterior | None:
        """The same posterior on the star of another; None where other effects shape its tables."""

        def shaped_by(model: Posterior) -> tuple[bool, bool, list[str]]:
            keys = [effect.key for effect in model.effects if shapes_tables(effect)]
            return model.layout.log_scatter, model.specification.centrifugal, keys

        if other.observations is not self.observations or shaped_by(self) != shaped_by(other):
            return None
        return self.on_star(other.layout.arms, other.nodes)

    def log_density(self, u: Floats) -> float:
        """Log posterior at coordinates u `[n_slots]`, up to a constant; -inf out of bounds."""
        return self.density_and_offsets(u)[0]

    def density_and_offsets(self, u: Floats) -> tuple[float, Offsets | None]:
        """`log_density`, with the groups' offsets that it rests on where there are any."""
        if not self.layout.within(u):
            return -np.inf, None
        value, offsets = self._given(u, self.nodes_at(u), *self.location_and_scatter(u))
        return value + float(self.layout.log_prior(u)), offsets

    def log_densities(self, u: Floats) -> Floats:
        """`log_density` `[n]` at many coordinates u `[n, n_slots]`: most of the work is shared."""
        layout = self.layout
        result = np.full(len(u), -np.inf)
        inside = np.flatnonzero(layout.within(u))
        if not len(inside):
            return result
        if self._volume_errors or self.layout.kinds is not None:
            result[inside] = [self.log_likelihood(v) for v in u[inside]]
        else:
            size = self.observations.volumes.volume.size
            if self.nodes.varies:  # each has nodes of its own
                size = max(size, 4 * self.nodes_at(u[inside[0]]).place.size)
            n_parts = min(len(inside), -(-len(inside) * size // MOST_NUMBERS))
            for part in np.array_split(inside, n_parts):
                result[part] = self._log_likelihoods(u[part])
        result[inside] += layout.log_prior(u[inside])
        return result

    def log_likelihood(self, u: Floats) -> float:
        """Log likelihood at u, groups' offsets integrated out (Laplace's method)."""
        return self._given(u, self.nodes_at(u), *self.location_and_scatter(u))[0]

    def exact_log_likelihood(self, u: Floats) -> float:
        """The same from tables made for just these coordinates, not interpolated."""
        nodes = self._or_wrong(self.nodes.exact(u), u)
        return self._given(u, nodes, *self.location_and_scatter(u))[0]

    @property
    def sloped(self) -> NDArray[np.int64]:
        """Slots by which `density_and_slopes` has derivatives: most that shape no tables.

        Beside groups of events they are there where these move log friction of each event alike.
        """
        groups = bool(self.plan)
        if groups and not self.layout.log_scatter:
            return np.empty(0, dtype=np.int64)
        slots = np.arange(len(self.layout.slots))
        others = [e for e in self.effects if isinstance(e, VolumeErrorEffect | KindsEffect)]
        held = {*self.layout.tables, self.layout.track_scatter}
        held |= {self.layout.wrong_share} if groups else set()
        held.update(*(slots[self.layout.places[e.key]].tolist() for e in others))
        return np.array([k for k in slots if k not in held], np.int64)

    def density_and_slopes(self, u: Floats) -> tuple[float, Floats]:
        """`log_density` at u, within the bounds, and its derivatives `[n_slots]` by `sloped`."""
        nodes = self.nodes_at(u)
        location, scatter = self.location_and_scatter(u)
        weight, student, keep = self.weight(u), self.friction.student, self._keep

        def terms_at(shift: Floats) -> EventTerms:
            there = self.friction.shifted(location, shift[:, None])
            return event_terms(nodes, there, scatter, weight, student, keep)

        volume, tau = self.volumes(u).volume, self.layout.spread_values(u)
        if np.any(tau):
            value, offsets = self._given(u, nodes, location, scatter)
            assert offsets is not None
            precision = tau[self.plan.of] ** -2.0
            *pulls, by_spread = pulls_of_groups(offsets, self.plan.index, precision, terms_at)
            slopes = self.friction.pulled(u, volume, self.of_events, scatter, *pulls)
            spreads = list(self.layout.spreads.values())
            by_grouping = np.bincount(self.plan.of, by_spread, len(spreads))
            slopes[spreads] += by_grouping / u[spreads]
        else:
            terms = event_terms(nodes, location, scatter, weight, student, keep)
            value = float(np.sum(terms.value[keep]))
            slopes = self.friction.pulled(u, volume, self.of_events, scatter, *terms[1:3])
            if self.layout.wrong_share is not None:
                k = self.layout.wrong_share
                by_share = by_wrong_share(nodes.log_wrong, terms.value, float(u[k]))
                slopes[k] = np.sum(by_share[keep])
        return value + float(self.layout.log_prior(u)), slopes + self.layout.prior_slopes(u)

    def _log_likelihoods(self, u: Floats) -> Floats:
        """Log likelihoods `[n]` at u `[n, n_slots]`, within the bounds."""
        location, scatter = self.location_and_scatter(u)
        weight = self.observations.volumes.weight
        if self.plan or self.nodes.varies or self.layout.wrong_share is not None:
            # Nodes are kept by the chart, which is not for several threads at once.
            each = u, [self.nodes_at(v) for v in u], location, scatter
            given = _side_by_side(self._given, *each, n_numbers=location[0].size)
            return np.array([value for value, _ in given])
        nodes = self.nodes.at(u[0])
        total = np.zeros(len(u))
        # Nodes of some events stay near the processor for all coordinates.
        for first in range(0, len(weight), EVENTS_AT_ONCE):
            part = slice(first, first + EVENTS_AT_ONCE)
            some = Nodes._make(column[part] for column in nodes)
            student, keep = self.friction.student, self._keep[part]
            terms_at = partial(event_terms_kernel, some, weight[part], student, keep, False)
            places = location[:, part], scatter[:, part]
            terms = _side_by_side(terms_at, *places, n_numbers=weight[part].size)
            total += np.array([of_all for *_, of_all in terms])
        return total

    def _given(
        self, u: Floats, nodes: Nodes, location: Floats, scatter: Floats
    ) -> tuple[float, Offsets | None]:
        """Log likelihood with all that rests on u, offsets of groups integrated out."""
        tau = self.layout.spread_values(u)
        if not self.plan or not np.any(tau):
            weight, student = self.weight(u), self.friction.student
            of_nodes = nodes, location, scatter, weight, student, self._keep
            return float(np.sum(event_terms(*of_nodes, slopes=False).value[self._keep])), None
        offsets, value_there = self._offsets(u, nodes, location, scatter)
        spread = tau[self.plan.of]
        penalty = 0.5 * np.sum((offsets.mode / spread) ** 2)
        with np.errstate(divide="ignore"):  # -inf where the curvature overflows, far off
            widths = -0.5 * offsets.log_determinant - float(np.sum(np.log(spread)))
        return float(value_there - penalty) + widths, offsets

    def event_log_likelihood(
        self, u: Floats, offsets: Floats | None = None, keep: Bools | None = None
    ) -> Floats:
        """Log likelihood of each event `[n_events]`, given offsets `[n_offsets]` of the groups.

        0 for those not in `keep` `[n_events]`.
        """
        of_nodes = self.nodes_at(u), *self.friction_at(u, offsets), self.friction.student, keep
        return event_terms(*of_nodes, slopes=False).value

    def friction_at(self, u: Floats, offsets: Floats | None) -> tuple[Floats, Floats, Floats]:
        """`location_and_scatter` with offsets `[n_offsets]` of the groups, and `weight`."""
        location, scatter = self.location_and_scatter(u)
        if offsets is not None:
            location = self.friction.shifted(location, self.plan.shift(offsets)[:, None])
        return location, scatter, self.weight(u)

    def mode_offsets(self, u: Floats) -> Floats | None:
        """Mode of the groups' offsets `[n_offsets]` given coordinates u; None without groups."""
        return self.offsets(u).mode if self.plan else None

    def offsets(self, u: Floats) -> Offsets:
        """The offsets of the groups given coordinates u."""
        location, scatter = self.location_and_scatter(u)
        return self._offsets(u, self.nodes_at(u), location, scatter)[0]

    def nodes_at(self, u: Floats) -> Nodes:
        """What the records say of friction at coordinates u."""
        return self._or_wrong(self.nodes.at(u), u)

    def _or_wrong(self, nodes: Nodes, u: Floats) -> Nodes:
        """The nodes of records that may be wrong: right with one less the share of these."""
        if self.layout.wrong_share is None:
            return nodes
        log_share = float(u[self.layout.wrong_share])
        may_be = np.isfinite(nodes.log_wrong)
        right = np.where(may_be, np.log1p(-np.exp(log_share)), 0.0)
        return nodes._replace(
            log_scale=nodes.log_scale + right, log_wrong=nodes.log_wrong + log_share
        )

    def volumes(self, u: Floats) -> VolumeNodes:
        """True volumes given their records, with the factors of effects on the volumes' errors."""
        if not self._volume_errors:
            return self.observations.volumes
        values = self.layout.effect_values(u)
        factor = float(np.prod([np.exp(values[e.key][0]) for e in self._volume_errors]))
        if factor == 1.0:
            return self.observations.volumes
        if factor not in self._volumes:
            keep(self._volumes, factor, rescaled(self.observations.volumes, factor), KEPT_VOLUMES)
        return self._volumes[factor]

    def record_sigma(self, u: Floats) -> Floats:
        """Error of the records `[n_events]` (m), with the factors of effects on it."""
        return record_sigma(self.observations, self.effects, self.layout.effect_values(u))

    def location_and_scatter(self, u: Floats) -> tuple[Floats, Floats]:
        """Location m (log μ, or μ for normal) and scatter σ, each `[..., n_events, n_nodes]`.

        At coordinates u `[..., n_slots]`, at the volume nodes of every kind of avalanche
        (`weight`). What an event has for itself of a grouping is in its scatter.
        """
        volumes = self.volumes(u)
        covariate = self._covariate if volumes is self.observations.volumes else None
        law = self.friction.location_and_scatter(u, volumes.volume, self.of_events, covariate)
        return self.friction.by_kind(u, *law)

    def weight(self, u: Floats) -> Floats:
        """Weights `[n_events, n_nodes]` of what `location_and_scatter` gives at u `[n_slots]`."""
        return self.friction.weights_by_kind(u, self.observations.volumes.weight)

    def resistance(self, site: Site, values: Values) -> Resistance:
        """The resistance on a site with this model's effects at these values."""
        return resistance_of(site, self.effects, values, float(self.specification.centrifugal))

    def _offsets(
        self, u: Floats, nodes: Nodes, location: Floats, scatter: Floats
    ) -> tuple[Offsets, float]:
        """The offsets at coordinates u, and the log likelihood at their mode."""
        friction = location, scatter, self.weight(u), self.friction.student, self.layout.log_scatter
        precision = self.layout.spread_values(u)[self.plan.of] ** -2.0
        groups = self.plan.index, self.plan.rest, self._keep, precision
        mode, bend, cross, back, value = newton_offsets(nodes, *friction, *groups)
        return Offsets(mode, self.plan.rest, bend, cross, back), float(np.sum(value))


def _side_by_side(function: Callable[..., T], *items: Iterable[Any], n_numbers: int) -> Iterator[T]:
    """As `map`, by the threads where each call goes through many numbers."""
    share = n_numbers >= WORTH_SHARING
    return ordered_map(function, *items) if share else map(function, *items)
