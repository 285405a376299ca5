"""Tables of the paths and of the results on them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from avahazard.report.html.content import Document, PathView, ReportContent
from avahazard.report.html.table import HtmlTable
from avahazard.report.html.words import BEYOND, case, interval, metres, share, volume

APART = {"natural": "nature", "parameters": "parameters"}
"""What is told apart in `hazard`, in words."""


def lines_table(content: ReportContent) -> HtmlTable:
    """What line for which path: the answer of the report, for every return period."""
    columns = (
        "path", "for", ">runout x (5 to 95 %)", ">elevation there", ">records past it",
        ">farthest record", "mind",
    )  # fmt: skip
    names = {view.path.path_id: view.name for view in content.paths}
    rows = [_line(row, names) for row in content.rows if row["return_period_years"] is not None]
    return HtmlTable("lines", "Design runout: exceeded once in T years", columns, rows, cards=True)


def of_volume_table(content: ReportContent) -> HtmlTable:
    """Where avalanches of one volume stop: that of a return period, or a given one."""
    columns = ("path", "for", ">volume", ">runout x (5 to 95 %)", ">elevation there", ">leave")
    names = {view.path.path_id: view.name for view in content.paths}
    rows = [_of_volume(row, names) for row in content.rows]
    return HtmlTable("of-volume", "Runout of avalanches of one volume", columns, rows, cards=True)


def _line(row: Document, names: Mapping[str, str]) -> list[str]:
    cells = [names.get(row["path_id"], row["path_id"]), case(row)]
    found = row.get("design")
    if found is None:
        why = "not released" if row["p_not_released"] > 0.5 else "rate unknown"
        return [*cells, why, "–", "–", "–", _mind(row)]
    x, z = found["runout_x_m"], found["runout_elevation_m"]
    past, farthest = found["records_beyond"], found["farthest_record"]
    return [
        *cells,
        _with(x["q50"], interval(x)),
        _with(z["q50"], interval(_mirrored(z))),
        "–" if past is None or not found["n_records"] else f"{past} of {found['n_records']}",
        "–" if farthest is None else _record(farthest),
        _mind(row),
    ]


def _record(farthest: Document) -> str:
    date = farthest["date"]
    return metres(farthest["runout_x_m"]) + (f" ({date})" if date else "")


def _of_volume(row: Document, names: Mapping[str, str]) -> list[str]:
    x, z = row["runout_x_m"], row["runout_elevation_m"]
    cells = [names.get(row["path_id"], row["path_id"]), case(row), volume(row["volume_m3"])]
    if row["p_not_released"] > 0.5:
        return [*cells, "not released", "–", "–"]
    return [
        *cells,
        _with(x["q50"], interval(x)),
        _with(z["q50"], interval(_mirrored(z))),
        share(row["p_left_profile"]),
    ]


def _mirrored(z: Document) -> Document:
    """Quantiles of elevation in the order of x: the far end is the low one."""
    return {"q05": z["q95"], "q95": z["q05"]}


def _with(middle: float | None, ends: str) -> str:
    """A value with its interval."""
    return ends if ends == BEYOND else f"{metres(middle)} ({ends})"


def _mind(row: Document) -> str:
    remarks = []
    if row.get("extrapolated"):
        remarks.append("extrapolated")
    if row.get("pooled"):
        remarks.append("volumes pooled")
    found = row.get("design")
    if found and found["p_beyond"] > 0.0:
        remarks.append(f"{share(found['p_beyond'])} beyond the profile")
    return "; ".join(remarks)


def bounds_table(content: ReportContent) -> HtmlTable:
    """Every number of the bounds, and where the volume comes from."""
    names = {view.path.path_id: view.name for view in content.paths}
    apart = [key for key in ("natural", "parameters") if any(r.get(key) for r in content.rows)]
    columns = [
        "path", "for", ">design x, m", ">5 to 95 %", ">design elevation, m", ">5 to 95 % of x",
        ">beyond", ">volume V, m³", ">5 to 95 %", "years", ">a year", ">x of V, m", ">5 to 95 %",
        ">elevation of V, m", ">5 to 95 % of x", ">leave",
    ]  # fmt: skip
    columns += [f">x of V by {APART[key]} alone" for key in apart]
    rows: list[list[str]] = []
    for row in content.rows:
        x, z = row["runout_x_m"], row["runout_elevation_m"]
        volumes = row.get("volume_interval_m3")
        rows.append(
            [
                str(names.get(row["path_id"], row["path_id"])),
                case(row),
                *_design_cells(row.get("design")),
                _bare(volume(row["volume_m3"])),
                "–" if volumes is None else _between(volume(volumes[k]) for k in ("q05", "q95")),
                f"{row['first_year']}–{row['last_year']}" if "first_year" in row else "–",
                f"{row['events_per_year']:.2f}" if "events_per_year" in row else "–",
                _bare(metres(x["q50"])),
                _bare(interval(x)),
                _bare(metres(z["q50"])),
                _bare(interval(_mirrored(z))),
                share(row["p_left_profile"]),
                *(_bare(interval(row[k]["runout_x_m"])) if row.get(k) else "–" for k in apart),
            ]
        )
    return HtmlTable("bounds", "All bounds", columns, rows)


def _design_cells(found: Document | None) -> list[str]:
    if found is None:
        return ["–"] * 5
    x, z = found["runout_x_m"], found["runout_elevation_m"]
    return [
        _bare(metres(x["q50"])),
        _bare(interval(x)),
        _bare(metres(z["q50"])),
        _bare(interval(_mirrored(z))),
        share(found["p_beyond"]),
    ]


def _between(ends: Iterable[str]) -> str:
    return " to ".join(_bare(end) for end in ends)


def _bare(text: str) -> str:
    """Without the unit, which stands in the head of the column."""
    return text.removesuffix(" m³").removesuffix(" m")


def paths_table(paths: Sequence[PathView]) -> HtmlTable:
    """What is known of the paths."""
    rows = []
    for view in paths:
        profile, volumes = view.profile, [e.volume_m3 for e in view.events if e.volume_m3]
        years = [e.year for e in view.events if e.year is not None]
        first, last = view.path.observed_from, view.path.observed_to
        rows.append(
            [
                view.name,
                str(view.path.section or "–"),
                "–" if profile is None else metres(float(profile.y_m[0])),
                "–" if profile is None else metres(float(profile.y_m[0] - profile.y_m.min())),
                "–" if profile is None else metres(float(profile.x_m[-1] - profile.x_m[0])),
                str(len(view.events)),
                str(sum(e.left_profile for e in view.events)),
                f"{min(years)}–{max(years)}" if years else "–",
                f"{first or '?'}–{last or '?'}" if first or last else "–",
                f"{_bare(volume(min(volumes)))} to {volume(max(volumes))}" if volumes else "–",
            ]
        )
    columns = (
        "path", "section", ">top", ">drop", ">length", ">events", ">left", "events of", "observed",
        ">volumes",
    )  # fmt: skip
    return HtmlTable("paths", "The paths", columns, rows)


def alpha_beta_table(views: Sequence[PathView]) -> HtmlTable | None:
    """The α-β runouts beside the model; None where there is none."""
    rows = [
        [
            view.name,
            row["coefficients"],
            f"{row['beta_deg']:.1f}°" if row["beta_deg"] is not None else "no β-point",
            "–" if row["alpha_deg"] is None else f"{row['alpha_deg']:.1f}°",
            *(
                "–" if row["beta_deg"] is None else metres(row[key])
                for key in ("runout_x_m", "runout_x_low_m", "runout_x_high_m")
            ),
        ]
        for view in views
        for row in view.alpha_beta
    ]
    if not rows:
        return None
    columns = ("path", "coefficients", ">β", ">α", ">runout x", ">one sd shorter", ">one sd longer")
    return HtmlTable("alpha-beta", "α-β runouts: from the shape of the ground alone", columns, rows)


def zones_table(views: Sequence[PathView]) -> HtmlTable | None:
    """The zones of each path; None where none were drawn."""
    rows = [
        [
            view.name,
            str(view.zones["limits"]),
            str(zone["zone"]),
            metres(zone["from_x_m"]),
            BEYOND if zone["beyond"] else metres(zone["to_x_m"]),
            interval({"q05": zone["to_x_q05_m"], "q95": zone["to_x_q95_m"]}),
        ]
        for view in views
        if view.zones
        for zone in view.zones["zones"]
    ]  # fmt: skip
    if not rows:
        return None
    return HtmlTable(
        "zones", "Zones", ("path", "limits", "zone", ">from x", ">to x", ">its 5 to 95 %"), rows
    )
