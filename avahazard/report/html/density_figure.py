"""Densities of apparent friction by Holy's method (the paper's figure 3)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avahazard.report.html.content import Document
from avahazard.report.html.figure import Figure, Trace, label
from avahazard.report.html.style import BLACK, COLORS, VERMILION, axis, layout
from avahazard.report.language import ENGLISH, Language

NORMAL_POINTS, REACH = 61, 4.0
DASHES = ("solid", "dash", "dot", "dashdot", "longdash", "longdashdot")


def density_figure(
    densities: Sequence[Document], names: dict[str, str], language: Language = ENGLISH
) -> Figure | None:
    """The density of all events thick, that of each path thin; None where there is none."""
    if not densities:
        return None
    say = language.say
    many = len(densities) > len(COLORS)
    span = np.asarray(densities[0]["mu"])
    data: list[Trace] = []
    for k, density in enumerate(densities):
        whole = density["path_id"] == "all"
        mu, pdf = np.asarray(density["mu"]), np.asarray(density["pdf"])
        beyond = np.asarray(density["extrapolated"], dtype=bool)
        of = density["path_id"]
        name = say("all events") if whole else names.get(of, of)
        place = k if whole else list(names).index(density["path_id"])
        color = BLACK if whole else COLORS[place % (len(COLORS) - 1)]
        common: Trace = {
            "type": "scatter",
            "mode": "lines",
            "legendgroup": density["path_id"],
            "visible": True if whole or not many else "legendonly",
            "hovertemplate": "μ = %{x:.3f}<extra>%{fullData.name}</extra>",
            "name": label(f"{name} ({density['n']})"),
        }
        line = {"color": color, "width": 3 if whole else 1.6}
        data.append(
            {
                **common,
                "x": mu[~beyond],
                "y": pdf[~beyond],
                "line": {**line, "dash": "solid" if whole else DASHES[place % len(DASHES)]},
            }
        )
        data.append(
            {
                **common,
                "x": mu[beyond],
                "y": np.where(_gap(beyond)[beyond], np.nan, pdf[beyond]),
                "line": {**line, "width": 0.8, "dash": "dot"},
                "showlegend": False,
                "hoverinfo": "skip",
            }
        )
        if density["sd"] > 0.0:
            data.append(_normal(density, common, whole, color, say("normal of all events")))
    return Figure(
        "density",
        say("How apparent friction is spread"),
        language.plural(
            "Probability density of apparent friction of all events and of {n} path.",
            "Probability density of apparent friction of all events and of {n} paths.",
            len(densities) - 1,
        ),
        say(
            "The area under each curve is 1; the number of events is in brackets. Dotted parts "
            "lie beyond the records: they are an assumption of the method (Holy 1997). Thin lines "
            "are normal distributions of the same mean and standard deviation."
        )
        + (" " + say("Tap a name in the legend to show its path.") if many else ""),
        data,
        layout(
            axis(say("apparent friction μ"), range=[max(0.0, span[0]), span[-1]]),
            axis(say("probability density"), rangemode="tozero"),
        ),
    )


def _normal(density: Document, common: Trace, whole: bool, color: str, name: str) -> Trace:
    """The normal of the same mean and sd, within four of these and friction over 0."""
    mean, sd = density["mean"], density["sd"]
    mu = np.linspace(max(0.0, mean - REACH * sd), mean + REACH * sd, NORMAL_POINTS)
    own = {"name": label(name)} if whole else {"showlegend": False}
    return {
        **common,
        "x": mu,
        "y": np.exp(-0.5 * ((mu - mean) / sd) ** 2) / (sd * np.sqrt(2.0 * np.pi)),
        "line": {"color": VERMILION if whole else color, "width": 1.6 if whole else 0.7},
        "opacity": 1.0 if whole else 0.6,
        "hoverinfo": "skip",
        **own,
    }


def _gap(beyond: np.ndarray) -> np.ndarray:
    """The first place after a break, so that the tails on both sides are not joined."""
    return np.concatenate([[False], beyond[1:] & ~beyond[:-1]])
