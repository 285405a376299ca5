"""`avahazard model`."""

from __future__ import annotations

from typing import Annotated, Any

import typer
from rich.console import Console

from avahazard.cli.model_table import show_calibration
from avahazard.cli.output import emit, table, warn
from avahazard.cli.settings import settings


def model(
    context: typer.Context,
    name: Annotated[str, typer.Argument(help="The name of a model.", show_default=False)],
    provenance: Annotated[
        bool, typer.Option("--provenance", help="Show what is needed to make it again.")
    ] = False,
) -> None:
    """Show a stored model: its posterior, and whether it converged.

    \b
    Examples:
      avahazard model first
      avahazard model first --provenance
    """
    if provenance:
        _show_provenance(context, name)
        return
    from avahazard.workflow.models import show_model  # noqa: PLC0415

    found = show_model(settings(context).database, name)

    def render(console: Console) -> None:
        show_calibration(console, found)
        line = f"Stored {str(found.created).replace('T', ' ').removesuffix('Z')} (UTC)"
        parent = f", from {found.parent}" if found.parent else ""
        fingerprint = found.data_fingerprint[:12]
        console.print(f"{line}{parent}, on the records {fingerprint}….")

    emit(context, found, render)
    warn(*found.notes)


def _show_provenance(context: typer.Context, name: str) -> None:
    from avahazard.workflow.provenance import show_provenance  # noqa: PLC0415

    found = show_provenance(settings(context).database, name)
    made = found.made_with

    def render(console: Console) -> None:
        rows = [
            ("stored (UTC)", found.created),
            ("parent", found.parent),
            ("records", found.data_fingerprint),
            ("method", f"{found.method}, {found.chains} chains of {found.draws} draws"),
            ("seed", found.seed),
            ("paths", ", ".join(found.paths) or "all"),
            *((key, _told(key, value)) for key, value in found.specification.items()),
            ("effect files, SHA-256", found.effect_sha256),
            ("lock, SHA-256", None if made is None else made.lock_sha256),
        ]
        console.print(table(f"Provenance of {name}", ("", "value"), rows))
        was = {} if made is None else made.versions
        versions = [(key, was.get(key), now) for key, now in found.now.versions.items()]
        console.print(table("", ("version of", "then", "now"), versions))

    emit(context, found, render)
    if found.records_changed:
        warn(f"the records have changed since {name} was calibrated.")


def _told(key: str, value: Any) -> str | None:
    """A part of the specification; of priors, where they are from or their numbers."""
    if key == "prior":
        return value["source"] if value else None
    if key == "given":
        return ", ".join(f"{g['name']} {g['mean']:g} ± {g['sd']:g}" for g in value) or None
    return (", ".join(value) or None) if isinstance(value, list | tuple) else str(value)
