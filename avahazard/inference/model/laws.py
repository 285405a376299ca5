"""Laws of friction against volume; one that is added to `LAWS` is everywhere.

Each law has two sets of parameters. The natural ones are what people read (`names`, `units`).
The coordinates are what samplers and optimisers move in: unbounded and of order one, so that a
normal prior and a step of 0.1 make sense for each. Arrays of either end in the parameter axis.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from avahazard.inference.model.law_curves import (
    N_SCALE,
    asymptotic,
    asymptotic_begin,
    asymptotic_from_natural,
    asymptotic_to_natural,
    bounded_exp,
    columns,
    constant,
    exponential,
    in_millions,
    line_begin,
    log_in_c,
    power,
    rational,
    rational_begin,
    rational_from_natural,
    rational_to_natural,
)
from avahazard.inference.model.law_slopes import (
    asymptotic_slopes,
    constant_slopes,
    exponential_slopes,
    power_slopes,
    rational_slopes,
)
from avahazard.records.errors import AvahazardError

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Law:
    """A law μ = G(V) and the coordinates in which it is sampled.

    `formula` is for tables, `words` for the report. `log_friction(u, volume)`: log μ,
    [..., n_events], of coordinates [..., n_coordinates] and volumes [n_events] in m3; `slopes` are
    its derivatives [n_coordinates, n_events] at one u. `to_natural`
    and `from_natural` convert between the two sets of parameters. `prior_mean` and `prior_sd` are
    independent normals on the coordinates. `begin` gives coordinates from volumes and log μ
    [n_events] of which all are known.

    `form` is what the paper's samplers know of a law, in x = `covariate(volume)`: `line`, log μ =
    u0 - u1 x; `bend`, log μ = u0 - log(1 + exp(n (x - u1))) with n = exp u2; None, they refuse it.
    """

    name: str
    formula: str
    words: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    coordinates: tuple[str, ...]
    prior_mean: Array
    prior_sd: Array
    log_friction: Callable[[Array, Array], Array]
    slopes: Callable[[Array, Array], Array]
    to_natural: Callable[[Array], Array]
    from_natural: Callable[[Array], Array]
    begin: Callable[[Array, Array], Array]
    form: Literal["line", "bend"] | None = None
    covariate: Callable[[Array], Array] = np.zeros_like
    uses_volume: bool = True

    def friction(self, natural: Array, volume: Array) -> Array:
        """μ [..., n_events] of natural parameters [..., n_parameters]."""
        result: Array = np.exp(self.log_friction(self.from_natural(natural), volume))
        return result

    def __reduce__(self) -> tuple[Callable[[str], Law], tuple[str]]:
        """Other processes find the law by its name."""
        return law, (self.name,)

    def start(self, volume: Array, mu: Array) -> Array:
        """Coordinates [n_coordinates] near the least-squares fit of log μ, to start from."""
        volume, mu = np.asarray(volume, np.float64), np.asarray(mu, np.float64)
        keep = np.isfinite(mu) & (mu > 0) & np.isfinite(volume) & (volume > 0)
        if not keep.any():
            return self.prior_mean.copy()
        return self.begin(volume[keep], np.log(mu[keep]))


def law(name: str) -> Law:
    """The law of that name; `AvahazardError` lists the names when there is none."""
    if name not in LAWS:
        raise AvahazardError(f"There is no law '{name}'.", f"Laws: {', '.join(LAWS)}.")
    return LAWS[name]


# The priors are weak on purpose. Back-calculated frictions of snow avalanches lie in 0.15 to 1.2
# (Ancey 2005, figure 1 and table 2), so log a has centre log 0.5 and sd 0.5: 95 % in 0.19 to 1.33.
# n reached 9.4e-6 per m3 in figure 1 and may have either sign: sd 10 in units of 1e-6. α is the
# friction of 1 m3, an extrapolation over four decades: sd 1. β was 0.065 in figure 1 and about
# 0.085 for rock avalanches: sd 0.2, either sign. The rational law bends anywhere in 1e3 to 1e7 m3.
# μ∞: the Swiss guidelines give extreme avalanches 0.155 to 0.3 (Salm, Burkard & Gubler 1990), which
# is 0.3 to 0.6 of a = 0.5: log μ∞/a is -0.5 ± 0.5, 95 % in 0.22 to 1.6. It may lie above a, as n of
# the exponential law may be negative: the data say whether friction falls. It is bounded all the
# same. 1/n is a volume within 1e4 and 6e7 m3 (95 %), as table 2's are.
LAWS: dict[str, Law] = {
    item.name: item
    for item in (
        Law(
            name="exponential",
            formula="μ = a exp(-n V)",
            words="falls with volume by the exponential law μ = a exp(−nV)",
            names=("a", "n"),
            units=("", "1/m3"),
            coordinates=("log a", "n in 1e-6/m3"),
            prior_mean=np.array([np.log(0.5), 0.0]),
            prior_sd=np.array([0.5, 10.0]),
            log_friction=exponential,
            slopes=exponential_slopes,
            to_natural=lambda u: columns(bounded_exp(u[..., 0]), u[..., 1] * N_SCALE),
            from_natural=lambda p: columns(np.log(p[..., 0]), p[..., 1] / N_SCALE),
            begin=line_begin(in_millions),
            form="line",
            covariate=in_millions,
        ),
        Law(
            name="power",
            formula="μ = alpha V^-beta",
            words="falls with volume by the power law μ = α V⁻ᵝ",
            names=("alpha", "beta"),
            units=("", ""),
            coordinates=("log alpha", "beta"),
            prior_mean=np.array([0.0, 0.0]),
            prior_sd=np.array([1.0, 0.2]),
            log_friction=power,
            slopes=power_slopes,
            to_natural=lambda u: columns(bounded_exp(u[..., 0]), u[..., 1]),
            from_natural=lambda p: columns(np.log(p[..., 0]), p[..., 1]),
            begin=line_begin(np.log),
            form="line",
            covariate=np.log,
        ),
        # μ depends on a, b, c, n through three combinations only: (k a, k b, c k^(-1/n), n) is the
        # same law for every k > 0. So b is 1 in calibrations: a is the friction of small volumes,
        # c the volume that halves it.
        Law(
            name="rational",
            formula="μ = a / (b + (V/c)^n)",
            words="falls with volume by the rational law μ = a / (1 + (V/c)ⁿ)",
            names=("a", "b", "c", "n"),
            units=("", "", "m3", ""),
            coordinates=("log a", "log c in 1e5 m3", "log n"),
            prior_mean=np.array([np.log(0.5), 0.0, 0.0]),
            prior_sd=np.array([0.5, 2.5, 0.7]),
            log_friction=rational,
            slopes=rational_slopes,
            to_natural=rational_to_natural,
            from_natural=rational_from_natural,
            begin=rational_begin,
            form="bend",
            covariate=log_in_c,
        ),
        # Bounded on both sides: beyond the data friction goes to μ∞, never to 0.
        Law(
            name="asymptotic",
            formula="μ = mu_inf + (a - mu_inf) exp(-n V)",
            words="goes with volume to a limit, μ = μ∞ + (a − μ∞) exp(−nV)",
            names=("a", "mu_inf", "n"),
            units=("", "", "1/m3"),
            coordinates=("log a", "log mu_inf/a", "log n in 1e-6/m3"),
            prior_mean=np.array([np.log(0.5), -0.5, 0.0]),
            prior_sd=np.array([0.5, 0.5, 2.0]),
            log_friction=asymptotic,
            slopes=asymptotic_slopes,
            to_natural=asymptotic_to_natural,
            from_natural=asymptotic_from_natural,
            begin=asymptotic_begin,
        ),
        Law(
            name="constant",
            formula="μ = a",
            words="is the same for every volume",
            names=("a",),
            units=("",),
            coordinates=("log a",),
            prior_mean=np.array([np.log(0.5)]),
            prior_sd=np.array([0.5]),
            log_friction=constant,
            slopes=constant_slopes,
            to_natural=lambda u: columns(bounded_exp(u[..., 0])),
            from_natural=lambda p: columns(np.log(p[..., 0])),
            begin=lambda _volume, log_mu: np.array([log_mu.mean()]),
            form="line",
            uses_volume=False,
        ),
    )
}
