"""Figures of the model: friction against volume, its density, the posterior."""

from collections.abc import Mapping, Sequence
from itertools import islice
from typing import Any

import numpy as np

from avahazard.arrays import Floats
from avahazard.report.html import figure as fig
from avahazard.report.html.content import EventView, FrictionView
from avahazard.report.html.figure import Figure, Trace
from avahazard.report.language import say, spoken
from avahazard.report.model_tables import offsets_of
from avahazard.report.words import number, unit_text
from avahazard.results.calibration import Calibration, ParameterSummary
from avahazard.results.friction import FrictionDensity


def law_traces(view: FrictionView) -> list[Trace]:
    """The median law with its 90 %, upon the bands that hold 50 and 90 % of avalanches."""
    x = view.volume
    data: list[Trace] = []
    if view.scatter is not None:
        q05, q25, q75, q95 = view.scatter
        data.append(fig.area(x, q05, q95, "rgba(86,180,233,0.22)", name=say("90 % of avalanches")))
        data.append(fig.area(x, q25, q75, "rgba(86,180,233,0.40)", name=say("50 % of avalanches")))
    low, middle, high = view.law
    hover = say(
        "V = {volume} m³: median friction {friction}", volume="%{x:,.0f}", friction="%{y:.3f}"
    )
    name = say("median, with 90 % credible interval")
    data.append(fig.line(x, middle, fig.BLUE, 2.5, hover, name=name, legendgroup="law"))
    for edge in (low, high):
        own: Trace = {"dash": "dash", "legendgroup": "law", "showlegend": False}
        data.append(fig.line(x, edge, fig.BLUE, 1.2, **own))
    return data


def friction_figure(
    view: FrictionView, events: Sequence[EventView], names: dict[str, str]
) -> Figure:
    """Median friction with the bands of the avalanches and of the law, and apparent frictions."""
    data = law_traces(view)
    shown = [e for e in events if e.mu_reference is not None and e.volume_m3]
    hover = say("apparent friction {friction}", friction="%{y:.3f}")
    for name, look, rows in fig.by_path(shown, range(len(shown)), names):
        look["opacity"], selected = 0.8, [shown[k] for k in rows]
        volume, mu = [e.volume_m3 for e in selected], [e.mu_reference for e in selected]
        data.append(fig.event_marks(volume, mu, look, selected, names, hover, name=name))
    counts = {"shown": len(shown), "lacking": len(events) - len(shown)}
    if view.scatter is not None:
        counts["inside"] = _inside(view.volume, view.scatter, shown)
    volumes = fig.axis(say("volume (m³)"), type="log", exponentformat="power", dtick=1)
    places = fig.layout(volumes, fig.axis(say("friction μ")), height=470)
    return Figure("friction", say("Friction against volume"), data, places, counts=counts)


def _inside(volume: Floats, scatter: Floats, events: Sequence[EventView]) -> int:
    """How many points lie in the wide band."""
    log_volume = np.log([e.volume_m3 or np.nan for e in events])
    low, high = (np.interp(log_volume, np.log(volume), scatter[k]) for k in (0, 3))
    mu = np.array([e.mu_reference for e in events], np.float64)
    return int(np.sum((mu >= low) & (mu <= high)))


DASHES = ("solid", "dash", "dot", "dashdot", "longdash", "longdashdot")


def density_figure(densities: Sequence[FrictionDensity], names: Mapping[str, str]) -> Figure | None:
    """The density of all events thick, that of each path thin; None where there is none."""
    if not densities:
        return None
    many, all_events = len(densities) > len(fig.COLORS), say("all events")
    span = np.asarray(densities[0].mu)
    data: list[Trace] = []
    for k, density in enumerate(densities):
        whole, of = density.path_id == "all", density.path_id
        mu, pdf = np.asarray(density.mu), np.asarray(density.pdf)
        beyond = np.asarray(density.extrapolated, dtype=bool)
        place = k if whole or of not in names else list(names).index(of)
        color = fig.BLACK if whole else fig.COLORS[place % (len(fig.COLORS) - 1)]
        common: Trace = {
            "legendgroup": of,
            "visible": True if whole or not many else "legendonly",
            "name": fig.label(f"{all_events if whole else names.get(of, of)} ({density.n})"),
        }
        dash, width = ("solid", 3.0) if whole else (DASHES[place % len(DASHES)], 1.6)
        hover = "μ = %{x:.3f}<extra>%{fullData.name}</extra>"
        data.append(fig.line(mu[~beyond], pdf[~beyond], color, width, hover, dash=dash, **common))
        # The first place after a break is none, so that the tails on both sides are not joined.
        gap = np.concatenate([[False], beyond[1:] & ~beyond[:-1]])
        tails = np.where(gap[beyond], np.nan, pdf[beyond])
        data.append(fig.line(mu[beyond], tails, color, 0.8, dash="dot", **common, showlegend=False))
        if density.sd > 0.0:
            mu, pdf = normal_line(density.mean, density.sd)
            name = fig.label(say("normal of all events"))
            own = {"name": name} if whole else {"showlegend": False}
            color, width = (fig.VERMILION, 1.6) if whole else (color, 0.7)
            look = {**common, **own, "opacity": 1.0 if whole else 0.6}
            data.append(fig.line(mu[mu >= 0.0], pdf[mu >= 0.0], color, width, **look))
    across = fig.axis(say("apparent friction μ"), range=[max(0.0, span[0]), span[-1]])
    upwards = fig.axis(say("probability density"), rangemode="tozero")
    places = fig.layout(across, upwards, height=420 + 4 * len(densities))
    return Figure("density", say("How apparent friction is spread"), data, places)


