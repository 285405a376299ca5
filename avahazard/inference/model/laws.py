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

from avahazard.records.errors import AvahazardError

Array = NDArray[np.float64]

MOST_LOG = 50.0
N_SCALE = 1e-6  # 1/m3; n of the exponential law is of this order on paths of 1e4 to 1e6 m3
C_SCALE = 1e5  # m3; the volume where a rational law bends


@dataclass(frozen=True, slots=True)
class Law:
    """A law μ = G(V) and the coordinates in which it is sampled.

    `formula` is for tables, `words` for the report. `log_friction(u, volume)`: log μ,
    [..., n_events], of coordinates [..., n_coordinates] and volumes [n_events] in m3. `to_natural`
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


def _finite(log_friction: Array) -> Array:
    """Keep the friction a number for every volume, far beyond what any block could tell apart."""
    result: Array = np.clip(log_friction, -MOST_LOG, MOST_LOG)
    return result


def _exponential(u: Array, volume: Array) -> Array:
    return _finite(u[..., 0:1] - u[..., 1:2] * (volume * N_SCALE))


def _power(u: Array, volume: Array) -> Array:
    return _finite(u[..., 0:1] - u[..., 1:2] * np.log(volume))


def _rational(u: Array, volume: Array) -> Array:
    n = np.exp(u[..., 2:3])
    bend = n * (np.log(volume / C_SCALE) - u[..., 1:2])
    result: Array = u[..., 0:1] - np.logaddexp(0.0, bend)
    return result


def _constant(u: Array, volume: Array) -> Array:
    result: Array = u[..., 0:1] + np.zeros_like(volume)
    return result


def _columns(*columns: Array) -> Array:
    result: Array = np.stack(np.broadcast_arrays(*columns), axis=-1)
    return result


def _rational_to_natural(u: Array) -> Array:
    a, c, n = np.exp(u[..., 0]), C_SCALE * np.exp(u[..., 1]), np.exp(u[..., 2])
    return _columns(a, np.ones_like(a), c, n)


def _rational_from_natural(p: Array) -> Array:
    a, b, c, n = p[..., 0], p[..., 1], p[..., 2], p[..., 3]
    return _columns(np.log(a / b), np.log(c / C_SCALE) + np.log(b) / n, np.log(n))


def _rational_begin(volume: Array, log_mu: Array) -> Array:
    """At the middle volume, then where the power law's slope is half of n."""
    slope = max(_line(np.log(volume), log_mu)[1] * -1.0, 0.05)
    level = float(np.median(volume))
    return np.array([log_mu.mean() + np.log(2.0), np.log(level / C_SCALE), np.log(2 * slope)])


def _line_begin(covariate: Callable[[Array], Array]) -> Callable[[Array, Array], Array]:
    def begin(volume: Array, log_mu: Array) -> Array:
        intercept, slope = _line(covariate(volume), log_mu)
        return np.array([intercept, -slope])

    return begin


def _in_millions(volume: Array) -> Array:
    return volume * N_SCALE


def _line(x: Array, y: Array) -> tuple[float, float]:
    centred = x - x.mean()
    spread = float(centred @ centred)
    slope = float(centred @ y) / spread if spread > 0 else 0.0
    return float(y.mean() - slope * x.mean()), slope


# The priors are weak on purpose. Back-calculated frictions of snow avalanches lie in 0.15 to 1.2
# (Ancey 2005, figure 1 and table 2), so log a has centre log 0.5 and sd 0.5: 95 % in 0.19 to 1.33.
# n reached 9.4e-6 per m3 in figure 1 and may have either sign: sd 10 in units of 1e-6. α is the
# friction of 1 m3, an extrapolation over four decades: sd 1. β was 0.065 in figure 1 and about
# 0.085 for rock avalanches: sd 0.2, either sign. The rational law bends anywhere in 1e3 to 1e7 m3.
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
            log_friction=_exponential,
            to_natural=lambda u: _columns(np.exp(u[..., 0]), u[..., 1] * N_SCALE),
            from_natural=lambda p: _columns(np.log(p[..., 0]), p[..., 1] / N_SCALE),
            begin=_line_begin(_in_millions),
            form="line",
            covariate=_in_millions,
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
            log_friction=_power,
            to_natural=lambda u: _columns(np.exp(u[..., 0]), u[..., 1]),
            from_natural=lambda p: _columns(np.log(p[..., 0]), p[..., 1]),
            begin=_line_begin(np.log),
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
            log_friction=_rational,
            to_natural=_rational_to_natural,
            from_natural=_rational_from_natural,
            begin=_rational_begin,
            form="bend",
            covariate=lambda volume: np.log(volume / C_SCALE),
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
            log_friction=_constant,
            to_natural=lambda u: _columns(np.exp(u[..., 0])),
            from_natural=lambda p: _columns(np.log(p[..., 0])),
            begin=lambda _volume, log_mu: np.array([log_mu.mean()]),
            form="line",
            uses_volume=False,
        ),
    )
}
