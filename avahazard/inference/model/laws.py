"""Laws of friction against volume; one that is added to `LAWS` is everywhere.

Each law has two sets of parameters. The natural ones are what people read (`names`, `units`).
The coordinates are what samplers and optimisers move in: unbounded and of order one, so that a
normal prior and a step of 0.1 make sense for each. Arrays of either end in the parameter axis.
Curves take coordinates u `[..., n_coordinates]` and volumes `[n_events]` in m3; slopes are
derivatives of log μ `[n_coordinates, n_events]` at u `[n_coordinates]`, 0 where log μ is bounded.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from scipy.special import expit

from avahazard.arrays import Floats
from avahazard.records.errors import AvahazardError, did_you_mean

Covariate = Callable[[Floats], Floats]
Curve = Callable[[Floats, Floats], Floats]

N_SCALE = 1e-6  # 1/m3; n of the exponential law is of this order on paths of 1e4 to 1e6 m3
C_SCALE = 1e5  # m3; the volume where a rational law bends
MOST_LOG = 50.0
"""Log μ of every law is kept within ± this: far beyond what is physical, and no square overflows.

Volumes may be any positive number that a computer knows.
"""

LEAST_SIZE = 1e-100
"""Numbers below are no covariate: a slope over them would overflow."""


def bounded(log_mu: Floats) -> Floats:
    """Log μ within ± `MOST_LOG`."""
    return np.asarray(np.minimum(np.maximum(log_mu, -MOST_LOG), MOST_LOG), np.float64)


def bounded_exp(u: Floats) -> Floats:
    """exp u, of coordinates that an optimiser may throw far off."""
    return np.asarray(np.exp(np.clip(u, -MOST_LOG, MOST_LOG)), np.float64)


def rational(u: Floats, volume: Floats) -> Floats:
    """log a/b - log(1 + (V/c)^n / b), with b = 1 in coordinates."""
    bend = bounded_exp(u[..., 2:3]) * (log_in_c(volume) - u[..., 1:2])
    return bounded(u[..., 0:1] - np.logaddexp(0.0, bend))


def asymptotic(u: Floats, volume: Floats) -> Floats:
    """log a + log(e^(-nV) + (1 - e^(-nV)) μ∞/a): a sum of what is positive, so no digits go."""
    reach = bounded_exp(u[..., 2:3] + np.log(volume) + np.log(N_SCALE))
    share = np.exp(-reach) - bounded_exp(u[..., 1:2]) * np.expm1(-reach)
    return bounded(u[..., 0:1] + np.log(share))


def constant(u: Floats, volume: Floats) -> Floats:
    """log a."""
    return bounded(u[..., 0:1] + np.zeros_like(volume))


def columns(*parameters: Floats) -> Floats:
    """Parameters `[...]` each, side by side `[..., n_parameters]`."""
    return np.stack(np.broadcast_arrays(*parameters), axis=-1)


def rational_to_natural(u: Floats) -> Floats:
    """a, b = 1, c (m3), n."""
    a, c, n = bounded_exp(u[..., 0]), C_SCALE * bounded_exp(u[..., 1]), bounded_exp(u[..., 2])
    return columns(a, np.ones_like(a), c, n)


def rational_from_natural(p: Floats) -> Floats:
    """Of any b."""
    a, b, c, n = p[..., 0], p[..., 1], p[..., 2], p[..., 3]
    return columns(np.log(a / b), np.log(c / C_SCALE) + np.log(b) / n, np.log(n))


def rational_begin(volume: Floats, log_mu: Floats) -> Floats:
    """At the middle volume, then where the power law's slope is half of n."""
    slope = max(line(np.log(volume), log_mu)[1] * -1.0, 0.05)
    level = float(np.median(log_in_c(volume)))
    return np.array([log_mu.mean() + np.log(2.0), level, np.log(2 * slope)])


