"""Tables of the paths and of the results on them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from avahazard.report.html.content import Document, PathView, ReportContent
from avahazard.report.html.model_tables import HtmlTable
from avahazard.report.html.words import (
    between,
    beyond,
    case,
    interval,
    metres,
    mirrored,
    share,
    volume,
)
from avahazard.report.language import ENGLISH, Language


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


def lines_table(content: ReportContent) -> HtmlTable:
    """What line for which path: the answer of the report, for every return period."""
    language, say = content.language, content.language.say
    columns = (
        say("path"), say("for"), ">" + say("runout x (5 to 95 %)"), ">" + say("elevation there"),
        ">" + say("records past it"), ">" + say("farthest record"), say("mind"),
    )  # fmt: skip
    names = {view.path.path_id: view.name for view in content.paths}
    rows = [
        _line(row, names, language)
        for row in content.rows
        if row["return_period_years"] is not None
    ]
    title = say("Design runout: exceeded once in T years")
    return HtmlTable("lines", title, columns, rows, cards=True)


def of_volume_table(content: ReportContent) -> HtmlTable:
    """Where avalanches of one volume stop: that of a return period, or a given one."""
    language, say = content.language, content.language.say
    columns = (
        say("path"), say("for"), ">" + say("volume"), ">" + say("runout x (5 to 95 %)"),
        ">" + say("elevation there"), ">" + say("leave"),
    )  # fmt: skip
    names = {view.path.path_id: view.name for view in content.paths}
    rows = [_of_volume(row, names, language) for row in content.rows]
    title = say("Runout of avalanches of one volume")
    return HtmlTable("of-volume", title, columns, rows, cards=True)


def _line(row: Document, names: Mapping[str, str], language: Language) -> list[str]:
    say = language.say
    cells = [names.get(row["path_id"], row["path_id"]), case(row, language)]
    found = row.get("design")
    if found is None:
        why = say("not released") if row["p_not_released"] > 0.5 else say("rate unknown")
        return [*cells, why, "–", "–", "–", _mind(row, language)]
    x, z = found["runout_x_m"], found["runout_elevation_m"]
    past, farthest, total = found["records_beyond"], found["farthest_record"], found["n_records"]
    return [
        *cells,
        _with(x["q50"], interval(x, language), language),
        _with(z["q50"], interval(mirrored(z), language), language),
        "–" if past is None or not total else say("{n} of {total}", n=past, total=total),
        "–" if farthest is None else _record(farthest, language),
        _mind(row, language),
    ]


def _record(farthest: Document, language: Language) -> str:
    date = farthest["date"]
    place = metres(farthest["runout_x_m"], language)
    return f"{place} ({language.date(date)})" if date else place


def _of_volume(row: Document, names: Mapping[str, str], language: Language) -> list[str]:
    x, z = row["runout_x_m"], row["runout_elevation_m"]
    cells = [
        names.get(row["path_id"], row["path_id"]),
        case(row, language),
        volume(row["volume_m3"], language),
    ]
    if row["p_not_released"] > 0.5:
        return [*cells, language.say("not released"), "–", "–"]
    return [
        *cells,
        _with(x["q50"], interval(x, language), language),
        _with(z["q50"], interval(mirrored(z), language), language),
        share(row["p_left_profile"], language),
    ]


def _with(middle: float | None, ends: str, language: Language) -> str:
    """A value with its interval."""
    return ends if ends == beyond(language) else f"{metres(middle, language)} ({ends})"


def _mind(row: Document, language: Language) -> str:
    say = language.say
    remarks = []
    if row.get("extrapolated"):
        remarks.append(say("extrapolated"))
    if row.get("pooled"):
        remarks.append(say("volumes pooled"))
    found = row.get("design")
    if found and found["p_beyond"] > 0.0:
        remarks.append(say("{share} beyond the profile", share=share(found["p_beyond"], language)))
    return "; ".join(remarks)


def paths_table(paths: Sequence[PathView], language: Language = ENGLISH) -> HtmlTable:
    """What is known of the paths."""
    say = language.say
    sections = {"channelled": say("channelled"), "open": say("open")}
    rows = []
    for view in paths:
        volumes = [e.volume_m3 for e in view.events if e.volume_m3]
        years = [e.year for e in view.events if e.year is not None]
        first, last = view.path.observed_from, view.path.observed_to
        section = str(view.path.section or "–")
        rows.append(
            [
                view.name,
                sections.get(section, section),
                *_sizes(view, language),
                str(len(view.events)),
                str(sum(e.left_profile for e in view.events)),
                f"{min(years)}–{max(years)}" if years else "–",
                f"{first or '?'}–{last or '?'}" if first or last else "–",
                between(
                    volume(min(volumes), language).removesuffix(" m³"),
                    volume(max(volumes), language),
                    language,
                )
                if volumes
                else "–",
            ]
        )
    columns = (
        say("path"), say("section"), ">" + say("top"), ">" + say("drop"), ">" + say("length"),
        ">" + say("events"), ">" + say("left"), say("events of"), say("observed"),
        ">" + say("volumes"),
    )  # fmt: skip
    return HtmlTable("paths", say("The paths"), columns, rows)


def _sizes(view: PathView, language: Language) -> list[str]:
    """Top, drop and length of a path."""
    profile = view.profile
    if profile is None:
        return ["–"] * 3
    top, low = float(profile.y_m[0]), float(profile.y_m.min())
    length = float(profile.x_m[-1] - profile.x_m[0])
    return [metres(value, language) for value in (top, top - low, length)]


def alpha_beta_table(views: Sequence[PathView], language: Language = ENGLISH) -> HtmlTable | None:
    """The α-β runouts beside the model; None where there is none."""
    say = language.say
    rows = [
        [
            view.name,
            say(row["coefficients"]),
            say("no β-point") if row["beta_deg"] is None else _degrees(row["beta_deg"], language),
            "–" if row["alpha_deg"] is None else _degrees(row["alpha_deg"], language),
            *(
                "–" if row["beta_deg"] is None else metres(row[key], language)
                for key in ("runout_x_m", "runout_x_low_m", "runout_x_high_m")
            ),
        ]
        for view in views
        for row in view.alpha_beta
    ]
    if not rows:
        return None
    columns = (
        say("path"), say("coefficients"), ">β", ">α", ">" + say("runout x"),
        ">" + say("one sd shorter"), ">" + say("one sd longer"),
    )  # fmt: skip
    title = say("α-β runouts: from the shape of the ground alone")
    return HtmlTable("alpha-beta", title, columns, rows)


def _degrees(angle: float, language: Language) -> str:
    return language.number(f"{angle:.1f}") + "°"


def zones_table(views: Sequence[PathView], language: Language = ENGLISH) -> HtmlTable | None:
    """The zones of each path; None where none were drawn."""
    say = language.say
    rows = [
        [
            view.name,
            say(str(view.zones["limits"])),
            say(str(zone["zone"])),
            metres(zone["from_x_m"], language),
            beyond(language) if zone["beyond"] else metres(zone["to_x_m"], language),
            interval({"q05": zone["to_x_q05_m"], "q95": zone["to_x_q95_m"]}, language),
        ]
        for view in views
        if view.zones
        for zone in view.zones["zones"]
    ]
    if not rows:
        return None
    columns = (
        say("path"), say("limits"), say("zone"), ">" + say("from x"), ">" + say("to x"),
        ">" + say("its 5 to 95 %"),
    )  # fmt: skip
    return HtmlTable("zones", say("Zones"), columns, rows)
