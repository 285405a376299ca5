"""Every effect in a synthetic dataset, by key.

An effect is a function of the dataset and a strength. It changes the dataset in place and returns
its true parameters. Strength 0 is no effect; at 1 it is plain to see with 250 events on 10 paths.
"""

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from avahazard.records.errors import AvahazardError, did_you_mean
from avahazard.synth.dataset import WINTER_DAYS, Dataset, Exponential, Power


def volume_law(dataset: Dataset, strength: float) -> dict[str, object]:
    """Another law: log μ moves by `strength` of the way to the power law (or exponential)."""
    other = Exponential() if isinstance(dataset.settings.law, Power) else Power()
    base = dataset.settings.law.log_friction(dataset.volume_m3)
    dataset.log_mu += strength * (other.log_friction(dataset.volume_m3) - base)
    return {"law": type(other).__name__.lower(), "share": strength}


def volume_scatter(dataset: Dataset, strength: float) -> dict[str, object]:
    """σ(V) = a' exp(-n' V), the same as in the base dataset at 60,000 m3."""
    n = 6e-6 * strength
    a = dataset.settings.scatter * float(np.exp(n * 6e4))
    dataset.scatter *= np.exp(-n * (dataset.volume_m3 - 6e4))
    return {"a": a, "n_per_m3": n}


def snow_type(dataset: Dataset, strength: float) -> dict[str, object]:
    """Dry snow runs farther than wet snow."""
    offsets = {"dry": -0.10 * strength, "mixed": 0.0, "wet": 0.13 * strength}
    dataset.log_mu += np.array([offsets[str(kind)] for kind in dataset.columns["snow_type"]])
    return {"log_mu": offsets}


def path_section(dataset: Dataset, strength: float) -> dict[str, object]:
    """Channelled paths have less friction than open ones."""
    half = 0.2 * strength
    channelled = np.array([s.path.section == "channelled" for s in dataset.sites])[dataset.path]
    dataset.log_mu += np.where(channelled, -half, half)
    return {"log_mu": {"channelled": -half, "open": half}}


def release_elevation(dataset: Dataset, strength: float) -> dict[str, object]:
    """log μ falls with the elevation of the release."""
    per_m, middle = -0.0006 * strength, 2200.0
    dataset.log_mu += per_m * (dataset.release_elevation_m - middle)
    return {"log_mu_per_m": per_m, "reference_m": middle}


def season(dataset: Dataset, strength: float) -> dict[str, object]:
    """log μ rises in a straight line from 1 December to the end of April."""
    rise = 0.36 * strength
    dataset.log_mu += rise * (dataset.day / WINTER_DAYS - 0.5)
    return {"log_mu_over_winter": rise, "days": WINTER_DAYS}


def path_effect(dataset: Dataset, strength: float) -> dict[str, object]:
    """Each path has its own offset of log μ."""
    tau = 0.15 * strength
    offsets = tau * dataset.generator("path-effect").normal(size=len(dataset.sites))
    dataset.log_mu += offsets[dataset.path]
    by_path = {s.path.path_id: float(o) for s, o in zip(dataset.sites, offsets, strict=True)}
    return {"tau": tau, "log_mu": by_path}


def covariate(dataset: Dataset, strength: float, column: str) -> dict[str, object]:
    """log μ follows a bent curve of a numeric column, which is made when there is none."""
    if column not in dataset.columns:
        made = dataset.generator(f"covariate {column}").normal(size=len(dataset.path))
        dataset.columns[column] = np.round(made, 3)
    values = dataset.columns[column]
    if values.dtype.kind != "f":
        raise AvahazardError(
            f"The column {column!r} is not numeric.", "Name a numeric column, or a new one."
        )
    middle, sd = float(values.mean()), float(values.std())
    z = (values.astype(float) - middle) / sd
    dataset.log_mu += 0.13 * strength * (np.tanh(2.0 * z) + 0.4 * np.cos(2.0 * z))
    formula = "amplitude (tanh 2z + 0.4 cos 2z), z = (column - middle) / sd"
    return {"log_mu": formula, "amplitude": 0.13 * strength, "middle": middle, "sd": sd}


def centrifugal(dataset: Dataset, strength: float) -> dict[str, object]:
    """Curvature loads the bed: the base dataset has it at 1, strength 0 removes it."""
    for track in dataset.tracks:
        track.centrifugal = strength
    return {"loading": strength}


