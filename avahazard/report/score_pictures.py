"""Pictures of scores: where a model fails, candidate effects, the error from model to model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from avahazard.criticism.scoring.error_budget import UNEXPLAINED
from avahazard.criticism.screening.significance import LEVEL
from avahazard.report.picture import figure, picture
from avahazard.report.words import SIGNIFICANT, coordinate_words, part_words
from avahazard.results.base import RATIO, amount, unit_of
from avahazard.results.comparison import Comparison, Failure, MeasuredForce
from avahazard.results.diagnosis import Candidate, Diagnosis
from avahazard.results.ladder import Rung

if TYPE_CHECKING:
    from matplotlib.axes import Axes


MOST_ROWS = 20
# Told apart by colour-blind readers too.
FAILS, OTHER = "#d95f02", "0.7"


def draw_comparison(file: Path, comparison: Comparison) -> None:
    """Draw a comparison to `file`: the worst levels, and measured force if any.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    force = comparison.measured_force
    n_panels = 1 + bool(force) if comparison.where_it_fails else 1
    with figure(file, (8.0 if n_panels == 1 else 12.0, 5.0)) as drawn:
        if comparison.where_it_fails or not force:
            _draw_bias(drawn.add_subplot(1, n_panels, 1), comparison)
        if force:
            _draw_force(drawn.add_subplot(1, n_panels, n_panels), force)


def _draw_bias(axes: Axes, comparison: Comparison) -> None:
    from matplotlib.patches import Patch  # noqa: PLC0415 (slow)

    rows = list(reversed(comparison.where_it_fails[:MOST_ROWS]))
    certain = [row.p_value < SIGNIFICANT for row in rows]
    colors = [FAILS if yes else OTHER for yes in certain]
    axes.barh(np.arange(len(rows)), [row.bias_m for row in rows], color=colors, height=0.7)
    axes.set_yticks(np.arange(len(rows)), [_name(row) for row in rows], fontsize=8)
    floor = comparison.scores.runout.noise_floor_m
    axes.axvspan(-floor, floor, color="tab:blue", alpha=0.2, lw=0)
    axes.axvline(0.0, color="black", linewidth=0.8)
    axes.margins(x=0.08)
    of = f"{unit_of(comparison.coordinate)} of {coordinate_words(comparison.coordinate)}"
    axes.set_xlabel(f"mean miss ({of})\n← {_less(comparison)}          {_more(comparison)} →")
    axes.set_title(f"Where {comparison.model} fails", pad=36)
    axes.spines[["top", "right"]].set_visible(False)
    patches = [Patch(color="tab:blue", alpha=0.2, label="error of one recorded runout")]
    if not all(certain):
        patches.insert(0, Patch(color=OTHER, label="could be chance"))
    if any(certain):
        patches.insert(0, Patch(color=FAILS, label=f"not chance (p < {SIGNIFICANT:g}, corrected)"))
    axes.legend(
        handles=patches,
        fontsize=8,
        ncols=2,
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
        frameon=False,
    )


def _name(row: Failure) -> str:
    """The level in words, with how many events it has."""
    axis = row.axis.removesuffix("_m").replace("_", " ")
    return f"{axis}: {row.level} ({row.n})"


def _draw_force(axes: Axes, force: Sequence[MeasuredForce]) -> None:
    for event in dict.fromkeys(row.event_id for row in force):
        mine = [row for row in force if row.event_id == event]
        axes.errorbar(
            [row.speed_m_s for row in mine],
            [row.force_m_s2 for row in mine],
            [row.sd_m_s2 for row in mine],
            fmt="o",
            markersize=3,
            linewidth=0.6,
        )
    axes.axhline(0.0, color="black", linewidth=0.8)
    axes.set_xlabel("speed u (m/s)")
    axes.set_ylabel("resisting force per mass g sinθ - u du/dξ (m/s²)")
    axes.set_title("flat: Coulomb friction; rising as u²: drag", fontsize=9)


def _less(comparison: Comparison) -> str:
    """What a negative miss (predicted less recorded, in the record's coordinate) means."""
    along = comparison.coordinate in ("x", "length")
    return "records lie farther" if along else "records stop short"


def _more(comparison: Comparison) -> str:
    along = comparison.coordinate in ("x", "length")
    return "records stop short" if along else "records lie farther"


MOST_CANDIDATES = 16
# Told apart by colour-blind readers too; the band of chance stands out against all.
NAMED, NOTED, PERHAPS, CHANCE = "#d95f02", "#e6ab02", "0.45", "tab:blue"
TICKS = (0, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)


