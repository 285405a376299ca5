"""The catalogue of effects, from the effects' own files."""

from __future__ import annotations

from math import isfinite

from avahazard.effects.catalogue import catalogue
from avahazard.effects.change import change
from avahazard.effects.covariate import covariate, scatter_by
from avahazard.effects.effect import Definition, Parameter
from avahazard.effects.groups import one_path
from avahazard.effects.pairs import interaction

HEAD = """# Effects

What the sliding block may lack. At its neutral value every effect leaves the result bit for bit as
it is without it. `avahazard effects` says which of them your own data can tell;
`avahazard effect KEY` shows one; `avahazard add MODEL KEY --as NEW` adds it. One that is not here
you can [write yourself](tutorial/own_effect.md).

The keys that begin with `force:`, `covariate:`, `interaction:`, `change:`, `scatter:` and `path:`
are kinds rather than effects with a name: `diagnose` tries them with every state of the block,
column, pair of columns and path that your data have. `COLUMN` and `OTHER` stand for a column of the
records or one that is counted from them: `order_in_winter` (avalanches of the path in that winter,
from 1), `days_since_last`, `avalanches_nearby` (others at the location within 3 days) and
`volume_in_winter` (log of what came down before); and of a path `catchment_ha`, `northness` and
`eastness` (cosine and sine of its orientation). `OTHER` may be `volume_m3` or `path_id`; `PATH` is
a path, of a change also `several` or `all`.
"""

MADE = (
    covariate("COLUMN"),
    interaction("COLUMN*OTHER"),
    change("PATH"),
    scatter_by("COLUMN"),
    one_path("PATH"),
)


def effects_page() -> str:
    """Return the page: every key with its meaning, its needs and its parameters."""
    return "\n".join([HEAD, *map(_section, [*catalogue().values(), *MADE])])


def _section(entry: Definition) -> str:
    lines = [f"\n## {entry.key}\n", entry.meaning, f"\nIt needs: {entry.needs}.\n"]
    try:
        effect = entry.build({})
    except KeyError:
        lines.append("Its parameters follow from the data: levels, ranges or knots.\n")
        return "\n".join(lines)
    if entry.changes is not None:
        lines.append("It is a change of the model itself and has no parameter of its own here.\n")
    elif effect.parameters:
        lines += ["| parameter | unit | neutral | prior | range |", "|---|---|---|---|---|"]
        lines += [_row(p) for p in effect.parameters]
    return "\n".join(lines)


def _row(p: Parameter) -> str:
    low = f"{p.low:g}" if isfinite(p.low) else ""
    high = f"{p.high:g}" if isfinite(p.high) else ""
    bounds = f"{low} to {high}" if low or high else "any"
    return (
        f"| {p.name} | {p.unit or '–'} | {p.neutral:g} | {p.prior_mean:g} ± {p.prior_sd:g} "
        f"| {bounds} |"
    )