def turbulent_drag(dataset: Dataset, strength: float) -> dict[str, object]:
    """Deceleration D u², as of Voellmy: D = g / (ξ h), in 1/m."""
    drag = 0.003 * strength
    for track in dataset.tracks:
        track.quadratic += drag
    dataset.log_mu -= 0.25 * strength
    return {"drag_per_m": drag, "log_mu": -0.25 * strength}


def speed_weakening(dataset: Dataset, strength: float) -> dict[str, object]:
    """μ(u) = μ (r + (1 - r) / (1 + u / u0)): friction falls with speed towards r μ."""
    r, u0 = 1.0 - 0.4 * strength, 10.0
    for track in dataset.tracks:
        track.weakening_r, track.weakening_u0 = r, u0
    dataset.log_mu += 0.35 * strength
    return {"r": r, "u0_m_s": u0, "log_mu": 0.35 * strength}


def cohesion(dataset: Dataset, strength: float) -> dict[str, object]:
    """A constant bed resistance c per unit mass, in m/s²."""
    c = 0.8 * strength
    for track in dataset.tracks:
        track.constant += c
    dataset.log_mu -= 0.15 * strength
    return {"cohesion_m_s2": c, "log_mu": -0.15 * strength}


def entrainment(dataset: Dataset, strength: float) -> dict[str, object]:
    """Momentum lost to snow taken up above an elevation: deceleration e u², e in 1/m."""
    e = 0.004 * strength
    z = float(np.round(np.median([s.profile.y_m.max() for s in dataset.sites]) - 500.0))
    for track in dataset.tracks:
        track.split(float(track.place(z)))
        track.quadratic += np.where(track.middles() > z, e, 0.0)
    return {"entrainment_per_m": e, "above_m": z}


def forest_drag(dataset: Dataset, strength: float) -> dict[str, object]:
    """Deceleration D u² in forest cells, D in 1/m."""
    drag = 0.003 * strength
    for track in dataset.tracks:
        track.quadratic += np.where(track.forest, drag, 0.0)
    return {"drag_per_m": drag}


def observation_limit(dataset: Dataset, strength: float) -> dict[str, object]:
    """Short runouts went undetected, and no `observed_below_m` is given."""
    share = 0.35 * strength
    if share > 0.0:
        dataset.unseen_share, dataset.limit_known = share, False
    return {"unseen_share": share}


def epoch_bias(dataset: Dataset, strength: float) -> dict[str, object]:
    """Records before 1950 lie too high up the path."""
    raised, year = 50.0 * strength, 1950
    dataset.raised_m += np.where(dataset.years < year, raised, 0.0)
    return {"before_year": year, "raised_m": raised}


def leading_edge(dataset: Dataset, strength: float) -> dict[str, object]:
    """The record is the front, ahead of the block by a share of the deposit length."""
    dataset.lead_m += 0.6 * strength * dataset.deposit_length_m
    return {"lead_per_deposit_length": 0.6 * strength}


Parameters = dict[str, object]
SyntheticEffect = Callable[[Dataset, float], Parameters]

CATALOGUE: Mapping[str, SyntheticEffect] = {
    effect.__name__.replace("_", "-"): effect
    for effect in (
        centrifugal, turbulent_drag, speed_weakening, cohesion, entrainment, forest_drag,
        volume_law, volume_scatter, snow_type, path_section, release_elevation, season,
        path_effect, observation_limit, epoch_bias, leading_edge,
    )
}  # fmt: skip
DEMO_EFFECT = "snow-type"
"""The effect that the demo hides."""
NEED_SPEEDS = frozenset({"centrifugal", "speed-weakening", "cohesion"})


def find_effect(key: str) -> SyntheticEffect:
    """The effect of a key, `covariate:COLUMN` for any column; refuses an unknown one."""
    if key.startswith("covariate:") and len(key) > len("covariate:"):
        return partial(covariate, column=key.partition(":")[2])
    if key not in CATALOGUE:
        raise AvahazardError(
            f"There is no effect {key!r}.",
            f"{did_you_mean(key, CATALOGUE)}Use one of: {', '.join(CATALOGUE)}, covariate:COLUMN.",
        )
    return CATALOGUE[key]