def asymptotic_to_natural(u: Floats) -> Floats:
    """a, μ∞, n (1/m3)."""
    a, n = bounded_exp(u[..., 0]), N_SCALE * bounded_exp(u[..., 2])
    return columns(a, a * bounded_exp(u[..., 1]), n)


def asymptotic_from_natural(p: Floats) -> Floats:
    """Of a, μ∞, n."""
    a, least, n = p[..., 0], p[..., 1], p[..., 2]
    return columns(np.log(a), np.log(least) - np.log(a), np.log(n / N_SCALE))


def asymptotic_begin(volume: Floats, log_mu: Floats) -> Floats:
    """The best line in e^(-nV), over a few n about the reciprocal of the middle volume."""
    middle = float(np.exp(np.median(np.log(volume))))
    best, found = np.inf, np.array([log_mu.mean(), 0.0, 0.0])
    for share in (0.03, 0.1, 0.3, 1.0, 3.0):
        n = np.clip(share / middle / N_SCALE, 1e-4, 1e4)
        fallen = -np.expm1(-n * in_millions(volume))
        log_a, slope = line(fallen, log_mu)
        misfit = float(np.sum((log_mu - log_a - slope * fallen) ** 2))
        if misfit < best:
            best, found = misfit, np.array([log_a, np.clip(slope, -2.0, 2.0), np.log(n)])
    return found


def in_millions(volume: Floats) -> Floats:
    """V in 1e6 m3."""
    return np.asarray(volume * N_SCALE, np.float64)


def log_in_c(volume: Floats) -> Floats:
    """log V in 1e5 m3."""
    return np.asarray(np.log(volume) - np.log(C_SCALE), np.float64)


def line(x: Floats, y: Floats) -> tuple[float, float]:
    """Intercept and slope; x is taken in its own size, so that no square overflows."""
    size = float(np.max(np.abs(x)))
    if size < LEAST_SIZE:
        return float(y.mean()), 0.0
    x = x / size
    centred = x - x.mean()
    spread = float(centred @ centred)
    # Equal x differ by rounding at most.
    slope = float(centred @ y) / spread if spread > 1e-24 * len(x) else 0.0
    return float(y.mean() - slope * x.mean()), slope / size


def rational_slopes(u: Floats, volume: Floats) -> Floats:
    """Of log a - log(1 + (V/c)^n)."""
    n = float(bounded_exp(u[2]))
    bend = n * (log_in_c(volume) - u[1])
    share = expit(bend)
    log_mu = u[0] - np.logaddexp(0.0, bend)
    return _inside(log_mu, np.ones_like(bend), n * share, -bend * share)


def asymptotic_slopes(u: Floats, volume: Floats) -> Floats:
    """Of log a + log(e^(-nV) + (1 - e^(-nV)) μ∞/a)."""
    reach = bounded_exp(u[2] + np.log(volume) + np.log(N_SCALE))
    limit, still = float(bounded_exp(u[1])), np.exp(-reach)
    fallen = -limit * np.expm1(-reach)
    share = still + fallen
    by_reach = still * (limit - 1.0) * reach / share
    return _inside(u[0] + np.log(share), np.ones_like(reach), fallen / share, by_reach)


def constant_slopes(u: Floats, volume: Floats) -> Floats:
    """Of log a."""
    return _inside(u[0] + np.zeros_like(volume), np.ones_like(volume))


def line_in(covariate: Covariate) -> dict[str, Any]:
    """What a law has that is a line u0 - u1 x in its covariate x, by the names of `Law`."""

    def log_friction(u: Floats, volume: Floats) -> Floats:
        with np.errstate(over="ignore"):  # bounded then
            return bounded(u[..., 0:1] - u[..., 1:2] * covariate(volume))

    def slopes(u: Floats, volume: Floats) -> Floats:
        x = covariate(volume)
        with np.errstate(over="ignore"):  # beyond the bounds then
            return _inside(u[0] - u[1] * x, np.ones_like(x), -x)

    def begin(volume: Floats, log_mu: Floats) -> Floats:
        intercept, slope = line(covariate(volume), log_mu)
        return np.array([intercept, -slope])

    return {
        "log_friction": log_friction,
        "slopes": slopes,
        "begin": begin,
        "form": "line",
        "covariate": covariate,
    }


