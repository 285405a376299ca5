"""Apparent friction, the μ whose block stops where the record says (inverse of F); its density.

And the paper's perturbation check: records moved within their errors, and the spread this causes.
On stepped terrain F jumps and has no inverse there. That is said in the status, and no other part
of the product infers from these values except the paper's own methods, which are built on them.

Holy's density of them (Ancey 2005, equations 2.4; Holy 1997, PRL 79, 3545) is ψ², where ψ maximises
Σ log ψ²(μ_i) less a penalty on ∫ψ'², under ∫ψ² = 1. It is a sum of exponentials at the records,

    ψ(μ) = √κ Σ_i a_i exp(-κ|μ - μ_i|),    a_i ψ(μ_i) = m  (i = 1..N).

Where m is 1 the a_i are at the minimum of ½ aᵀKa - Σ log a_i, K_ij = exp(-κ|μ_i - μ_j|), which is
convex: one solution whatever κ and the ties, found by damped Newton. ∫ψ² = 1 then only scales it.
"""

import math
from dataclasses import dataclass

import numpy as np

from avahazard.arrays import Bools, Floats, Ints
from avahazard.inference.likelihood.predicted import Predicted
from avahazard.inference.model.observations import ELEVATION, LEFT, LENGTH, Observations
from avahazard.inference.seeds import generator
from avahazard.kernels import kernel
from avahazard.physics.block import NOT_RELEASED, STOPPED
from avahazard.physics.runout_curve import MU, RunoutCurve
from avahazard.records.errors import AvahazardError

SEED = 0
"""The perturbation is the same each time that the records are."""
N_REPLICATES = 200
ENOUGH = 0.5
"""Share of replicates with a friction below which no spread is given."""
STATUSES = (
    "unique",  # one friction stops there
    "jump",  # no friction does: F jumps over the record; μ is where it jumps
    "several",  # more than one does; μ is the middle of the outermost
    "above",  # every block goes lower: friction above the table, or a record above the release
    "below",  # no block stops so low: μ is at most mu_high
    "no-record",
)
UNIQUE, JUMP, SEVERAL, ABOVE, BELOW, NO_RECORD = range(6)


@dataclass(frozen=True, slots=True, eq=False)
class ApparentFriction:
    """μ of records, the bracket that F gives, and a code that `STATUSES` names; all of one shape.

    μ is nan for "above" and "below", where only one side of the bracket is finite, and for
    "no-record".
    """

    mu: Floats
    mu_low: Floats
    mu_high: Floats
    status: Ints


@dataclass(frozen=True, slots=True, eq=False)
class BackCalculation(ApparentFriction):
    """Apparent friction of events, each `[n_events]`, and that of records moved by their errors.

    `moved` `[N_REPLICATES, n_events]`, nan where no friction stops at the moved record; `mu_sd`
    `[n_events]` is its spread, nan where fewer than half of the replicates have a friction.
    """

    moved: Floats
    mu_sd: Floats


def back_calculate(observations: Observations, predicted: Predicted) -> BackCalculation:
    """Invert F at every record, and again at `N_REPLICATES` sets of records moved by their errors.

    `predicted` is that of the model without effects. Without a profile μ = H/L.
    """
    straight = observations.kind == LENGTH
    # A place x falls with friction, where elevations rise.
    sign = np.where(observations.kind == ELEVATION, 1.0, -1.0)
    sign[observations.kind == LEFT] = 1.0
    records = np.where(observations.kind == LEFT, -np.inf, sign * observations.observed)
    rows = np.flatnonzero(~straight)
    stop_y = sign[rows, None] * predicted.record[rows]
    tables = np.arange(len(rows)), stop_y, predicted.curve[rows]
    mu = observations.fall_height / observations.observed
    low, high, status = mu.copy(), mu.copy(), np.full(observations.n_events, UNIQUE)
    moved = np.full((N_REPLICATES, observations.n_events), np.nan)
    sd = np.full(observations.n_events, np.nan)
    if len(rows):
        inverse = apparent_friction(records[rows], *tables)
        mu[rows], low[rows] = inverse.mu, inverse.mu_low
        # Where no friction stops the block on the profile, one that held it is too high.
        held = predicted.status[rows] == NOT_RELEASED
        held_from = np.where(held.any(axis=1), MU[held.argmax(axis=1)], np.inf)
        high[rows] = np.minimum(inverse.mu_high, held_from)
        status[rows] = inverse.status
        moved[:, rows], sd[rows] = perturb(records[rows], observations.sigma[rows], *tables)
    if np.any(straight):
        noise = generator(SEED, "perturbation", "straight").standard_normal(
            (N_REPLICATES, int(np.sum(straight)))
        )
        length = observations.observed[straight] + observations.sigma[straight] * noise
        fall = observations.fall_height[straight]
        moved[:, straight] = np.where(length > 0.0, fall / length, np.nan)
        sd[straight] = np.nanstd(moved[:, straight], axis=0, ddof=1)
    return BackCalculation(mu, low, high, status, moved, sd)


