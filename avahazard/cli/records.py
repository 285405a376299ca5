"""Commands on records and paths: import, paths, path, runout, friction, fit, alpha-beta."""

import shlex
from collections import Counter
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from statistics import median
from typing import Annotated

import typer

from avahazard.cli.options import OnePath, answers, argument, flag, picture
from avahazard.cli.output import SafeConsole, Shown, Whole, ask, emit, table
from avahazard.report.model_tables import fits_table
from avahazard.report.tables import alpha_beta_table, cell, paths_table, thinned
from avahazard.report.words import digits
from avahazard.results.base import Rows
from avahazard.results.files import GuessedColumns, Import
from avahazard.results.friction import ApparentEvent, Fits, Frictions, PerturbationCheck
from avahazard.results.terrain import PathCheck, PathSummary, Runout, TerrainRunout
from avahazard.workflow import requests


def import_(
    sources: Annotated[
        list[str],
        argument(
            "Tables (.csv, .xlsx, .ods) or folders of them; lines or points (.gpkg, .geojson, "
            ".shp, .kml, .gpx).",
            "SOURCE…",
        ),
    ],
    *,
    request: requests.ImportRequest,
    guess_columns: Annotated[
        bool, flag("--guess-columns", "Write a first columns.toml beside tables; import nothing.")
    ] = False,
) -> None:
    """Import tables, or folders of them, or paths drawn as lines on a terrain model.

    Tables are workbooks (.xlsx, .xls, .ods) or texts with commas, semicolons or tabs; how each was
    read is said. What may be read in two ways is refused until --decimal or --dates decides.
    Each line is a path, drawn from its top; its attributes are the columns of paths.csv. A folder
    with Inputs/ is read as AvaFrame does.
    All files are imported or none: every row that cannot be taken is listed.

    \b
    Examples:
      avahazard import my-records
      avahazard import events.csv velocities.csv --dry-run
      avahazard import records.xlsx --dry-run
      avahazard import events.csv --dates dmy --update
      avahazard import cadastre.xlsx profiles.csv --guess-columns
      avahazard import slides.csv --unusual --unknown=-9999
      avahazard import lines.gpkg events.csv --dem terrain.tif --land-cover forest.gpkg
    """
    if guess_columns:
        emit(ask("database.guess_columns", sources=sources), _guessed)
        return
    found = ask("database.import_files", sources=sources, request=request)
    for line in found.read:
        SafeConsole(stderr=True).print(f"Read {line}.", soft_wrap=True)
    emit(found, _imported)


def _imported(found: Import) -> Iterator[Shown]:
    if found.dry_run:
        headings = ("column", "meaning", "unit", "first values")
        for (file, form), read in groupby(found.understood, lambda c: (c.file, c.form)):
            cells = [(c.column, c.meaning, c.unit, ", ".join(c.values)) for c in read]
            yield table(f"{file}: {form}", headings, cells)
    title = "Would be imported (nothing was stored)" if found.dry_run else "Imported"
    rows = [(kind, *counts.values()) for kind, counts in found.records.to_dict().items()]
    yield table(title, ("", ">new", ">unchanged", ">updated"), rows)


def _guessed(found: GuessedColumns) -> Iterator[Shown]:
    columns = ("column", "seems to be", "unit", ">confidence", "because")
    for file, guesses in groupby(found.guesses, lambda guess: guess.table):
        rows = [(g.source, g.column, g.unit, f"{g.confidence:.0%}", g.reason) for g in guesses]
        yield table(f"Columns of {file}", columns, rows)
    for text in found.open:
        yield Whole(f"Open: {text}")
    yield Whole(
        f"Written to {found.written}: read it, correct it, then avahazard import "
        f"{shlex.join(found.files)} --dry-run"
    )


@answers("listing.list_paths")
def paths(found: Rows[PathSummary]) -> Iterator[Shown]:
    """List the paths.

    \b
    Examples:
      avahazard paths
      avahazard --json paths > paths.json
    """
    none = "There are no paths: import paths.csv and profiles.csv. Events with H and L (or H/L) "
    none += "alone need none, but have no design runout."
    yield paths_table(found) if found else none


