"""A prior on the law of friction that other records speak for: a fit, or another model's posterior.

A normal on the law's coordinates, with their covariance. What other records say of the scatter is
not taken over: it holds their errors too where the method does not know them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.model.laws import Law
from avahazard.records.errors import AvahazardError

LEAST_RECIPROCAL_CONDITION = 1e-10


@dataclass(frozen=True, slots=True)
class LawPrior:
    """Mean `[n_coordinates]` and covariance of the coordinates of `law`, from `source`.

    The source is the name of a model, or `fit:` and the paths whose events were fitted.
    """

    source: str
    law: str
    mean: tuple[float, ...]
    covariance: tuple[tuple[float, ...], ...]

    @property
    def sd(self) -> Floats:
        """Standard deviations `[n_coordinates]`."""
        return np.sqrt(np.diag(np.array(self.covariance)))

    @property
    def correlation(self) -> Floats:
        """Correlations `[n_coordinates, n_coordinates]`."""
        return np.asarray(np.array(self.covariance) / np.outer(self.sd, self.sd))


def law_prior(source: str, law: Law, mean: Floats, covariance: Floats) -> LawPrior:
    """The prior of these coordinates. Raises `AvahazardError` where they are not all told."""
    prior = LawPrior(source, law.name, tuple(mean.tolist()), tuple(map(tuple, covariance.tolist())))
    known = np.isfinite(mean).all() and np.isfinite(covariance).all() and (prior.sd > 0.0).all()
    if not known or np.linalg.eigvalsh(prior.correlation)[0] < LEAST_RECIPROCAL_CONDITION:
        raise AvahazardError(
            f"{source} does not fix the constants of the {law.name} law: it is no prior of them.",
            "Take a law with fewer constants, or another model.",
        )
    return prior


def prior_of_fit(
    source: str, law: Law, natural: Floats, covariance: Floats, n_points: int
) -> LawPrior:
    """The prior that a fit by least squares gives, by its natural constants and their covariance.

    Carried to the coordinates by the derivatives there. The residual variance is known from
    `n_points` less the constants only: the covariance is that of the t that follows. Raises
    `AvahazardError` where there are too few points for one.
    """
    free = n_points - len(law.coordinates)
    if free < 3:
        raise AvahazardError(
            f"{source} stands on {n_points} events, which leaves the error of its law open.",
            f"A prior needs a fit to {len(law.coordinates) + 3} events or more.",
        )
    scale = np.where(natural != 0.0, np.abs(natural), 1e-8)
    steps = 1e-5 * np.diag(scale)
    ahead, behind = (law.from_natural(natural + step) for step in (steps, -steps))
    slope = ((ahead - behind) / 2e-5 / scale[:, None]).T
    spread = slope @ covariance @ slope.T * (free / (free - 2.0))
    return law_prior(source, law, law.from_natural(natural), spread)


def prior_from_document(document: Mapping[str, Any] | None) -> LawPrior | None:
    """The prior of a stored specification; None where it has none."""
    if document is None:
        return None
    return LawPrior(
        document["source"],
        document["law"],
        tuple(document["mean"]),
        tuple(map(tuple, document["covariance"])),
    )
