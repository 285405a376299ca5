"""What the use cases are asked: each option once, with its type, default, check and help."""

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from avahazard.hazard.volume_source import VolumeSource
from avahazard.inference.model import choices
from avahazard.records.conventions import Conventions, Decimal, Order
from avahazard.records.errors import AvahazardError
from avahazard.report.language import LanguageName
from avahazard.request import Option, Request, option
from avahazard.results.diagnosis import FIELD_DAYS

MeanSd = tuple[float, float]


def _laws() -> Iterable[str]:
    from avahazard.inference.model.laws import LAWS  # noqa: PLC0415 (slow)

    return LAWS


def _priors(texts: Sequence[str]) -> dict[str, MeanSd]:
    """Mean and standard deviation by parameter, of texts `NAME=MEAN,SD`."""
    result: dict[str, MeanSd] = {}
    for text in texts:
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


def _field_days(texts: Sequence[str]) -> dict[str, float]:
    """Days in the field by what is measured, of texts `WHAT=DAYS`."""
    result: dict[str, float] = {}
    for text in texts:
        what, _, days = text.partition("=")
        try:
            result[what.strip()] = float(days)
        except ValueError:
            raise AvahazardError(
                f"'{text}' states no days in the field.", "Give them as --field-days speed=2."
            ) from None
    return result


def _picture(what: str = "Write a picture") -> Option:
    return Option(f"{what}: .png, .svg or .pdf.")


def _periods(words: str) -> Option:
    return Option(words, short="-T", unit="years", over=1.0, most=1e6)


def _volume(words: str, **more: Any) -> Option:
    return Option(words, what="volume", unit="m3", over=0.0, most=1e15, **more)


RECORDS = VolumeSource()
"""Volumes as the records have them."""
LIMITS = Option("swiss, french, austrian, or a TOML file of your own.", metavar="LIMITS")
RELEASE_AREAS = Option("Polygons of release areas, a layer.")
SEED = Option("Equal seeds, equal draws.", least=0, most=2**62)
ONLY_PATHS = Option("Only this path; may be given again.", metavar="PATH")
EFFECT_FILES = Option("The file of an effect of your own that the model has; may be given again.")


class ImportRequest(Request):
    """How files are read, and what happens to rows that are there already."""

    dem: Path | None = option(None, "The terrain model under the lines: .tif or .asc.")
    land_cover: Path | None = option(None, "Polygons with an attribute land_cover.")
    crs: str | None = option(
        None,
        "The system of a terrain model that names none, such as EPSG:31287. [default: "
        "that of the lines]",
        metavar="CODE",
    )
    update: bool = option(False, "Replace stored rows that differ.")
    dry_run: bool = option(
        False, "Say how the files are read and what would happen, store nothing."
    )
    unusual: bool = option(
        False, "Suppress the notes on values beyond the range of snow avalanches."
    )
    decimal: Decimal | None = option(None, "The decimal sign, where a file does not show it.")
    dates: Order | None = option(None, "Day or month first, where dates do not show it.")
    unknown: Sequence[str] = option(
        (), "What stands for unknown, such as --unknown=NULL,-9999.", metavar="MARKS"
    )
    columns: str | None = option(
        None,
        "What the columns of the tables are, as columns.toml (default: the one beside "
        "them); or avalanche-slf, avalanche-utah, avalanche-colorado, landslides.",
        metavar="FILE",
    )

    @property
    def conventions(self) -> Conventions:
        """What files leave open."""
        marks = tuple(mark for text in self.unknown for mark in text.split(",") if mark)
        return Conventions(self.decimal, self.dates, self.unusual, marks)


class CalibrateRequest(Request):
    """What a model is made of, on which events it is calibrated, and how."""

    law: str = option("exponential", "Friction as a function of volume.", choices=_laws)
    scatter: choices.ScatterName = option(
        "constant", "Scatter of friction: the same for all, or by volume."
    )
    distribution: choices.DistributionName = option(
        "lognormal", "Distribution of friction given volume."
    )
    method: choices.MethodName = option(
        choices.DEFAULT_METHOD,
        "marginal accounts for measurement error; the others are the paper's.",
    )
    tails: choices.TailsName = option(
        "normal", "student is robust to outliers (Student's t, 4 degrees of freedom)."
    )
    with_: Sequence[str] = option((), "Add an effect; may be given again.", metavar="EFFECT")
    without: Sequence[str] = option(
        (), "Leave out an effect, such as centrifugal.", metavar="EFFECT"
    )
    forward: choices.ForwardName = option(
        choices.BLOCK, "What runs: the block, or the runs that `simulate` has stored."
    )
    paths: Sequence[str] = option(
        (), "Only events of this path; may be given again.", metavar="PATH"
    )
    prior_from: str | None = option(
        None,
        "The prior of the law: fit:PATH,PATH, least squares on other paths. None of their events "
        "may be among those of this model.",
        metavar="SOURCE",
    )
    prior: Mapping[str, MeanSd] = option(
        {},
        "The prior of a parameter, in its unit, as `model` lists them (lognormal where it "
        "is positive); may be given again.",
        metavar="NAME=MEAN,SD",
        parse=_priors,
    )
    chains: int = option(4, "How many chains.", what="number of chains", least=2, most=64)
    draws: int | None = option(
        None,
        "Draws of each chain. [default: 1000 by marginal, else 5000]",
        what="number of draws",
        least=50,
    )
    seed: int = option(0, SEED)