REACH, NORMAL_POINTS = 4.0, 61


def normal_line(mean: float, sd: float) -> tuple[Floats, Floats]:
    """The density of a normal within four standard deviations."""
    z = np.linspace(-REACH, REACH, NORMAL_POINTS)
    return mean + sd * z, np.exp(-0.5 * z * z) / (sd * np.sqrt(2.0 * np.pi))


BINS, JOINT_DRAWS = 36, 800
HELD = ((0.5, "solid"), (0.9, "dash"))
"""What the ellipses of two parameters hold."""
SMALL_PX, SMALL_MARGIN = 246, {"l": 62, "r": 20, "t": 10, "b": 62}


def posterior_figures(
    parameters: Mapping[str, ParameterSummary], draws: Mapping[str, Floats]
) -> list[Figure]:
    """A histogram for every parameter that moves, and the first two against each other.

    Over each histogram lies the normal of the draws' mean and standard deviation.
    """
    moving = {name: v for name, v in draws.items() if np.ptp(v) > 0.0}
    figures = [
        _histogram(k, name, values, parameters[name])
        for k, (name, values) in enumerate(moving.items())
    ]
    if len(moving) > 1:
        one, other = islice(moving.items(), 2)
        figures.append(_joint(one, other))
    return figures


def offsets_figure(model: Calibration, names: Mapping[str, str]) -> Figure | None:
    """How far each path's friction lies from that of all; None without a path effect."""
    rows = offsets_of(model).items()
    if not rows:
        return None
    low, middle, high = (
        100.0 * np.expm1([getattr(p, key) for _, p in rows]) for key in ("q05", "mean", "q95")
    )
    paths = [fig.label(names.get(path_id, path_id)) for path_id, _ in rows]
    look, bar = {"color": fig.BLUE, "size": 8}, fig.error_bar(low, middle, high, fig.BLUE)
    against = say("friction against that of all paths (%)")
    across = fig.axis(against, zeroline=True, zerolinecolor="#555")
    data = [fig.marks(middle, paths, look, "%{y}: %{x:+.1f} %", error_x=bar)]
    places = fig.layout(across, fig.rows_axis(), height=110 + 26 * len(rows))
    return Figure("offsets", say("What sets the paths apart"), data, places)


def _histogram(k: int, name: str, values: Floats, summary: ParameterSummary) -> Figure:
    counts, edges = np.histogram(values, bins=BINS, density=True)
    middle = 0.5 * (edges[1:] + edges[:-1])
    inside = (middle >= summary.q05) & (middle <= summary.q95)
    unit = f" {unit_text(summary.unit)}" if summary.unit else ""
    values_of = {"mean": summary.mean, "low": summary.q05, "high": summary.q95}
    told = {key: number(value) for key, value in values_of.items()}
    numbers = say("mean {mean}{unit}; 90 % between {low} and {high}{unit}", **told, unit=unit)
    histogram: Trace = {
        "type": "bar",
        "x": middle,
        "y": counts,
        "width": float(edges[1] - edges[0]),
        "marker": {"color": np.where(inside, fig.BLUE, fig.SKY).tolist(), "line": {"width": 0}},
        "hovertemplate": "%{x}<extra></extra>",
    }
    curve = normal_line(float(np.mean(values)), float(np.std(values)))
    normal = fig.line(*curve, fig.VERMILION, 1.8)
    title = fig.label(name) + (f"<br>({fig.label(unit.strip())})" if unit else "")
    across = _small_axis(title, range=[edges[0], edges[-1]])
    upwards = fig.axis("", showticklabels=False, ticks="", rangemode="tozero")
    places = fig.layout(across, upwards, SMALL_PX, margin=SMALL_MARGIN, showlegend=False, bargap=0)
    return Figure(f"posterior-{k + 1}", name, [histogram, normal], places, numbers)


def _small_axis(title: str, **more: Any) -> dict[str, Any]:
    """An axis with few ticks and small words: units are long in French."""
    small = fig.axis(title, exponentformat="power", nticks=3, **more)
    return {**small, "title": {**small["title"], "font": {"size": 12}}}


def _joint(one: tuple[str, Floats], other: tuple[str, Floats]) -> Figure:
    (name, x), (named, y) = one, other
    every = max(1, len(x) // JOINT_DRAWS)
    r = spoken().number(f"{np.corrcoef(x, y)[0, 1]:.2f}")
    data = [fig.marks(x[::every], y[::every], {"color": fig.VERMILION, "size": 3, "opacity": 0.5})]
    root = np.linalg.cholesky(np.cov(x, y) + 1e-12 * np.diag([x.var(), y.var()]))
    angle = np.linspace(0.0, 2.0 * np.pi, 61)
    for share, dash in HELD:
        # χ² with two degrees of freedom is exponential.
        ring = root @ [np.cos(angle), np.sin(angle)] * np.sqrt(-2.0 * np.log1p(-share))
        data.append(fig.line(x.mean() + ring[0], y.mean() + ring[1], fig.BLACK, 1.2, dash=dash))
    across, upwards = _small_axis(fig.label(name)), _small_axis(fig.label(named))
    margin = {**SMALL_MARGIN, "l": 88}
    places = fig.layout(across, upwards, SMALL_PX, margin=margin, showlegend=False)
    title = say("{one} and {other} together", one=name, other=named)
    words = say("correlation {r}; the ellipses of a normal hold 50 and 90 %", r=r)
    return Figure("posterior-joint", title, data, places, words)
