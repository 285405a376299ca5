"""The report of a stored model as one HTML file."""

from __future__ import annotations

from pathlib import Path as FilePath

from avahazard.records.errors import AvahazardError
from avahazard.results.base import Report, silent
from avahazard.results.database import WrittenReport
from avahazard.whole_file import put_in_place
from avahazard.workflow.report_content import gather
from avahazard.workflow.requests import ReportRequest

ENDINGS = (".html", ".htm")


def write_report(
    database: str,
    name: str,
    file: FilePath,
    request: ReportRequest,
    report: Report = silent,
) -> WrittenReport:
    """Write the report of the stored model `name` to `file`; an older one is replaced.

    Nothing is computed anew that a command stores: the report shows the latest comparison,
    diagnosis, bounds and zones, and says how to get what is missing. Equal databases give equal
    files.

    Raises:
        AvahazardError: there is no such model, its own effects are not given, or
            `file` cannot be written or is not the name of a page.
    """
    if file.suffix.lower() not in ENDINGS:
        raise AvahazardError(
            f"{file} is not the name of a page.", f"It must end in {' or '.join(ENDINGS)}."
        )
    if not file.absolute().parent.is_dir():
        raise AvahazardError(f"There is no folder {file.parent}.", "Make the folder first.")
    from avahazard.report.html.page import render  # noqa: PLC0415 (plotly and jinja2 are slow)

    content = gather(database, name, request, report)
    text = render(content).encode("utf-8")
    whole = file.with_name(f".{file.name}.part")
    try:
        whole.write_bytes(text)
        put_in_place(whole, file)
    except OSError as error:
        whole.unlink(missing_ok=True)
        raise AvahazardError(
            f"{file} cannot be written: {error.strerror}.", "Name another file: -o FILE.html."
        ) from error
    report("Writing the report", 1.0, 1.0)
    return WrittenReport(
        model=name,
        file=str(file),
        bytes=len(text),
        n_paths=len(content.paths),
        n_events=len(content.events),
        lacking=tuple(dict.fromkeys(content.lacking.values())),
        notes=content.of_model,
    )
