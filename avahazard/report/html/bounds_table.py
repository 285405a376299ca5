"""The table of all bounds: every number of `hazard`."""

from __future__ import annotations

from collections.abc import Iterable

from avahazard.report.html.content import Document, ReportContent
from avahazard.report.html.table import HtmlTable
from avahazard.report.html.words import (
    between,
    case,
    interval,
    metres,
    mirrored,
    share,
    volume,
)
from avahazard.report.language import Language


def bounds_table(content: ReportContent) -> HtmlTable:
    """Every number of the bounds, and where the volume comes from."""
    language, say = content.language, content.language.say
    names = {view.path.path_id: view.name for view in content.paths}
    # What is told apart in `hazard`, in words.
    apart = {
        "natural": say("x of V by nature alone"),
        "parameters": say("x of V by parameters alone"),
    }
    shown = [key for key in apart if any(r.get(key) for r in content.rows)]
    spread, of_x = ">" + say("5 to 95 %"), ">" + say("5 to 95 % of x")
    columns = [
        say("path"), say("for"), ">" + say("design x, m"), spread,
        ">" + say("design elevation, m"), of_x, ">" + say("beyond"),
        ">" + say("volume V, m³"), spread, say("years"), ">" + say("a year"),
        ">" + say("x of V, m"), spread, ">" + say("elevation of V, m"), of_x, ">" + say("leave"),
        *(">" + apart[key] for key in shown),
    ]  # fmt: skip
    rows: list[list[str]] = []
    for row in content.rows:
        x, z = row["runout_x_m"], row["runout_elevation_m"]
        volumes = row.get("volume_interval_m3")
        rows.append(
            [
                str(names.get(row["path_id"], row["path_id"])),
                case(row, language),
                *_design_cells(row.get("design"), language),
                _bare(volume(row["volume_m3"], language)),
                "–"
                if volumes is None
                else _between((volume(volumes[k], language) for k in ("q05", "q95")), language),
                f"{row['first_year']}–{row['last_year']}" if "first_year" in row else "–",
                language.number(f"{row['events_per_year']:.2f}")
                if "events_per_year" in row
                else "–",
                _bare(metres(x["q50"], language)),
                _bare(interval(x, language)),
                _bare(metres(z["q50"], language)),
                _bare(interval(mirrored(z), language)),
                share(row["p_left_profile"], language),
                *(
                    _bare(interval(row[k]["runout_x_m"], language)) if row.get(k) else "–"
                    for k in shown
                ),
            ]
        )
    return HtmlTable("bounds", say("All bounds"), columns, rows)


def _design_cells(found: Document | None, language: Language) -> list[str]:
    if found is None:
        return ["–"] * 5
    x, z = found["runout_x_m"], found["runout_elevation_m"]
    return [
        _bare(metres(x["q50"], language)),
        _bare(interval(x, language)),
        _bare(metres(z["q50"], language)),
        _bare(interval(mirrored(z), language)),
        share(found["p_beyond"], language),
    ]


def _between(ends: Iterable[str], language: Language) -> str:
    low, high = (_bare(end) for end in ends)
    return between(low, high, language)


def _bare(text: str) -> str:
    """Without the unit, which stands in the head of the column."""
    return text.removesuffix(" m³").removesuffix(" m")
