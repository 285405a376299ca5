"""`avahazard calibrate`."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from typing import Annotated

import typer

from avahazard.cli.model_table import show_calibration
from avahazard.cli.options import Seed
from avahazard.cli.output import emit, warn
from avahazard.cli.progress import show_progress
from avahazard.cli.settings import settings
from avahazard.inference.model.laws import LAWS
from avahazard.inference.model.specification import (
    DistributionName,
    MethodName,
    ScatterName,
    TailsName,
)
from avahazard.records.errors import AvahazardError

LawName = StrEnum("LawName", {name: name for name in LAWS})  # type: ignore[misc]
EXPONENTIAL = LawName("exponential")


def calibrate(
    context: typer.Context,
    name: Annotated[str, typer.Argument(help="A new name for the model.", show_default=False)],
    law: Annotated[LawName, typer.Option(help="Friction as a function of volume.")] = EXPONENTIAL,
    scatter: Annotated[
        ScatterName, typer.Option(help="Scatter of friction: the same for all, or by volume.")
    ] = "constant",
    distribution: Annotated[
        DistributionName, typer.Option(help="Distribution of friction given volume.")
    ] = "lognormal",
    method: Annotated[
        MethodName,
        typer.Option(help="marginal knows the errors of records; the others are the paper's."),
    ] = "marginal",
    tails: Annotated[
        TailsName, typer.Option(help="student bears wrong records (4 degrees of freedom).")
    ] = "normal",
    with_: Annotated[
        list[str] | None,
        typer.Option("--with", metavar="EFFECT", help="Add an effect; may be given again."),
    ] = None,
    without: Annotated[
        list[str] | None,
        typer.Option(metavar="EFFECT", help="Leave out an effect, such as centrifugal."),
    ] = None,
    path: Annotated[
        list[str] | None,
        typer.Option(metavar="PATH", help="Only events of this path; may be given again."),
    ] = None,
    prior_from: Annotated[
        str | None,
        typer.Option(
            metavar="SOURCE",
            help="The prior of the law: a stored model, or fit:PATH,PATH for least squares on "
            "other paths. None of its events may be among those of this model.",
            show_default=False,
        ),
    ] = None,
    prior: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=MEAN,SD",
            help="The prior of a parameter, in its unit, as `model` lists them (lognormal where it "
            "is positive); may be given again.",
            show_default=False,
        ),
    ] = None,
    chains: Annotated[int, typer.Option(min=2, max=64, help="How many chains.")] = 4,
    draws: Annotated[
        int | None,
        typer.Option(
            min=50,
            help="Draws of each chain. [default: 1000 by marginal, else 5000]",
            show_default=False,
        ),
    ] = None,
    seed: Seed = 0,
) -> None:
    """Calibrate a model on the records and store it.

    \b
    Examples:
      avahazard calibrate first
      avahazard calibrate voellmy --with turbulent-drag
      avahazard calibrate paper --method metropolis --path P01 --draws 10000
      avahazard calibrate here --path P01 --prior-from elsewhere
      avahazard calibrate told --prior a=0.5,0.05 --prior n=2e-6,1e-6
    """
    from avahazard.workflow.calibrate import calibrate as run  # noqa: PLC0415

    with show_progress() as report:
        found = run(
            settings(context).database,
            name,
            law=law.value,
            scatter=scatter,
            distribution=distribution,
            method=method,
            tails=tails,
            with_=with_ or (),
            without=without or (),
            paths=path or (),
            prior_from=prior_from,
            prior=_numbers(prior or ()),
            chains=chains,
            draws=draws,
            seed=seed,
            report=report,
        )

    emit(context, found, lambda console: show_calibration(console, found))
    for note in found.notes:
        warn(note)


def _numbers(told: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Mean and standard deviation by parameter."""
    result: dict[str, tuple[float, float]] = {}
    for text in told:
        name, _, pair = text.partition("=")
        try:
            mean, sd = (float(number) for number in pair.split(","))
        except ValueError:
            raise AvahazardError(
                f"'{text}' is no prior.",
                "Give a parameter, its mean and its standard deviation: --prior a=0.5,0.05.",
            ) from None
        if name.strip() in result:
            raise AvahazardError(f"There are two priors of '{name.strip()}'.", "Give one.")
        result[name.strip()] = mean, sd
    return result