def apparent_friction(
    runout: Floats, table: Ints, stop_y: Floats, curves: RunoutCurve
) -> ApparentFriction:
    """Inverts the curves [n_tables, n_mu] at recorded elevations `runout` [..., n_events], m.

    `stop_y` [n_tables, n_mu] is where they stop, in the coordinate of the records and rising, and
    `table` [n_events] the row of each event. Only stops bracket a record; jumps are those of
    `runout_curve`. The record of an event beyond the profile is -inf.
    """
    runout = np.asarray(runout, np.float64)
    rows = runout.reshape(-1, runout.shape[-1])
    stopped = curves.status == STOPPED
    found = _inverted(rows, np.asarray(table), stop_y, stopped, curves.discontinuous)
    return ApparentFriction(*(part.reshape(runout.shape) for part in found))


def perturb(
    runout: Floats,
    runout_sigma: Floats,
    table: Ints,
    stop_y: Floats,
    curves: RunoutCurve,
    *,
    seed: int = SEED,
    n_replicates: int = N_REPLICATES,
) -> tuple[Floats, Floats]:
    """Apparent friction `[n_replicates, n_events]` of records moved by their normal errors.

    `runout`, `runout_sigma` [n_events] in m; the curves as in `apparent_friction`. Returns `moved`
    and `mu_sd` as in `BackCalculation`.
    """
    noise = generator(seed, "perturbation").standard_normal((n_replicates, runout.size))
    mu = apparent_friction(runout + runout_sigma * noise, table, stop_y, curves).mu
    mu_sd = np.full(runout.size, np.nan)
    enough = np.sum(np.isfinite(mu), axis=0) >= max(2.0, ENOUGH * n_replicates)
    mu_sd[enough] = np.nanstd(mu[:, enough], axis=0, ddof=1)
    return mu, mu_sd


@kernel
def _inverted(
    runout: Floats, table: Ints, stop_y: Floats, stopped: Bools, discontinuous: Bools
) -> tuple[Floats, Floats, Floats, Ints]:
    """μ and the `_bracket` of each of `runout` [n_sets, n_events]."""
    mu, low, high = np.full(runout.shape, np.nan), np.empty(runout.shape), np.empty(runout.shape)
    status = np.empty(runout.shape, np.int64)
    for r in range(runout.shape[0]):
        for i in range(runout.shape[1]):
            k = table[i]
            left, right, code = _bracket(runout[r, i], stop_y[k], stopped[k], discontinuous[k])
            low[r, i], high[r, i], status[r, i] = left, right, code
            if code <= SEVERAL:
                mu[r, i] = 0.5 * (left + right)
    return mu, low, high, status


@kernel(inner=True)
def _bracket(
    y: float, stop_y: Floats, stopped: Bools, discontinuous: Bools
) -> tuple[float, float, int]:
    """Smallest and largest μ whose block stops at y (m), and the status code, of one table."""
    if np.isnan(y):
        return np.nan, np.nan, NO_RECORD
    low, high, crossings, at_jump = np.inf, -np.inf, 0, False
    least, first, last = np.inf, -1, -1
    for j in range(stop_y.size):
        if not stopped[j]:
            continue
        above = stop_y[j]
        least = min(least, above)
        if first < 0:
            first = j
        # half-open, so that a record on a grid value counts once
        elif (
            stop_y[last] < y <= above
            or above <= y < stop_y[last]
            or (last == first and y == stop_y[first])
        ):
            below = stop_y[last]
            left, right = MU[last], MU[j]
            crossings += 1
            if j > last + 1 or discontinuous[last]:
                at_jump = True
            elif above != below:
                left = right = left + (right - left) * (y - below) / (above - below)
            low, high = min(low, left), max(high, right)
        last = j
    if crossings > 1:
        return low, high, SEVERAL
    if crossings == 1:
        return low, high, JUMP if at_jump else UNIQUE
    if first < 0:
        return -np.inf, np.inf, BELOW
    if y <= least:
        return -np.inf, MU[first], BELOW
    return MU[last], np.inf, ABOVE


DEFAULT_KAPPA = 5.0
MAX_NEWTON_STEPS = 200
N_FOLDS = 10


@dataclass(frozen=True, slots=True)
class HolyDensity:
    """ψ² by its sources: records `mu` and coefficients `a`, both [n_events], and κ (`kappa`)."""

    mu: Floats
    a: Floats
    kappa: float

    def psi(self, x: Floats) -> Floats:
        """ψ at x [n_points]."""
        distance = np.abs(np.asarray(x, np.float64)[:, None] - self.mu)
        return np.asarray(np.sqrt(self.kappa) * np.exp(-self.kappa * distance) @ self.a)

    def pdf(self, x: Floats) -> Floats:
        """The density ψ² at x [n_points]."""
        return self.psi(x) ** 2

    def extrapolated(self, x: Floats) -> Bools:
        """Where x [n_points] lies outside the records, and the density is a tail by assumption."""
        x = np.asarray(x, np.float64)
        return np.asarray((x < self.mu.min()) | (x > self.mu.max()))


