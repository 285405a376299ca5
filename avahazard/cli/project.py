"""Commands that do a whole job: run, demo."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
from rich.padding import Padding

from avahazard.cli.hazard import show_bounds
from avahazard.cli.models import show_calibration
from avahazard.cli.options import answers
from avahazard.cli.output import Shown, Whole, table
from avahazard.report.sentences import before_and_after_text, verdict_text
from avahazard.report.words import coordinate_text
from avahazard.results.files import Demo, HiddenEffect, ProjectRun
from avahazard.workflow.requests import RunRequest


@answers("run.run_project")
def run(
    found: ProjectRun,
    file: Annotated[
        Path, typer.Argument(metavar="[avahazard.toml]", help="The file of the project.")
    ] = Path("avahazard.toml"),
    *,
    request: RunRequest,
) -> Iterator[Shown]:
    """Run a whole project: only what is out of date is done.

    \b
    Examples:
      avahazard run
      avahazard run valley/avahazard.toml
      avahazard run --dry-run
    """
    rows = [(step.step, step.state, step.found) for step in found.steps]
    yield table(f"Project {found.project}", ("step", "state", "found"), rows)
    yield Whole(f"The results are those of the model {found.model}, in {found.database}:")
    yield from (Whole(f"  {file}") for file in found.files)


def show_demo(found: Demo) -> Iterator[Shown]:
    """Show the model of the twin, its bounds, then the loop, and where all files are."""
    yield found.twin
    yield "Do not use them to judge a real place.\n"
    for model in (found.model, found.gibbs):
        yield from show_calibration(model)
        yield ""
    yield "The twin was made with a = 0.519, n = 3.36e-07 1/m3, sigma = 0.158.\n"
    yield from show_bounds(found.hazard)
    yield from show_loop(found.loop)
    yield "\nFiles:"
    database, bounds, picture, report, *data = found.files
    for words, file in (
        ("database", database),
        ("bounds of the twin's paths", bounds),
        ("picture of them", picture),
        ("report, for a browser", report),
        ("the twin itself", str(Path(data[0]).parent)),
        ("database of the synthetic dataset", found.loop.database),
        ("its records", str(Path(found.loop.files[-1]).parent)),
    ):
        yield Whole(f"  {words}: {file}")
    yield "\nGo on with it, for example:"
    for place, words in ((database, f"model {found.model.model}"), (found.loop.database, "ladder")):
        yield Whole(f"  avahazard --db {place} {words}")
    yield Whole(f"\nOne file to open, in a browser: {found.loop.report}")
    last = found.loop.child or found.loop.model
    yield (
        f"It is the report of the model “{last.model}” of the synthetic dataset: where "
        "it fails, what was found, and the error that is left."
    )


@answers("demo.run_demo", notes=lambda found: (*found.notes, *found.loop.notes))
def demo(
    found: Demo,
    folder: Annotated[
        Path, typer.Option(help="Where its database and files go; made anew each time.")
    ] = Path("avahazard-demo"),
) -> Iterator[Shown]:
    """Do the main job on the bundled data, a twin of the paper's seven paths; find what is hidden.

    The second part makes a synthetic dataset with one effect that its model lacks, lets diagnose
    name what is missing, adds that, and says how far the error falls.

    \b
    Examples:
      avahazard demo
      avahazard demo --folder try
    """
    return show_demo(found)


def show_loop(found: HiddenEffect) -> Iterator[Shown]:
    """Show the steps of the loop and its result."""
    yield (
        f"\nA synthetic dataset: {found.model.n_events} events on {found.n_paths} paths, with an "
        "effect that its first model lacks."
    )
    for k, line in enumerate(_story(found), 1):
        yield Padding(f"{k}. {line}", (0, 0, 0, 2), expand=False)


def _story(found: HiddenEffect) -> Iterator[str]:
    model, by = found.model.model, "paths" if found.held_out.by == "path" else "folds"
    yield (
        f"“{model}” is calibrated without it. Its error, on held-out {by}: "
        f"{found.held_out.runout.crps_m:.1f} m (CRPS of {coordinate_text(found.coordinate)})."
    )
    told = replace(found.diagnosis, where=())
    yield verdict_text(told, f"“{model}”")
    yield from found.diagnosis.where
    child = found.child
    if child is None or child.comparison is None:
        yield "No single effect is named, so none is added."
    else:
        added = ", ".join(key for key in child.effects if key not in found.model.effects)
        words = before_and_after_text(child.comparison)
        yield f"“{child.model}” is “{model}” with {added}. {words}"
    named, hidden = set(found.diagnosis.missing), set(found.hidden)
    answer = "the diagnosis did not find it"
    if found.diagnosis.verdict == "missing-effect" and named == hidden:
        answer = "the diagnosis is right"
    elif named & hidden:
        answer = "it is among what was named, not alone"
    yield f"The dataset was made with {', '.join(found.hidden)}: {answer}."
