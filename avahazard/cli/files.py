"""Commands on the database and on files: init, db, report, export, synth."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer

from avahazard.cli.options import StoredModel, answers, argument, flag, output_file
from avahazard.cli.output import Shown, Whole, ask, emit, table
from avahazard.notes import counted
from avahazard.records.errors import AvahazardError
from avahazard.results import files as results
from avahazard.workflow.requests import AvaframeRequest, ReportRequest, SynthRequest


@answers("database.init_database")
def init(found: results.Created) -> Iterator[Shown]:
    """Create the database, or say that it exists.

    \b
    Examples:
      avahazard init
      avahazard --db valley.db init
    """
    done = "was created" if found.created else "exists"
    yield Whole(f"The database {found.database} {done}.")


db = typer.Typer(
    help="Upgrade, look at, check or copy the database.",
    rich_markup_mode=None,
    add_completion=False,
    no_args_is_help=True,
)


@db.command()
@answers("database.upgrade_database")
def upgrade(found: results.Upgraded) -> Iterator[Shown]:
    """Bring the tables of the database up to date.

    \b
    Example:
      avahazard db upgrade
    """
    words = f"went from revision {found.from_} to {found.to}"
    if found.from_ == found.to:
        words = "is up to date"
    copied = "" if found.backup is None else f"Copied it to {found.backup} before.\n"
    yield Whole(f"{copied}The database {found.database} {words}.")


@db.command()
@answers("database.database_status")
def status(found: results.DatabaseState) -> Iterator[Shown]:
    """Show the revision of the database and what it holds.

    \b
    Examples:
      avahazard db status
      avahazard --db valley.db db status
    """
    yield Whole(f"Database: {found.database}")
    own = f"(revision {found.revision or 'none'}, this program's is {found.head})"
    yield f"Tables: {found.state} {own}"
    if found.counts:
        yield table("", ("holds", ">number"), found.counts.items())


def _checked(found: results.Checked) -> Iterator[Shown]:
    yield Whole(f"The database {found.database} is whole.")
    for model in found.recomputed or ():
        words = "as stored, to the last bit"
        if not model.identical:
            words = f"could not be held against it: {model.why_not}"
        yield Whole(f"{model.model} calibrated again: {words}")


@db.command()
def check(
    full: Annotated[bool, flag("--full", "Calibrate some models again: the same draws?")] = False,
) -> None:
    """Check that the database is whole, by its checksums; status 1 when it is not.

    \b
    Examples:
      avahazard db check
      avahazard db check --full
    """
    found = ask("database.check", full=full)
    if not found.whole:
        faults = "\n".join(found.problems)
        raise AvahazardError(
            f"The database {found.database} is not whole.\n{faults}", "Go back to a backup."
        )
    emit(found, _checked)


@db.command()
@answers("database.backup_database")
def backup(
    found: results.Copied, target: Annotated[str, argument("The new file.", "FILE")]
) -> Iterator[Shown]:
    """Copy the database to a new file, also while it is in use.

    \b
    Example:
      avahazard db backup copy.db
    """
    yield Whole(f"Copied {found.database} to {found.backup}.")


@answers("report.write_report", notes=lambda found: (*found.lacking, *found.notes))
def report(
    found: results.WrittenReport,
    name: StoredModel,
    file: Annotated[Path, output_file("Where to write it: .html. One that is there is replaced.")],
    *,
    request: ReportRequest,
) -> Iterator[Shown]:
    """Write a report of a model as one HTML file that needs no network.

    \b
    Examples:
      avahazard report first -o first.html
      avahazard report first -o first.html --title "Val d'Arly" --author "A. Favre"
      avahazard report first -o first-de.html --language de
      avahazard --json report first -o first.html
    """
    size = f"paths {found.n_paths}, events {found.n_events}, {found.bytes / 1e3:,.0f} kB"
    yield Whole(f"{found.file}: {size}. Open it in a browser.")


def _exported(found: results.Export) -> Iterator[Shown]:
    rows = [(x.layer, x.n_features, x.crs) for x in found.layers]
    yield table(found.file, ("layer", ">features", "crs"), rows)


def export(
    name: Annotated[str, argument("A model with bounds by `hazard`; any model for --avaframe.")],
    file: Annotated[
        Path | None,
        output_file("Ends in .gpkg, .geojson, .csv or .xlsx. An export that is there is replaced."),
    ] = None,
    avaframe: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", help="A new folder for AvaFrame projects (options below)."),
    ] = None,
    *,
    request: AvaframeRequest,
) -> None:
    """Write the bounds and zones of a model for a GIS or a spreadsheet; or AvaFrame projects.

    A .csv holds the bounds alone.

    A project has the inputs of com1DFA, its settings with the median friction, and in `draws`
    future avalanches for a probability run.

    \b
    Examples:
      avahazard export first -o first.gpkg
      avahazard export first -o first.geojson
      avahazard export first -o first.csv
      avahazard export first -o first.xlsx
      avahazard export flow --avaframe projects --draws 100
    """
    if (file is None) == (avaframe is None):
        raise typer.BadParameter("Give one of -o FILE and --avaframe FOLDER.")
    if avaframe is None:
        found = ask("export.export", name=name, file=file)
    else:
        found = ask("export_avaframe.write_projects", name=name, folder=avaframe, request=request)
    emit(found, _exported)


@answers("synth.synthesise")
def synth(
    found: results.SyntheticDataset,
    folder: Annotated[Path, typer.Argument(help="A new or empty folder.")],
    *,
    request: SynthRequest,
) -> Iterator[Shown]:
    """Make a synthetic dataset with known hidden effects, to try the program on.

    \b
    Examples:
      avahazard synth my-records --events 90 --paths 5
      avahazard synth hidden --effect forest-drag --effect snow-type --seed 7
    """
    size = f"{counted(found.n_events, 'event')} on {counted(found.n_paths, 'path')}"
    yield Whole(f"{size}, {found.n_left_profile} beyond the profile, {found.n_speeds} speeds.")
    yield Whole(f"Hidden effects: {', '.join(found.effects) or 'none'}.")
    yield from map(Whole, found.files)
