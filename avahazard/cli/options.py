"""Arguments and options of commands, made of the requests of the use cases."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from avahazard.records.errors import AvahazardError
from avahazard.request import Field, Request, parts_of
from avahazard.workflow.requests import EFFECT_FILES

StoredModel = Annotated[str, typer.Argument(help="A stored model.", show_default=False)]
CalibratedModel = Annotated[str, typer.Argument(help="A calibrated model.", show_default=False)]
OnePath = Annotated[str, typer.Argument(help="The path_id of a path.", show_default=False)]
EffectFiles = Annotated[
    list[Path] | None,
    typer.Option("--effect-file", metavar=EFFECT_FILES.metavar, help=EFFECT_FILES.help),
]


def picture(what: str = "Write a picture") -> Any:
    """The option of a picture: `what` it shows."""
    return typer.Option(metavar="FILE", help=f"{what}: .png, .svg or .pdf.")


def output_file(words: str) -> Any:
    """The option of the file to write: what it may be."""
    return typer.Option("-o", "--output", metavar="FILE", help=words, show_default=False)


def taking_requests(command: Callable[..., Any]) -> Callable[..., Any]:
    """The command with the options of each request that it takes in the place of the request."""
    own = inspect.signature(command, eval_str=True).parameters
    asked = {name: p.annotation for name, p in own.items() if _is_request(p.annotation)}

    def taken(**values: Any) -> Any:
        return command(**values | {name: _filled(kind, values) for name, kind in asked.items()})

    parameters = []
    for name, parameter in own.items():
        parameters += list(_options(asked[name])) if name in asked else [parameter]
    taken.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        [p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in parameters]
    )
    taken.__name__, taken.__doc__ = command.__name__, command.__doc__
    taken.__annotations__ = {}
    return taken


def _is_request(kind: Any) -> bool:
    return inspect.isclass(kind) and issubclass(kind, Request)


def _options(request: type[Request]) -> Iterator[inspect.Parameter]:
    """The options of a request, those of a request within it in its place."""
    for part in parts_of(request):
        if isinstance(part, Field):
            yield _option(part)
        else:
            yield from _options(part[1])


def _option(field: Field) -> inspect.Parameter:
    option = field.option
    several = field.many or option.parse is not None
    default = None if several else field.default
    kind = str if option.parse is not None else field.kind
    if option.choices is not None:
        kind = Literal[tuple(option.choices())]
    if several:
        kind = list[kind] | None  # type: ignore[valid-type]
    elif default is None:
        kind = kind | None
    told = typer.Option(
        *((option.short,) if option.short else ()),
        field.flag,
        help=option.help,
        metavar=option.metavar,
        min=option.least if field.kind is int else None,
        max=option.most if field.kind is int else None,
    )
    return inspect.Parameter(
        field.name,
        inspect.Parameter.KEYWORD_ONLY,
        default=default,
        annotation=Annotated[kind, told],
    )


def _filled(request: type[Request], values: dict[str, Any]) -> Request:
    """The request of these values, which are taken away; bad ones are wrong usage."""
    asked: dict[str, Any] = {}
    for part in parts_of(request):
        if not isinstance(part, Field):
            asked[part[0]] = _filled(part[1], values)
            continue
        value = values.pop(part.name)
        if part.option.parse is not None:
            value = part.option.parse(value or ())
        asked[part.name] = () if part.many and value is None else value
    try:
        return request(**asked)
    except AvahazardError as error:
        raise typer.BadParameter(str(error)) from error


def add_engine_options(command: Any) -> None:
    """Give a command the options; they choose the engine, and the command never sees them."""
    carrier = typer.Typer(rich_markup_mode=None, add_completion=False)
    carrier.command()(_carrier)
    own = [p for p in typer.main.get_command(carrier).params if p.name in ENGINE]
    command.params.extend(own)
    inner = command.callback

    def callback(**values: Any) -> Any:
        from avahazard.cli.output import warn  # noqa: PLC0415 (help needs no engine)
        from avahazard.engine import close_engine, set_engine  # noqa: PLC0415

        engine, workers, scheduler = (values.pop(name) for name in ENGINE)
        try:
            set_engine(engine, workers=workers, scheduler=scheduler, tell=warn)
            return inner(**values)
        finally:
            close_engine()

    command.callback = callback


ENGINE = ("engine", "workers", "scheduler")


def _carrier(
    engine: Annotated[
        Literal["local", "processes", "dask"],
        typer.Option(help="Threads, processes, or a dask cluster; results are the same."),
    ] = "local",
    workers: Annotated[
        int | None,
        typer.Option(
            min=1,
            max=1024,
            metavar="N",
            help="How many share the work; results are the same. [default: the cores]",
        ),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS",
            help="Of dask, such as tcp://host:8786; without it dask has workers on this machine.",
        ),
    ] = None,
) -> None:
    """Nothing but its options."""
