"""Tables of the paths and of the results on them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from avahazard.report.html.content import Document, PathView, ReportContent
from avahazard.report.html.table import HtmlTable
from avahazard.report.html.words import BEYOND, case, interval, metres, share, volume

APART = {"natural": "nature", "parameters": "parameters"}
"""What is told apart in `hazard`, in words."""


def lines_table(content: ReportContent) -> HtmlTable:
    """What line for which path: the answer of the report."""
    columns = ["path", "for", ">runout x (5 to 95 %)", ">elevation there"]
    exceeded = any(row.get("exceeded") for row in content.rows)
    if exceeded:
        columns.append(">exceeded once: x (5 to 95 %)")
    names = {view.path.path_id: view.name for view in content.paths}
    rows = [_line(row, names, exceeded) for row in content.rows]
    return HtmlTable("lines", "Runout by path", [*columns, "mind"], rows, cards=True)


def _line(row: Document, names: Mapping[str, str], exceeded: bool) -> list[str]:
    x, z = row["runout_x_m"], row["runout_elevation_m"]
    cells = [names.get(row["path_id"], row["path_id"]), case(row)]
    if row["p_not_released"] > 0.5:
        cells += ["not released", "–"]
    else:
        lower = {"q05": z["q95"], "q95": z["q05"]}
        cells += [_with(x["q50"], interval(x)), _with(z["q50"], interval(lower))]
    if exceeded:
        found = row.get("exceeded")
        spread = found["runout_x_m"] if found else None
        cells.append("–" if spread is None else _with(spread["q50"], interval(spread)))
    return [*cells, _mind(row)]


def _with(middle: float | None, ends: str) -> str:
    """A value with its interval."""
    return ends if ends == BEYOND else f"{metres(middle)} ({ends})"


def _mind(row: Document) -> str:
    remarks = []
    if row.get("extrapolated"):
        remarks.append("extrapolated")
    if row.get("pooled"):
        remarks.append("volumes pooled")
    if row["p_left_profile"] > 0.0:
        remarks.append(f"{share(row['p_left_profile'])} leave the profile")
    return "; ".join(remarks)


def bounds_table(content: ReportContent) -> HtmlTable:
    """Every number of the bounds, and where the volume comes from."""
    names = {view.path.path_id: view.name for view in content.paths}
    apart = [key for key in ("natural", "parameters") if any(r.get(key) for r in content.rows)]
    columns = [
        "path", "for", ">volume, m³", ">5 to 95 %", "years", ">a year", ">x, m: mean", ">median",
        ">5 to 95 %", ">z, m: median", ">at those ends", ">left",
    ]  # fmt: skip
    columns += [f">x by {APART[key]} alone" for key in apart]
    rows: list[list[str]] = []
    for row in content.rows:
        x, z = row["runout_x_m"], row["runout_elevation_m"]
        volumes = row.get("volume_interval_m3")
        rows.append(
            [
                str(names.get(row["path_id"], row["path_id"])),
                case(row),
                _bare(volume(row["volume_m3"])),
                "–" if volumes is None else _between(volume(volumes[k]) for k in ("q05", "q95")),
                f"{row['first_year']}–{row['last_year']}" if "first_year" in row else "–",
                f"{row['events_per_year']:.2f}" if "events_per_year" in row else "–",
                "–" if x["mean"] is None else _bare(metres(x["mean"])),
                _bare(metres(x["q50"])),
                _bare(interval(x)),
                _bare(metres(z["q50"])),
                _bare(interval({"q05": z["q95"], "q95": z["q05"]})),
                share(row["p_left_profile"]),
                *(_bare(interval(row[k]["runout_x_m"])) if row.get(k) else "–" for k in apart),
            ]
        )
    return HtmlTable("bounds", "All bounds", columns, rows)


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