def holy_density(mu: Floats, kappa: float = DEFAULT_KAPPA) -> HolyDensity:
    """Solves equations 2.4 for the records `mu` [n_events] (others than finite are left out).

    1/κ is the length over which one record spreads ψ. The default κ = 5 (a length of 0.2, where
    frictions range over 0.2 to 0.8) is the paper's and smooths strongly: one peak from whatever
    records. `choose_kappa` lets the data choose. Raises `AvahazardError` without records or with
    κ not positive.
    """
    mu = np.sort(np.asarray(mu, np.float64))
    mu = mu[np.isfinite(mu)]
    if mu.size == 0:
        raise AvahazardError("There is no apparent friction to make a density of.")
    if not (np.isfinite(kappa) and kappa > 0):
        raise AvahazardError(f"κ is {kappa}.", "It must be a positive number, such as 5.")
    a, solved = _solve(mu, float(kappa))
    if not solved:
        raise AvahazardError(
            "The friction density did not converge.", "Choose another κ; 5 is the paper's."
        )
    # ∫ψ² over the line: Σ a_i a_j (1 + κd_ij) exp(-κd_ij).
    d = kappa * np.abs(mu[:, None] - mu)
    a /= np.sqrt(a @ ((1.0 + d) * np.exp(-d)) @ a)
    return HolyDensity(mu, a, kappa)


def choose_kappa(mu: Floats) -> float:
    """The κ with the largest held-out likelihood in ten folds of the records `mu` [n_events].

    Equal records fall in one fold, since a record must not vouch for its copy. 24 values are
    tried, from one to two hundred per range of the records. With fewer than five different
    records there is nothing to choose by, and κ is 5.
    """
    mu = np.asarray(mu, np.float64)
    mu = mu[np.isfinite(mu)]
    values, group = np.unique(mu, return_inverse=True)
    if values.size < 5:
        return DEFAULT_KAPPA
    candidates = np.geomspace(1.0, 200.0, 24) / (values[-1] - values[0])
    fold = group % min(N_FOLDS, values.size)
    scores = [_held_out(mu, fold, float(kappa)) for kappa in candidates]
    return float(candidates[int(np.argmax(scores))])


def _held_out(mu: Floats, fold: Ints, kappa: float) -> float:
    total = 0.0
    for k in range(int(fold.max()) + 1):
        psi = holy_density(mu[fold != k], kappa).psi(mu[fold == k])
        total += float(np.sum(2.0 * np.log(np.maximum(psi, 1e-300))))
    return total


@kernel
def _solve(mu: Floats, kappa: float) -> tuple[Floats, bool]:
    """a > 0 with a_i Σ_j K_ij a_j = 1, of sorted `mu` [n_events]; and whether Newton got there.

    The minimum of ½ aᵀKa - Σ log a_i, a self-concordant function, so that steps of
    1/(1 + decrement) converge from anywhere. K is that of a first-order process: its products
    and the factors of K + diag(1/a²) are recursions along the sorted records (Foreman-Mackey et
    al. 2017, AJ 154, 220), stable with ties since a never exceeds 1.
    """
    n = mu.size
    decay = np.zeros(n)
    for i in range(1, n):
        decay[i] = math.exp(-kappa * (mu[i] - mu[i - 1]))
    a = 1.0 / np.sqrt(_times_kernel(decay, np.ones(n)))
    pivot, weight, step = np.empty(n), np.empty(n), np.empty(n)
    for _ in range(MAX_NEWTON_STEPS):
        gradient = _times_kernel(decay, a) - 1.0 / a
        carried, before = 0.0, 0.0
        for i in range(n):
            if i > 0:
                carried = decay[i] ** 2 * (carried + pivot[i - 1] * weight[i - 1] ** 2)
                before = decay[i] * (before + weight[i - 1] * step[i - 1])
            pivot[i] = 1.0 + 1.0 / a[i] ** 2 - carried
            weight[i] = (1.0 - carried) / pivot[i]
            step[i] = -gradient[i] - before
        step /= pivot
        after = 0.0
        for i in range(n - 2, -1, -1):
            after = decay[i + 1] * (after + step[i + 1])
            step[i] -= weight[i] * after
        decrement = math.sqrt(max(-(gradient * step).sum(), 0.0))
        a += step / (1.0 + decrement) if decrement > 0.25 else step
        if decrement < 1e-11:
            return a, True
    return a, False


@kernel(inner=True)
def _times_kernel(decay: Floats, a: Floats) -> Floats:
    """Ka in one pass each way."""
    result = a.copy()
    left, right = 0.0, 0.0
    for i in range(1, a.size):
        left = decay[i] * (left + a[i - 1])
        result[i] += left
    for i in range(a.size - 2, -1, -1):
        right = decay[i + 1] * (right + a[i + 1])
        result[i] += right
    return result