class DiagnoseRequest(Request):
    """Which effects are expected beforehand."""

    expect: Sequence[str] = option(
        (),
        "Declared before looking: tested first, at its own level; may be given again.",
        metavar="EFFECT",
    )
    field_days: Mapping[str, float] = option(
        {},
        "Days in the field that measuring one avalanche takes, for what to measure next: "
        f"{', '.join(f'{what} ({days:g})' for what, days in FIELD_DAYS.items())}; may be given "
        "again.",
        metavar="WHAT=DAYS",
        parse=_field_days,
    )
    seed: int = option(0, "Seed of the simulated rows.", least=0)
    plot: Path | None = option(None, _picture("Draw the candidates"))
    write_effect: Path | None = option(None, "Write the law of what was found as an effect file.")
    effect_files: Sequence[Path] = option((), EFFECT_FILES)

    def check(self) -> None:
        """Raise `AvahazardError` for days in the field of what is not measured, or none."""
        for what, days in self.field_days.items():
            if what not in FIELD_DAYS or not 0.0 < days < math.inf:
                raise AvahazardError(
                    f"The days in the field are {what}={days:g}.",
                    f"Give one of {', '.join(FIELD_DAYS)} and a number over 0: speed=2.",
                )


class RunoutRequest(Request):
    """The friction of a run of the block, or the model and the volume (m3) that give it."""

    mu: float | None = option(None, "Coulomb friction.", metavar="MU", what="friction", over=0.0)
    volume_m3: float | None = option(
        None, _volume("Volume: the model then gives MU.", flag="--volume")
    )
    model: str | None = option(None, "Run with the effects of a stored model.", metavar="NAME")
    table: bool = option(False, "Tell F(μ) and its derivative F′(μ) as well.")
    plot: Path | None = option(
        None, _picture("Draw the run and its speeds, or F and F′ with --table")
    )
    effect_files: Sequence[Path] = option((), EFFECT_FILES)

    def check(self) -> None:
        """Raise `AvahazardError` for values that do not go together."""
        if self.mu is None and (self.model is None or self.volume_m3 is None):
            raise AvahazardError(
                "There is no friction for the run.",
                "Give --mu MU, or --model NAME with --volume M3.",
            )
        if self.volume_m3 is not None and self.model is None:
            raise AvahazardError(
                "A volume changes the run only through a model.", "Name one: --model NAME."
            )


def _kappa(texts: Sequence[str]) -> float | str:
    text = texts[-1] if texts else "5"
    try:
        return float(text)
    except ValueError:
        return text


class FrictionRequest(Request):
    """How sharp the density is, and the model whose effects are at work, if any."""

    kappa: float | str = option(
        5.0,
        "Sharpness of the density; auto lets the records choose. [default: 5]",
        metavar="K",
        what="sharpness (--kappa)",
        over=0.0,
        parse=_kappa,
    )
    model: str | None = option(
        None, "With the effects of a stored model on motion and record.", metavar="NAME"
    )
    plot: Path | None = option(
        None, _picture("Draw the densities, and by a model its law and the events")
    )
    effect_files: Sequence[Path] = option((), EFFECT_FILES)

    def check(self) -> None:
        """Raise `AvahazardError` for values that do not go together."""
        if isinstance(self.kappa, str) and self.kappa != "auto":
            raise AvahazardError(
                f"The sharpness (--kappa) is {self.kappa}.", "It must be a number over 0, or auto."
            )


class HazardRequest(Request):
    """Return periods (years) and volumes (m3), and on which paths; none: all with a profile."""

    return_periods: Sequence[float] = option(
        (), _periods("May be given again. [default: 100, where no volume is given]")
    )
    volumes: Sequence[float] = option((), _volume("May be given again.", short="-V"))
    paths: Sequence[str] = option((), ONLY_PATHS)
    source: VolumeSource = RECORDS
    draws: int = option(20_000, "For each row.", what="number of draws", least=100, most=10_000_000)
    seed: int = option(0, SEED)
    effect_files: Sequence[Path] = option((), EFFECT_FILES)