def draw_diagnosis(file: Path, diagnosis: Diagnosis) -> None:
    """Draw a diagnosis to `file`: a bar of gain for every candidate.

    With the band that chance alone stays within in 19 of 20 worlds in which the model is true, and
    the p-value that allows for the number of candidates.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    from matplotlib.patches import Patch  # noqa: PLC0415 (slow)

    rows = list(reversed(diagnosis.candidates[:MOST_CANDIDATES]))
    named = set(diagnosis.missing)
    with picture(file) as axes:
        for k, row in enumerate(rows):
            gain, chance = row.screened_gain, row.chance_gain
            axes.barh(k, chance, height=0.86, color=CHANCE, alpha=0.22)
            axes.barh(k, gain, height=0.42, color=_color(row, named))
            axes.annotate(
                f"p = {row.p_value:.{2 if row.p_value >= 0.095 else 3}f}",
                (max(gain, chance), k),
                (4, 0),
                textcoords="offset points",
                va="center",
                fontsize=8,
                color="black" if row.p_value <= LEVEL else "0.45",
            )
        axes.set_yticks(np.arange(len(rows)), [r.effect for r in rows], fontsize=9)
        axes.set_xscale("symlog", linthresh=2.0)
        most = max((max(r.screened_gain, r.chance_gain) for r in rows), default=1.0)
        axes.set_xlim(0.0, max(2.0, most) * 1.6)
        ticks = [tick for tick in TICKS if tick <= most * 1.6]
        axes.set_xticks(ticks, [str(tick) for tick in ticks], minor=False)
        axes.set_xticks([], minor=True)
        axes.set_xlabel("gain in log likelihood (nats); law, scatter and paths fitted again")
        axes.set_title(_title(diagnosis))
        axes.spines[["top", "right"]].set_visible(False)
        colors = {_color(row, named) for row in rows}
        patches = [
            Patch(color=color, label=label)
            for color, label in (
                (NAMED, "named"),
                (NOTED, f"p ≤ {LEVEL:g} among so many candidates"),
                (PERHAPS, "could be chance"),
            )
            if color in colors
        ]
        band = Patch(color=CHANCE, alpha=0.22, label="chance alone, 19 times in 20")
        axes.legend(handles=[*patches, band], loc="lower right", fontsize=8)


def _color(row: Candidate, named: set[str]) -> str:
    if row.effect in named:
        return NAMED
    return NOTED if row.p_value <= LEVEL else PERHAPS


def _title(diagnosis: Diagnosis) -> str:
    model, missing = diagnosis.model, ", ".join(diagnosis.missing)
    if diagnosis.cannot_tell:
        return f"{model}: these data cannot tell whether it lacks an effect"
    return {
        "adequate": f"{model} is adequate",
        "missing-effect": f"{model} lacks {missing}",
        "ambiguous": f"{model} lacks one of {missing}",
    }.get(diagnosis.verdict, f"{model} fails along {missing}")


COLORS = {
    "record": "#BBBBBB",
    "volume": "#56B4E9",
    "release": "#0072B2",
    "scatter": "#E69F00",
    "parameters": "#CC79A7",
    UNEXPLAINED: "#D55E00",
}
EXPLAINED = ("#009E73", "#66C2A5", "#1B7837", "#A6D96A")
"""Colours of what added effects explain."""


def bars(
    names: Sequence[str], comparisons: Mapping[str, Comparison]
) -> dict[str, dict[str, float]]:
    """Metres by source of every compared model that has a budget, in the order of `names`."""
    return {
        name: {part.source: part.rms_m for part in comparisons[name].budget}
        for name in names
        if name in comparisons and comparisons[name].budget
    }


def parts_in_order(found: Mapping[str, Mapping[str, float]]) -> dict[str, str]:
    """The colour of every source: those of all models, each effect's, the unexplained last."""
    sources = dict.fromkeys(source for bar in found.values() for source in bar)
    effects = [source for source in sources if source not in COLORS]
    known = [source for source in COLORS if source in sources and source != UNEXPLAINED]
    colors = {source: COLORS[source] for source in known}
    colors |= {source: EXPLAINED[k % len(EXPLAINED)] for k, source in enumerate(effects)}
    return colors | ({UNEXPLAINED: COLORS[UNEXPLAINED]} if UNEXPLAINED in sources else {})


WIDTH = 0.6
LEAST_SHARE = 0.06
"""Of the longest bar of the budgets: shorter parts have no figure in them."""
# Told apart by colour-blind readers too.
FELL, ROSE, EVEN = "#1b9e77", "#d95f02", "0.82"