@answers("path.view_path")
def path(
    found: PathCheck, path_id: OnePath, plot: Annotated[Path | None, picture()] = None
) -> Iterator[Shown]:
    """Show how the profile of a path was smoothed, and check it.

    \b
    Examples:
      avahazard path P01
      avahazard path P01 --plot profile.png
    """
    fit = found.fit
    how = (
        f"Legendre polynomial of degree {fit.degree}"
        if fit.method == "legendre"
        else f"smoothing spline (penalty {cell(fit.smoothing)})"
    )
    rows = (
        ("points", found.n_points),
        ("events", found.n_events),
        ("length m", found.length_m),
        ("drop m", found.drop_m),
        ("smoothed by", how),
        (f"error of a point, {fit.sigma_from} m", fit.elevation_sigma_m),
        ("misfit (rms) m", fit.rms_m),
        ("misfit of the polynomial (rms) m", fit.polynomial_rms_m),
        ("largest deviation m", fit.max_deviation_m),
        ("error of the ground m", fit.ground_sd_m),
        ("length of the block m", fit.block_m),
        ("descends monotonically", found.monotone),
        ("smallest radius of curvature m", found.min_curvature_radius_m),
        ("length of the flow m", found.flow_length_m),
    )
    yield table("", (found.path_id, ">"), rows)


SHOWN = 10
"""Places in the table of speeds for people."""


def _lift_off(found: Runout) -> Iterator[str]:
    if found.lift_off_x_m is not None:
        yield f"the block loses the ground at x = {found.lift_off_x_m:.0f} m."
    yield from found.notes or ()


@answers("path.run_block", notes=_lift_off)
def runout(found: Runout, path_id: OnePath, *, request: requests.RunoutRequest) -> Iterator[Shown]:
    """Run the block once: its stop and its speeds; or F(μ), where it stops under any friction.

    \b
    Examples:
      avahazard runout P01 --mu 0.4
      avahazard runout P01 --model first --volume 50000
      avahazard runout P01 --mu 0.4 --table --plot curve.png
    """
    yield Whole(_how_it_ended(found))
    if found.status != "not_released":
        rows = [(f"{p.x_m:.0f}", f"{p.speed_m_s:.1f}") for p in thinned(found.speeds, SHOWN)]
        yield table("", (">x m", ">speed m/s"), rows)
        yield f"Largest speed {found.speed_max_m_s:.1f} m/s."
    yield from show_table(found)


def _how_it_ended(found: Runout) -> str:
    by = f" ({found.mu_from}, {found.model})" if found.model else ""
    start = (
        f"{found.path_id}, μ = {found.mu:.4g}{by}: released at {found.release_elevation_m:.0f} m, "
    )
    if found.status == "left_profile":
        return f"{start}runs beyond the profile."
    if found.status == "not_released":
        return f"{start}does not move: the slope is less than μ."
    return f"{start}stops at {found.runout_elevation_m:.1f} m (x = {found.runout_x_m:.1f} m)."


MOST_FRICTIONS = 29
MOST_JUMPS = 5
CURVE_COLUMNS = (">μ", ">stop x m", ">elevation m", ">dx/dμ m", ">dy/dμ m", "")
CURVE_WORDS = {"stopped": "", "left_profile": "beyond the profile", "not_released": "does not move"}


def show_table(found: Runout) -> Iterator[Shown]:
    """Show F(μ) at some frictions, and its largest jumps; nothing without a table."""
    if found.table is None:
        return
    stopped = [k for k, row in enumerate(found.table) if row.status == "stopped"]
    first, last = (stopped[0], stopped[-1]) if stopped else (0, len(found.table))
    shown = found.table[max(first - 1, 0) : last + 2]
    rows = [
        (
            f"{row.mu:.4g}",
            digits(row.runout_x_m, ".1f"),
            digits(row.runout_elevation_m, ".1f"),
            digits(row.dx_dmu_m, ".0f"),
            digits(row.dy_dmu_m, ".0f"),
            CURVE_WORDS[row.status],
        )
        for row in thinned(shown, MOST_FRICTIONS)
    ]
    by = f", with the effects of {found.model}" if found.model else ""
    yield table(f"F(μ) on {found.path_id}{by}", CURVE_COLUMNS, rows)
    yield "dx/dμ, dy/dμ: by how much stop and elevation move per unit of friction (F′)."
    jumps = sorted(found.jumps or (), key=lambda jump: -abs(jump.from_x_m - jump.to_x_m))
    for jump in jumps[:MOST_JUMPS]:
        yield (
            f"F jumps between μ = {jump.mu_low:.4f} and {jump.mu_high:.4f}: no friction stops the "
            f"block\nbetween x = {jump.to_x_m:.0f} m and {jump.from_x_m:.0f} m."
        )
    if len(jumps) > MOST_JUMPS:
        yield f"{len(jumps) - MOST_JUMPS} smaller jumps: see --json."