def _inside(log_mu: Floats, *slopes: Floats) -> Floats:
    return np.where(np.abs(log_mu) < MOST_LOG, np.stack(slopes), 0.0)


def usable(volume: Floats, mu: Floats) -> tuple[Floats, Floats]:
    """The pairs of volume and friction that are finite and positive, `[n_usable]` each."""
    volume, mu = np.asarray(volume, np.float64), np.asarray(mu, np.float64)
    keep = np.isfinite(volume) & np.isfinite(mu) & (volume > 0) & (mu > 0)
    return volume[keep], mu[keep]


def differences(f: Callable[[Floats], Floats], at: Floats, scale: Floats) -> Floats:
    """Central differences `[d, n]` of f `[..., n]` by each of `at` `[d]`, in units of `scale`."""
    steps = 1e-5 * np.diag(scale)
    return np.asarray((f(at + steps) - f(at - steps)) / 2e-5)


@dataclass(frozen=True, slots=True)
class Law:
    """A law μ = G(V) and the coordinates in which it is sampled.

    `formula` is for tables, `words` for the report. `log_friction(u, volume)`: log μ, [...,
    n_events], of coordinates [..., n_coordinates] and volumes [n_events] in m3; `slopes` are its
    derivatives [n_coordinates, n_events] at one u. `to_natural` and `from_natural` convert between
    the two sets of parameters. `prior_mean` and `prior_sd` are independent normals on the
    coordinates. `begin` gives coordinates from volumes and log μ [n_events] of which all are known.

    `form` is what the paper's samplers know of a law, in x = `covariate(volume)`: `line`, log μ =
    u0 - u1 x; `bend`, log μ = u0 - log(1 + exp(n (x - u1))) with n = exp u2; None, they refuse it.
    """

    name: str
    formula: str
    words: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    coordinates: tuple[str, ...]
    prior_mean: Floats
    prior_sd: Floats
    log_friction: Curve
    slopes: Curve
    to_natural: Callable[[Floats], Floats]
    from_natural: Callable[[Floats], Floats]
    begin: Curve
    form: Literal["line", "bend"] | None = None
    covariate: Covariate = np.zeros_like
    uses_volume: bool = True

    def friction(self, natural: Floats, volume: Floats) -> Floats:
        """μ [..., n_events] of natural parameters [..., n_parameters]."""
        return np.exp(self.log_friction(self.from_natural(natural), volume))

    def __reduce__(self) -> tuple[Callable[[str], Law], tuple[str]]:
        """Other processes find the law by its name."""
        return law, (self.name,)

    def start(self, volume: Floats, mu: Floats) -> Floats:
        """Coordinates [n_coordinates] near the least-squares fit of log μ, to start from."""
        volume, mu = usable(volume, mu)
        return self.begin(volume, np.log(mu)) if len(mu) else self.prior_mean.copy()


def law(name: str) -> Law:
    """The law of that name; `AvahazardError` lists the names when there is none."""
    if name not in LAWS:
        hint = f"{did_you_mean(name, LAWS)}Laws: {', '.join(LAWS)}."
        raise AvahazardError(f"There is no law '{name}'.", hint)
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
            to_natural=lambda u: columns(bounded_exp(u[..., 0]), u[..., 1] * N_SCALE),
            from_natural=lambda p: columns(np.log(p[..., 0]), p[..., 1] / N_SCALE),
            **line_in(in_millions),
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
            to_natural=lambda u: columns(bounded_exp(u[..., 0]), u[..., 1]),
            from_natural=lambda p: columns(np.log(p[..., 0]), p[..., 1]),
            **line_in(np.log),
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