def draw_ladder(
    file: Path, rows: Sequence[Rung], comparisons: Mapping[str, Comparison] | None = None
) -> None:
    """Draw the rows of `ladder` to `file`, as a waterfall; with `comparisons`, their budgets below.

    The error of each model, and what it gained or lost against its parent. Models that were not
    compared are left out.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    shown = [(row, row.held_out_crps_m) for row in rows if row.held_out_crps_m is not None]
    budgets = bars([row.model for row, _ in shown], comparisons or {})
    if not budgets:
        with picture(file) as axes:
            _waterfall(axes, shown)
        return
    with figure(file, (8.0, 6.0 + 0.45 * len(budgets))) as whole:
        above, below = whole.subplots(2, height_ratios=[5.0, 1.2 + 0.4 * len(budgets)])
        _waterfall(above, shown)
        _draw_budgets(below, budgets, _coordinate(shown))


def _draw_budgets(axes: Axes, budgets: Mapping[str, Mapping[str, float]], coordinate: str) -> None:
    """One stacked bar a model: squares of the parts, with their metres (or H/L) in them."""
    names = list(budgets)
    start = np.zeros(len(names))
    longest = max(sum(v * v for v in bar.values()) for bar in budgets.values())
    for source, color in parts_in_order(budgets).items():
        metres = np.array([bar.get(source, 0.0) for bar in budgets.values()])
        axes.barh(
            names,
            metres**2,
            left=start,
            height=WIDTH,
            color=color,
            label=part_words(source),
        )
        for k, value in enumerate(metres):
            if value * value >= LEAST_SHARE * longest:
                middle = start[k] + 0.5 * value * value
                text = amount(value, coordinate, 0)
                axes.text(middle, k, text, ha="center", va="center", fontsize=8)
        start += metres**2
    axes.invert_yaxis()
    unit = "H/L" if coordinate == RATIO else "metres"
    axes.set_xlabel(f"square of the error on its own records; figures in {unit}")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False, fontsize=8)
    axes.spines[["top", "right"]].set_visible(False)


def _coordinate(shown: Sequence[tuple[Rung, float]]) -> str:
    """The coordinate of the records."""
    return (shown[0][0].coordinate if shown else None) or "mixed"


def _waterfall(axes: Axes, shown: Sequence[tuple[Rung, float]]) -> None:
    coordinate = _coordinate(shown)
    place = {row.model: k for k, (row, _) in enumerate(shown)}
    for k, (row, value) in enumerate(shown):
        axes.bar(k, value, color=EVEN, width=WIDTH)
        low = value
        at = place.get(row.parent or "")
        if at is not None:
            # From the parent's error, carried over, to the child's.
            before = shown[at][1]
            change, low = value - before, min(value, before)
            color = FELL if change < 0.0 else ROSE
            axes.bar(k, -change, bottom=value, color=color, width=WIDTH)
            axes.plot([at - WIDTH / 2, k + WIDTH / 2], [before, before], color="0.4", lw=0.8)
            sign = "−" if change < 0.0 else "+"
            text = f"{sign}{amount(abs(change), coordinate, 0)} ({sign}{abs(change) / before:.0%})"
            axes.annotate(
                text,
                (k, max(value, before)),
                (0, 3),
                textcoords="offset points",
                ha="center",
                color=color,
            )
        axes.annotate(
            amount(value, coordinate, 0),
            (k, low),
            (0, -4),
            textcoords="offset points",
            ha="center",
            va="top",
            weight="bold",
        )
    floors = [row.noise_floor_crps_m for row, _ in shown if row.noise_floor_crps_m]
    if floors:
        axes.axhspan(0.0, min(floors), color="tab:blue", alpha=0.25, lw=0)
        axes.axhline(
            min(floors),
            color="tab:blue",
            linestyle="--",
            label=f"errors of the data alone: {amount(min(floors), coordinate, 0)}",
        )
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False)
    axes.margins(y=0.1)
    axes.set_ylim(bottom=0.0)
    axes.set_xticks(np.arange(len(shown)), [_label(row) for row, _ in shown])
    of = f"{unit_of(coordinate)} of {coordinate_words(coordinate)}"
    axes.set_ylabel(f"error: CRPS where held out ({of})")
    axes.spines[["top", "right"]].set_visible(False)


def _label(row: Rung) -> str:
    added = "\n".join(f"+ {key}" for key in row.added)
    return f"{row.model}\n{added}" if added else row.model
