"""The priors that are given as numbers to a model: what they may be of, and their sizes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from avahazard.effects.effect import Effect
from avahazard.inference.model.laws import Law, law
from avahazard.inference.model.layout import Layout, build_layout
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.priors import (
    GivenPrior,
    LawPrior,
    free_parameters,
    given_law_prior,
    in_coordinate,
    positive_parameters,
    require_possible,
    require_width,
)
from avahazard.inference.model.specification import Specification
from avahazard.physics.runout_curve import MU
from avahazard.records.errors import AvahazardError

Numbers = Mapping[str, Sequence[float]]
"""Mean and standard deviation by parameter."""


def with_given_priors(
    specification: Specification,
    numbers: Numbers,
    effects: Sequence[Effect],
    observations: Observations,
) -> Specification:
    """The specification with these priors, of parameters as `model NAME` lists them.

    Raises:
        AvahazardError: the model has no such parameter, it cannot have such a prior, or the law
            has its prior from other records.
    """
    speeds = bool(observations.speeds)
    layout = build_layout(specification, tuple(effects), {}, speeds=speeds)
    others = layout.beside_the_law()
    in_log = {*layout.logs, *layout.spreads.values()}
    positive = {*positive_parameters(layout.law), *(n for n, k in others.items() if k in in_log)}
    known = (*free_parameters(layout.law), *others)
    given = tuple(_given(name, pair) for name, pair in numbers.items())
    for told in given:
        if told.name not in known:
            raise AvahazardError(
                f"There is no prior of '{told.name}' in this model ({specification.law} law).",
                f"It may be of {', '.join(sorted(known))}.",
            )
        require_possible(told, told.name in positive)
        if told.name in others:
            k = others[told.name]
            _require_in_range(told, layout, k)
            require_width(told.name, in_coordinate(layout, k, told)[1], layout.slots[k].sd)
    prior = given_law_prior(layout.law, given)
    if prior is not None and specification.prior is not None:
        raise AvahazardError(
            f"The law has its prior from {specification.prior.source}: it cannot have another one "
            f"of {prior.source.partition(':')[2]}.",
            "Give --prior-from, or --prior for the parameters of the law.",
        )
    if prior is not None:
        _require_friction(prior, law(specification.law), observations, given)
    return replace(specification, prior=prior or specification.prior, given=given)


def _given(name: str, pair: Sequence[float]) -> GivenPrior:
    if len(pair) != 2:
        raise AvahazardError(
            f"The prior of {name} has {len(pair)} of two numbers.",
            "It is two: a mean and a standard deviation.",
        )
    return GivenPrior(name, float(pair[0]), float(pair[1]))


def _require_in_range(told: GivenPrior, layout: Layout, k: int) -> None:
    slot = layout.slots[k]
    low, high = slot.low * slot.scale, slot.high * slot.scale
    if k in layout.logs:
        low, high = float(np.exp(slot.low)), float(np.exp(slot.high))
    if not low <= told.mean <= high:
        raise AvahazardError(
            f"The prior {told.name}={told.mean:g},{told.sd:g} is out of range.",
            f"The mean of {told.name} may be {low:g} to {high:g}.",
        )


def _require_friction(
    prior: LawPrior, of: Law, observations: Observations, given: Sequence[GivenPrior]
) -> None:
    """Refuse what gives the middle volume no friction that a block can have: a slip of units."""
    volume = float(np.exp(np.median(observations.volumes.mean))) if of.uses_volume else 1.0
    mu = float(np.exp(of.log_friction(np.array(prior.mean), np.array([volume]))[0]))
    if not MU[0] <= mu <= MU[-1]:
        units = dict(zip(of.names, of.units, strict=True))
        told = ", ".join(
            f"{g.name}={g.mean:g} {units[g.name]}".rstrip() for g in given if g.name in units
        )
        at = f" at the middle volume of {volume:.3g} m3" if of.uses_volume else ""
        raise AvahazardError(
            f"The prior ({told}) gives friction {mu:.2g}{at}.",
            f"Friction is {MU[0]:g} to {MU[-1]:g}; n of the exponential law is some 1e-6 1/m3."
            if "n" in units
            else f"Friction is {MU[0]:g} to {MU[-1]:g}.",
        )