class SimulateRequest(Request):
    """On which paths a flow model runs, and for which frictions, volumes (m3) and drag (1/m).

    Without polygons in `release`, areas are made of the path's release, its width and the volume.
    """

    paths: Sequence[str] = ()
    forward: Literal["com1dfa"] = option("com1dfa", "The flow model.")
    frictions: Sequence[float] = option(
        (),
        "May be given again. [default: 8 from 0.1 to 0.6, and more between]",
        metavar="MU",
        what="friction",
        over=0.0,
    )
    volumes: Sequence[float] = option(
        (), _volume("May be given again. [default: 4 over the recorded ones]", short="-V")
    )
    drag: float = option(0.0, "Resistance by the square of speed.", metavar="PER_M", least=0.0)
    release: Path | None = option(None, RELEASE_AREAS)


class ZonesRequest(Request):
    """Zones of which limits, at their return periods and those given, on which paths; none: all."""

    return_periods: Sequence[float] = option(
        (), _periods("Besides those of the limits; may be given again.")
    )
    limits: str = option("swiss", LIMITS)
    paths: Sequence[str] = option((), ONLY_PATHS)
    source: VolumeSource = RECORDS
    # Dense flow: 300 kg/m3 is the value of the Swiss guideline; measured flows hold 200 to 400.
    density: float = option(300.0, "Of the flow, its mean.", unit="kg/m3", over=0.0)
    density_sd: float = option(
        50.0,
        "Standard deviation of the density.",
        what="standard deviation of the density",
        unit="kg/m3",
        least=0.0,
    )
    no_drag: bool = option(
        False, "Accept speeds that nothing but friction limits: too high on long, steep paths."
    )
    plot: Path | None = option(None, _picture())
    seed: int = option(0, SEED)
    effect_files: Sequence[Path] = option((), EFFECT_FILES)


class MapRequest(Request):
    """What a map shows: the paths named or all with a profile, the zones of `limits`."""

    paths: Sequence[str] = option((), ONLY_PATHS)
    limits: str = option("swiss", LIMITS)
    source: VolumeSource = RECORDS
    seed: int = option(0, SEED)
    effect_files: Sequence[Path] = option((), EFFECT_FILES)


class AvaframeRequest(Request):
    """Paths, releases (as for `simulate`) and volumes of AvaFrame projects; draws for each."""

    paths: Sequence[str] = option((), ONLY_PATHS)
    draws: int = option(50, "Avalanches for a probability run.", least=1, most=999)
    release: Path | None = option(None, RELEASE_AREAS)
    source: VolumeSource = RECORDS
    seed: int = option(0, SEED)
    effect_files: Sequence[Path] = option((), EFFECT_FILES)


class VolumesRequest(Request):
    """Return periods (years), where the frequency of volumes comes from, and paths; none: all."""

    paths: Sequence[str] = ()
    return_periods: Sequence[float] = option(
        (), _periods("May be given again. [default: 10, 30, 100, 300]")
    )
    source: VolumeSource = RECORDS
    plot: Path | None = option(None, _picture("Draw the return levels"))
    seed: int = option(0, SEED)


class RunRequest(Request):
    """What of a project is done."""

    update: bool = option(False, "Replace stored rows that differ.")
    dry_run: bool = option(False, "Say what would be done, and do nothing.")
    force: bool = option(False, "Do every step again, also what is up to date.")


class ReportRequest(Request):
    """What the document is called, who answers for it, of which place it is; its language."""

    title: str = option("", "Title of the document.")
    author: str = option("", "Who answers for it.")
    place: str = option("", "Commune, valley or region.")
    date: str = option("", "Date of the document; else that of the calibration.")
    language: LanguageName = option("en", "Language of the report.")
    brief: bool = option(False, "Without the annex.")
    effect_files: Sequence[Path] = option((), EFFECT_FILES)


class SynthRequest(Request):
    """The effects at work, and how much there is of it."""

    effects: Sequence[str] = option(
        (), "An effect that is at work; may be given again.", metavar="KEY"
    )
    strength: float = option(1.0, "Of the effects: 1 is plain to see.", least=0.0, most=2.0)
    events: int = option(240, "How many events.", least=1)
    paths: int = option(9, "How many paths.", least=1)
    speeds: float | None = option(
        None,
        "Share of events with measured speeds; by itself only where an effect needs them.",
        what="share of events with speeds",
        least=0.0,
        most=1.0,
    )
    seed: int = option(0, "Another seed, another dataset.", least=0)
