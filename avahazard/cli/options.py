"""Arguments and options of commands, made of the requests of the use cases."""

import inspect
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Annotated, Any

import typer

from avahazard.cli.output import Shown, ask, emit, warn
from avahazard.engine import LOCAL, EngineName, close_engine, set_engine
from avahazard.records.errors import AvahazardError
from avahazard.request import Field, Request, option, parts_of
from avahazard.workflow.requests import EFFECT_FILES


def argument(words: str, metavar: str | None = None) -> Any:
    """An argument: what it is."""
    return typer.Argument(metavar=metavar, help=words, show_default=False)


def flag(name: str, words: str) -> Any:
    """An option without a value: its name, and what it does."""
    return typer.Option(name, help=words)


StoredModel = Annotated[str, argument("A stored model.")]
CalibratedModel = Annotated[str, argument("A calibrated model.")]
OnePath = Annotated[str, argument("The path_id of a path.", "PATH")]
EffectFiles = Annotated[
    list[Path] | None, typer.Option("--effect-file", metavar="FILE", help=EFFECT_FILES.help)
]


def picture(what: str = "Write a picture") -> Any:
    """The option of a picture: `what` it shows."""
    return typer.Option(metavar="FILE", help=f"{what}: .png, .svg or .pdf.")


def output_file(words: str) -> Any:
    """The option of the file to write, with its help."""
    return typer.Option("-o", "--output", metavar="FILE", help=words, show_default=False)


def answers(
    use_case: str, **how: Callable[[Any], Any]
) -> Callable[[Callable[..., Iterable[Shown]]], Callable[..., None]]:
    """Let a use case (`ask`) answer a command, which gives what people are shown of the result.

    The result is its first parameter; the others have the names of the use case. `how` as for
    `emit`.
    """

    def decorated(command: Callable[..., Iterable[Shown]]) -> Callable[..., None]:
        def answered(**values: Any) -> None:
            emit(ask(use_case, **values), partial(command, **values), **how)

        return _looking_like(command, answered, _parameters(command)[1:])

    return decorated


def taking_requests(command: Callable[..., Any]) -> Callable[..., Any]:
    """The command with the options of each request that it takes in the place of the request."""
    own = _parameters(command)
    asked = {
        p.name: p.annotation
        for p in own
        if inspect.isclass(p.annotation) and issubclass(p.annotation, Request)
    }

    def taken(**values: Any) -> Any:
        return command(**values | {name: _filled(kind, values) for name, kind in asked.items()})

    return _looking_like(
        command, taken, chain(*(_options(asked[p.name]) if p.name in asked else [p] for p in own))
    )


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
    choices = field.choices
    kind = str if choices or option.parse is not None else field.kind
    if several:
        kind = list[kind] | None  # type: ignore[valid-type]
    elif default is None:
        kind = kind | None
    told: Any = typer.Option(
        *((option.short,) if option.short else ()),
        field.flag,
        help=option.help,
        metavar=f"<{'|'.join(choices)}>" if choices else field.metavar,
        parser=_number if field.kind is float and option.parse is None else None,
        autocompletion=(lambda: list(choices)) if choices else None,
        min=option.least if field.kind is int else None,
        max=option.most if field.kind is int else None,
    )
    return inspect.Parameter(
        field.name,
        inspect.Parameter.KEYWORD_ONLY,
        default=default,
        annotation=Annotated[kind, told],
    )


def _number(text: str) -> float:
    """The number of an option; of a default it is one already."""
    try:
        return float(text)
    except ValueError as error:
        raise typer.BadParameter(
            f"'{text}' is no number. Write one number, with a point: 0.5; where several may be "
            "given, the option again for each."
        ) from error


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


class EngineRequest(Request):
    """Who does the work, and how many of them."""

    engine: EngineName = option(
        LOCAL, "Threads, processes, or a dask cluster; results are the same."
    )
    workers: int | None = option(
        None,
        "How many share the work; results are the same. [default: the cores]",
        metavar="N",
        least=1,
        most=1024,
    )
    scheduler: str | None = option(
        None,
        "Of dask, such as tcp://host:8786; without it dask has workers on this machine.",
        metavar="ADDRESS",
    )


def with_engine(command: Callable[..., None]) -> Callable[..., None]:
    """The command with the options of the engine, which it never sees."""

    def engaged(*, by: EngineRequest, **values: Any) -> None:
        try:
            set_engine(by.engine, workers=by.workers, scheduler=by.scheduler, tell=warn)
            command(**values)
        finally:
            close_engine()

    return _looking_like(command, engaged, [*_parameters(command), *_parameters(engaged)[:1]])


def _parameters(command: Callable[..., Any]) -> list[inspect.Parameter]:
    return list(inspect.signature(command, eval_str=True).parameters.values())


def _looking_like(
    command: Callable[..., Any], made: Callable[..., Any], parameters: Iterable[inspect.Parameter]
) -> Callable[..., Any]:
    """What was `made` of a command, with its name and help, and these parameters."""
    named = [p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in parameters]
    made.__signature__ = inspect.Signature(named)  # type: ignore[attr-defined]
    made.__name__, made.__doc__, made.__annotations__ = command.__name__, command.__doc__, {}
    return made
