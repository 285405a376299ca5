"""Apparent friction of the records, its density, and laws fitted to it."""

from dataclasses import field

from avahazard.notes import Note
from avahazard.results.base import ABSENT, Result, Rows


class ApparentEvent(Result):
    """The friction whose block stops where the record says, and its bracket.

    `mu_sd` is its spread under records moved within their errors. Under a model `mu_reference` is
    μ less what its effects on friction and the path add: it may stand beside the law alone.
    """

    event_id: str
    path_id: str | None
    mu: float | None
    mu_sd: float | None
    status: str
    mu_low: float | None
    mu_high: float | None
    mu_reference: float | None = field(default=None, metadata=ABSENT)


class FrictionDensity(Result):
    """Holy's density of the frictions of one path, or of `all`, on a grid.

    `mean` and `sd` are those of the frictions: the normal that the paper draws beside it.
    """

    path_id: str
    n: int
    kappa: float
    mu: tuple[float, ...]
    pdf: tuple[float, ...]
    extrapolated: tuple[bool, ...]
    mean: float
    sd: float


class PerturbedParameter(Result):
    """A parameter of a law fitted to the records, and to records moved within their errors."""

    value: float
    se: float
    mean: float
    sd: float


class PerturbationCheck(Result):
    """What the errors of the records do to the frictions, and to the law fitted to them."""

    n_replicates: int
    n_events: int
    mu_sd_median: float | None
    mu_sd_max: float | None
    law: str | None
    parameters: dict[str, PerturbedParameter]


class Frictions(Result):
    """Apparent friction of every event, densities, and the check by perturbation.

    Of the block by itself, or with the effects of `model` on the motion and the record at work.
    """

    model: str | None = field(default=None, metadata=ABSENT, kw_only=True)
    notes: tuple[Note, ...] | None = field(default=None, metadata=ABSENT, kw_only=True)
    events: Rows[ApparentEvent]
    density: Rows[FrictionDensity]
    perturbation: PerturbationCheck


class FittedParameter(Result):
    """A parameter of a law by least squares, with its standard error."""

    value: float
    se: float
    unit: str


class LeastSquares(Result):
    """A law of friction against volume by least squares."""

    law: str
    parameters: dict[str, FittedParameter]
    covariance: tuple[tuple[float, ...], ...]
    r2: float
    aic: float
    n_events: int


class Fits(Result):
    """All laws, with notes on what was left out."""

    rows: Rows[LeastSquares]
    notes: tuple[str, ...] = ()
