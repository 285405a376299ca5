"""Commands on the database and on files: init, db, report, export, paper-figures, synth."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.options import StoredModel, output_file
from avahazard.cli.output import emit, settings, table, warn
from avahazard.notes import counted
from avahazard.progress import show_progress
from avahazard.workflow.requests import FiguresRequest, ReportRequest


def init(context: typer.Context) -> None:
    """Create the database.

    \b
    Examples:
      avahazard init
      avahazard --db valley.db init
    """
    from avahazard.workflow.database import init_database  # noqa: PLC0415

    found = init_database(settings(context).database)
    done = "was created" if found.created else "exists"
    emit(context, found, f"The database {found.database} {done}.")
    if found.state == "old":
        warn("it was made by an older version: run `avahazard db upgrade`.")
    elif found.state == "newer":
        warn("it was made by a newer version: update the program.")


db = typer.Typer(
    help="Upgrade, look at, check or copy the database.",
    rich_markup_mode=None,
    add_completion=False,
    no_args_is_help=True,
)


@db.command()
def upgrade(context: typer.Context) -> None:
    """Bring the tables of the database up to date.

    \b
    Example:
      avahazard db upgrade
    """
    from avahazard.workflow.database import upgrade_database  # noqa: PLC0415

    found = upgrade_database(settings(context).database)

    words = f"went from revision {found.from_} to {found.to}"
    if found.from_ == found.to:
        words = "is up to date"
    copied = "" if found.backup is None else f"Copied it to {found.backup} before.\n"
    emit(context, found, f"{copied}The database {found.database} {words}.")


@db.command()
def status(context: typer.Context) -> None:
    """Show the revision of the database and what it holds.

    \b
    Examples:
      avahazard db status
      avahazard --db valley.db db status
    """
    from avahazard.workflow.database import database_status  # noqa: PLC0415

    found = database_status(settings(context).database)

    def render(console: Console) -> None:
        console.print(f"Database: {found.database}", soft_wrap=True)
        console.print(
            f"Tables: {found.state} (revision {found.revision or 'none'}, "
            f"this program's is {found.head})"
        )
        if found.counts:
            console.print(table("", ("holds", ">number"), found.counts.items()))

    emit(context, found, render)


@db.command()
def check(
    context: typer.Context,
    full: Annotated[
        bool, typer.Option("--full", help="Calibrate some models again: the same draws?")
    ] = False,
) -> None:
    """Check that the database is whole, by its checksums; status 1 when it is not.

    \b
    Examples:
      avahazard db check
      avahazard db check --full
    """
    from avahazard.records.errors import AvahazardError  # noqa: PLC0415
    from avahazard.workflow.database import check as check_whole  # noqa: PLC0415

    with show_progress() as report:
        found = check_whole(settings(context).database, full=full, report=report)
    if not found.whole:
        faults = "\n".join(found.problems)
        raise AvahazardError(
            f"The database {found.database} is not whole.\n{faults}", "Go back to a backup."
        )

    lines = [f"The database {found.database} is whole."]
    for model in found.recomputed or ():
        words = "as stored, to the last bit"
        if not model.identical:
            words = f"could not be held against it: {model.why_not}"
        lines.append(f"{model.model} calibrated again: {words}")
    emit(context, found, "\n".join(lines))


@db.command()
def backup(
    context: typer.Context,
    file: Annotated[str, typer.Argument(help="The new file.", show_default=False)],
) -> None:
    """Copy the database to a new file, also while it is in use.

    \b
    Example:
      avahazard db backup copy.db
    """
    from avahazard.workflow.database import backup_database  # noqa: PLC0415

    found = backup_database(settings(context).database, file)
    emit(context, found, f"Copied {found.database} to {found.backup}.")


def report(
    context: typer.Context,
    name: StoredModel,
    output: Annotated[
        Path,
        output_file("Where to write it: .html. One that is there is replaced."),
    ],
    *,
    request: ReportRequest,
) -> None:
    """Write a report of a model as one HTML file that needs no network.

    \b
    Examples:
      avahazard report first -o first.html
      avahazard report first -o first.html --title "Val d'Arly" --author "A. Favre"
      avahazard report first -o first-de.html --language de
      avahazard --json report first -o first.html
    """
    from avahazard.workflow.report import write_report  # noqa: PLC0415

    with show_progress() as progress:
        found = write_report(settings(context).database, name, output, request, progress)
    size = f"paths {found.n_paths}, events {found.n_events}, {found.bytes / 1e6:.1f} MB"
    emit(context, found, f"{found.file}: {size}. Open it in a browser.")
    warn(*found.lacking, *found.notes)


def export(
    context: typer.Context,
    name: Annotated[
        str, typer.Argument(help="A model with bounds by `hazard`.", show_default=False)
    ],
    output: Annotated[
        Path,
        output_file(
            "Ends in .gpkg, .geojson, .csv, .xlsx or .parquet. An export that is there is replaced."
        ),
    ],
) -> None:
    """Write the bounds and zones of a model for a GIS or a spreadsheet.

    \b
    Examples:
      avahazard export first -o first.gpkg
      avahazard export first -o first.geojson
      avahazard export first -o first.csv
      avahazard export first -o first.xlsx
      avahazard export first -o first.parquet
    """
    from avahazard.workflow.export import export as run  # noqa: PLC0415

    found = run(settings(context).database, name, output)

    def render(console: Console) -> None:
        rows = [(x.layer, x.n_features, x.crs) for x in found.layers]
        console.print(table(found.file, ("layer", ">features", "crs"), rows))

    warn(*found.notes)
    emit(context, found, render)


def paper_figures(
    context: typer.Context,
    names: Annotated[
        list[str] | None,
        typer.Argument(
            help="Stored models; without any, only what needs none is drawn.",
            show_default=False,
        ),
    ] = None,
    *,
    request: FiguresRequest,
) -> None:
    """Draw every figure of Ancey (2005) from the records and stored models.

    \b
    Examples:
      avahazard paper-figures
      avahazard paper-figures all-metropolis all-gibbs --folder figures
      avahazard paper-figures first --path P01 --format pdf
    """
    from avahazard.workflow.paper_figures import paper_figures as run  # noqa: PLC0415

    with show_progress() as report:
        found = run(settings(context).database, names or (), request, report)

    def render(console: Console) -> None:
        rows = [(row.figure, row.shows, Path(row.file).name if row.file else None) for row in found]
        console.print(table(f"Figures in {request.folder}", ("figure", "shows", "file"), rows))

    emit(context, found, render)
    for row in found:
        for note in row.notes or ():
            warn(f"No figure {row.figure} ({row.shows}): {note}")


def synth(
    context: typer.Context,
    folder: Annotated[Path, typer.Argument(help="A new or empty folder.")],
    effect: Annotated[
        list[str] | None,
        typer.Option(metavar="KEY", help="An effect that is at work; may be given again."),
    ] = None,
    strength: Annotated[
        float, typer.Option(min=0.0, max=2.0, help="Of the effects: 1 is plain to see.")
    ] = 1.0,
    events: Annotated[int, typer.Option(min=1, help="How many events.")] = 240,
    paths: Annotated[int, typer.Option(min=1, help="How many paths.")] = 9,
    speeds: Annotated[
        float | None,
        typer.Option(
            min=0.0,
            max=1.0,
            help="Share of events with measured speeds; by itself only where an effect needs them.",
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Another seed, another dataset.")] = 0,
) -> None:
    """Make a synthetic dataset with known hidden effects, to try the program on.

    \b
    Examples:
      avahazard synth my-records --events 90 --paths 5
      avahazard synth hidden --effect forest-drag --effect snow-type --seed 7
    """
    from avahazard.workflow.synth import synthesise  # noqa: PLC0415

    found = synthesise(
        folder,
        effect or [],
        strength=strength,
        n_events=events,
        n_paths=paths,
        speeds=speeds,
        seed=seed,
    )

    size = f"{counted(found.n_events, 'event')} on {counted(found.n_paths, 'path')}"
    lines = (
        f"{size}, {found.n_left_profile} beyond the profile, {found.n_speeds} speeds.",
        f"Hidden effects: {', '.join(found.effects) or 'none'}.",
        *found.files,
    )
    emit(context, found, "\n".join(lines))