@answers("friction.show_frictions")
def friction(
    found: Frictions,
    path_id: Annotated[str | None, argument("Only events of this path.", "[PATH]")] = None,
    *,
    request: requests.FrictionRequest,
) -> Iterator[Shown]:
    """Show the apparent friction of the events and its density.

    \b
    Examples:
      avahazard friction
      avahazard friction P01 --kappa auto --plot density.png
      avahazard friction --model first --plot law.png
    """
    return _by_path(found) if path_id is None else _by_event(found)


def _by_path(found: Frictions) -> Iterator[Shown]:
    kappas = {density.path_id: density.kappa for density in found.density}
    groups: dict[str | None, list[ApparentEvent]] = {}
    for event in found.events:
        groups.setdefault(event.path_id, []).append(event)
    if len(groups) > 1:
        groups["all"] = list(found.events)
    rows = []
    for name, events in groups.items():
        known = [event.mu for event in events if event.mu is not None]
        odd = Counter(event.status for event in events if event.status != "unique")
        rows.append(
            (
                name,
                len(events),
                min(known, default=None),
                median(known) if known else None,
                max(known, default=None),
                kappas.get("all" if name is None else name),
                ", ".join(f"{n} {status}" for status, n in odd.items()) or None,
            )
        )
    columns = ("path", ">events", ">lowest μ", ">median", ">highest", ">κ", "not unique")
    yield table(_friction_title(found), columns, rows)
    yield from _perturbation(found.perturbation)


def _by_event(found: Frictions) -> Iterator[Shown]:
    rows = [(event.event_id, event.mu, event.mu_sd, _event_status(event)) for event in found.events]
    yield table(_friction_title(found), ("event", ">μ", ">sd", "status"), rows)
    for density in found.density[:1]:
        peak = density.mu[density.pdf.index(max(density.pdf))]
        yield f"Density: κ = {cell(density.kappa)}, highest at μ = {peak:.3f}."
    yield from _perturbation(found.perturbation)


def _friction_title(found: Frictions) -> str:
    return f"Apparent friction{f', with the effects of {found.model}' if found.model else ''}"


def _event_status(event: ApparentEvent) -> str:
    """The status, with what is known of μ where that is an interval."""
    low, high = event.mu_low, event.mu_high
    match event.status:
        case "jump" | "several":
            return f"{event.status}: {low:.3f} to {high:.3f}"
        case "below" if high is not None:
            return f"below {high:.3f}"
        case "above" if low is not None:
            return f"above {low:.3f}"
    return str(event.status)


def _perturbation(check: PerturbationCheck) -> Iterator[Shown]:
    if check.mu_sd_median is None or check.mu_sd_max is None:
        return
    yield (
        f"Records perturbed within their errors {check.n_replicates} times: μ varies by "
        f"{check.mu_sd_median:.3f} (sd, median event), {check.mu_sd_max:.3f} at most."
    )
    if check.law:
        columns = (f"{check.law} law", ">value", ">± se", ">mean, perturbed", ">± sd")
        rows = [(name, p.value, p.se, p.mean, p.sd) for name, p in check.parameters.items()]
        yield table("", columns, rows)


@answers("friction.fit_laws")
def fit(
    found: Fits,
    path_id: Annotated[
        str | None,
        typer.Option(
            "--path", metavar="PATH", help="Only events of this path.", show_default=False
        ),
    ] = None,
    plot: Annotated[Path | None, picture("Draw the laws on the points")] = None,
) -> Iterator[Shown]:
    """Fit laws of friction against volume by least squares.

    \b
    Examples:
      avahazard fit
      avahazard fit --path P01 --plot laws.png
    """
    yield fits_table(found)


@answers("path.alpha_beta_paths")
def alpha_beta(
    found: Rows[TerrainRunout],
    path_id: Annotated[
        str | None, argument("The path_id of a path; all where none is given.", "[PATH]")
    ] = None,
) -> Iterator[Shown]:
    """Give the alpha-beta runout of the paths: a baseline from the terrain alone.

    \b
    Examples:
      avahazard alpha-beta
      avahazard alpha-beta P01
    """
    yield alpha_beta_table(found)
