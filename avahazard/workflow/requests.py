"""What the use cases are asked: each option once, with its type, default, check and help."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

from avahazard.hazard.volume_source import VolumeSource
from avahazard.inference.model.choices import (
    BLOCK,
    DEFAULT_METHOD,
    DistributionName,
    ForwardName,
    MethodName,
    ScatterName,
    TailsName,
)
from avahazard.records.conventions import Conventions, Decimal, Order
from avahazard.records.errors import AvahazardError
from avahazard.report.language import LanguageName
from avahazard.request import Option, Request

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


def _picture(what: str = "Write a picture") -> Option:
    return Option(help=f"{what}: .png, .svg or .pdf.", metavar="FILE")


def _periods(words: str) -> Option:
    return Option(help=words, short="-T", metavar="YEARS", unit="years", over=1.0)


RECORDS = VolumeSource()
"""Volumes as the records have them."""
LIMITS = Option(help="swiss, french, or a TOML file of your own.", metavar="LIMITS")
RELEASE_AREAS = Option(help="Polygons of release areas, a layer.", metavar="FILE")
SEED = Option(help="Equal seeds, equal draws.", least=0, most=2**62)
ONLY_PATHS = Option(help="Only this path; may be given again.", metavar="PATH")
EFFECT_FILES = Option(
    help="The file of an effect of your own that the model has; may be given again.", metavar="FILE"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class ImportRequest(Request):
    """How files are read, and what happens to rows that are there already.

    The profile of a line is read off the terrain model `dem` (GeoTIFF or ESRI ASCII grid, in
    metres), and the ground around it is kept.
    """

    dem: Annotated[
        Path | None, Option(help="The terrain model under the lines: .tif or .asc.", metavar="FILE")
    ] = None
    land_cover: Annotated[
        Path | None, Option(help="Polygons with an attribute land_cover.", metavar="FILE")
    ] = None
    crs: Annotated[
        str | None,
        Option(
            help="The system of a terrain model that names none, such as EPSG:31287. [default: "
            "that of the lines]",
            metavar="CODE",
        ),
    ] = None
    update: Annotated[bool, Option(help="Replace stored rows that differ.")] = False
    dry_run: Annotated[
        bool, Option(help="Say how the files are read and what would happen, store nothing.")
    ] = False
    unusual: Annotated[
        bool, Option(help="Suppress the notes on values beyond the range of snow avalanches.")
    ] = False
    decimal: Annotated[
        Decimal | None, Option(help="The decimal sign, where a file does not show it.")
    ] = None
    dates: Annotated[
        Order | None, Option(help="Day or month first, where dates do not show it.")
    ] = None
    unknown: Annotated[
        Sequence[str],
        Option(help="What stands for unknown, such as --unknown=NULL,-9999.", metavar="MARKS"),
    ] = ()
    columns: Annotated[
        str | None,
        Option(
            help="What the columns of the tables are, as columns.toml (default: the one beside "
            "them); or avalanche-slf, avalanche-utah, avalanche-colorado, landslides.",
            flag="--columns",
            metavar="FILE",
        ),
    ] = None

    @property
    def conventions(self) -> Conventions:
        """What files leave open."""
        marks = tuple(mark for text in self.unknown for mark in text.split(",") if mark)
        return Conventions(self.decimal, self.dates, self.unusual, marks)


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrateRequest(Request):
    """What a model is made of, on which events it is calibrated, and how."""

    law: Annotated[str, Option(help="Friction as a function of volume.", choices=_laws)] = (
        "exponential"
    )
    scatter: Annotated[
        ScatterName, Option(help="Scatter of friction: the same for all, or by volume.")
    ] = "constant"
    distribution: Annotated[
        DistributionName, Option(help="Distribution of friction given volume.")
    ] = "lognormal"
    method: Annotated[
        MethodName,
        Option(help="marginal accounts for measurement error; the others are the paper's."),
    ] = DEFAULT_METHOD
    tails: Annotated[
        TailsName, Option(help="student is robust to outliers (Student's t, 4 degrees of freedom).")
    ] = "normal"
    with_: Annotated[
        Sequence[str], Option(help="Add an effect; may be given again.", metavar="EFFECT")
    ] = ()
    without: Annotated[
        Sequence[str], Option(help="Leave out an effect, such as centrifugal.", metavar="EFFECT")
    ] = ()
    forward: Annotated[
        ForwardName, Option(help="What runs: the block, or the runs that `simulate` has stored.")
    ] = BLOCK
    paths: Annotated[
        Sequence[str], Option(help="Only events of this path; may be given again.", metavar="PATH")
    ] = ()
    prior_from: Annotated[
        str | None,
        Option(
            help="The prior of the law: a stored model, or fit:PATH,PATH for least squares on "
            "other paths. None of its events may be among those of this model.",
            metavar="SOURCE",
        ),
    ] = None
    prior: Annotated[
        Mapping[str, MeanSd],
        Option(
            help="The prior of a parameter, in its unit, as `model` lists them (lognormal where it "
            "is positive); may be given again.",
            metavar="NAME=MEAN,SD",
            parse=_priors,
        ),
    ] = field(default_factory=dict)
    chains: Annotated[
        int, Option(help="How many chains.", what="number of chains", least=2, most=64)
    ] = 4
    draws: Annotated[
        int | None,
        Option(
            help="Draws of each chain. [default: 1000 by marginal, else 5000]",
            what="number of draws",
            least=50,
        ),
    ] = None
    seed: Annotated[int, SEED] = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class DiagnoseRequest(Request):
    """Which effects are expected beforehand."""

    expect: Annotated[
        Sequence[str],
        Option(
            help="Declared before looking: tested first, at its own level; may be given again.",
            metavar="EFFECT",
        ),
    ] = ()
    seed: Annotated[int, Option(help="Seed of the simulated rows.", least=0)] = 0
    plot: Annotated[Path | None, _picture("Draw the candidates")] = None
    write_effect: Annotated[
        Path | None,
        Option(help="Write the law of what was found as an effect file.", metavar="FILE"),
    ] = None
    effect_files: Annotated[Sequence[Path], EFFECT_FILES] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class RunoutRequest(Request):
    """The friction of a run of the block, or the model and the volume (m3) that give it."""

    mu: Annotated[
        float | None, Option(help="Coulomb friction.", metavar="MU", what="friction", over=0.0)
    ] = None
    volume_m3: Annotated[
        float | None,
        Option(
            help="Volume: the model then gives MU.",
            flag="--volume",
            metavar="M3",
            what="volume",
            unit="m3",
            over=0.0,
        ),
    ] = None
    model: Annotated[
        str | None, Option(help="Run with the effects of a stored model.", metavar="NAME")
    ] = None
    table: Annotated[bool, Option(help="Tell F(μ) and its derivative F′(μ) as well.")] = False
    plot: Annotated[
        Path | None, _picture("Draw the run and its speeds, or F and F′ with --table")
    ] = None
    effect_files: Annotated[Sequence[Path], EFFECT_FILES] = ()

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


BY_MODEL = Option(help="With the effects of a stored model on motion and record.", metavar="NAME")


@dataclass(frozen=True, slots=True, kw_only=True)
class FrictionRequest(Request):
    """How sharp the density is, and the model whose effects are at work, if any."""

    kappa: Annotated[
        float | str,
        Option(
            help="Sharpness of the density; auto lets the records choose. [default: 5]",
            metavar="K",
            what="sharpness (--kappa)",
            over=0.0,
            parse=_kappa,
        ),
    ] = 5.0
    model: Annotated[str | None, BY_MODEL] = None
    plot: Annotated[
        Path | None, _picture("Draw the densities, and by a model its law and the events")
    ] = None
    effect_files: Annotated[Sequence[Path], EFFECT_FILES] = ()

    def check(self) -> None:
        """Raise `AvahazardError` for values that do not go together."""
        if isinstance(self.kappa, str) and self.kappa != "auto":
            raise AvahazardError(
                f"The sharpness (--kappa) is {self.kappa}.", "It must be a number over 0, or auto."
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class AlphaBetaRequest(Request):
    """By which regressions, and the model whose latest bounds stand beside them in the picture."""

    by: Annotated[
        Sequence[str],
        Option(
            help="norway, austria, avaframe or avaframe-small; may be given several times. "
            "[default: norway, austria]",
            metavar="NAME",
        ),
    ] = ()
    model: Annotated[
        str | None,
        Option(help="Show the latest bounds by this model in the picture too.", metavar="NAME"),
    ] = None
    plot: Annotated[Path | None, _picture()] = None

    def check(self) -> None:
        """Raise `AvahazardError` for values that do not go together."""
        if self.model is not None and self.plot is None:
            raise AvahazardError("A --model is shown in a picture only: give --plot FILE.")


@dataclass(frozen=True, slots=True, kw_only=True)
class FiguresRequest(Request):
    """Which figures of the paper, and where they go."""

    folder: Annotated[Path, Option(help="Where the pictures are written.")] = Path("paper-figures")
    paths: Annotated[Sequence[str], ONLY_PATHS] = ()
    kind: Annotated[
        Literal["png", "svg", "pdf"], Option(help="The kind of pictures.", flag="--format")
    ] = "png"
    effect_files: Annotated[Sequence[Path], EFFECT_FILES] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class HazardRequest(Request):
    """Return periods (years) and volumes (m3), and on which paths.

    With neither of the first two, a return period of 100 years. Paths are those named, or all with
    a profile. `source` says where the frequency of volumes comes from.
    """

    return_periods: Annotated[
        Sequence[float], _periods("May be given again. [default: 100, where no volume is given]")
    ] = ()
    volumes: Annotated[
        Sequence[float],
        Option(help="May be given again.", short="-V", metavar="M3", unit="m3", over=0.0),
    ] = ()
    paths: Annotated[Sequence[str], ONLY_PATHS] = ()
    source: VolumeSource = RECORDS
    draws: Annotated[
        int, Option(help="For each row.", what="number of draws", least=100, most=10_000_000)
    ] = 20_000
    seed: Annotated[int, SEED] = 0
    effect_files: Annotated[Sequence[Path], EFFECT_FILES] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulateRequest(Request):
    """On which paths a flow model runs, and for which frictions, volumes (m3) and drag (1/m).

    Frictions are refined where stops are far apart, unless they are named. `release` holds polygons
    of release areas; without it they are made of the release, the width and the volume.
    """

    paths: Sequence[str] = ()
    forward: Annotated[Literal["com1dfa"], Option(help="The flow model.")] = "com1dfa"
    frictions: Annotated[
        Sequence[float],
        Option(
            help="May be given again. [default: 8 from 0.1 to 0.6, and more between]",
            metavar="MU",
            what="friction",
            over=0.0,
        ),
    ] = ()
    volumes: Annotated[
        Sequence[float],
        Option(
            help="May be given again. [default: 4 over the recorded ones]",
            short="-V",
            metavar="M3",
            what="volume",
            unit="m3",
            over=0.0,
        ),
    ] = ()
    drag: Annotated[
        float, Option(help="Resistance by the square of speed.", metavar="PER_M", least=0.0)
    ] = 0.0
    release: Annotated[Path | None, RELEASE_AREAS] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class AvaframeRequest(Request):
    """Of which paths AvaFrame projects are written, and how many avalanches are drawn of each.

    `release` holds polygons of release areas, as for `simulate`.
    """

    paths: Annotated[Sequence[str], ONLY_PATHS] = ()
    draws: Annotated[
        int,
        Option(help="Avalanches for a probability run.", what="number of draws", least=1, most=999),
    ] = 50
    release: Annotated[Path | None, RELEASE_AREAS] = None
    source: VolumeSource = RECORDS
    seed: Annotated[int, SEED] = 0
    effect_files: Annotated[Sequence[Path], EFFECT_FILES] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class ZonesRequest(Request):
    """Which zones, on the paths named or all with a profile.

    Zones are those of `limits`, a preset or a TOML file, at the return periods (years) of these
    and those given. A model without drag and without measured speeds needs `no_drag`. `density` and
    its standard deviation are in kg/m3; `source` says where the frequency of volumes comes from.
    """

    return_periods: Annotated[
        Sequence[float], _periods("Besides those of the limits; may be given again.")
    ] = ()
    limits: Annotated[str, LIMITS] = "swiss"
    paths: Annotated[Sequence[str], ONLY_PATHS] = ()
    source: VolumeSource = RECORDS
    # Dense flow: 300 kg/m3 is the value of the Swiss guideline; measured flows hold 200 to 400.
    density: Annotated[
        float, Option(help="Of the flow, its mean.", metavar="KG_M3", unit="kg/m3", over=0.0)
    ] = 300.0
    density_sd: Annotated[
        float,
        Option(
            help="Standard deviation of the density.",
            metavar="KG_M3",
            what="standard deviation of the density",
            unit="kg/m3",
            least=0.0,
        ),
    ] = 50.0
    no_drag: Annotated[
        bool,
        Option(
            help="Accept speeds that nothing but friction limits: too high on long, steep paths."
        ),
    ] = False
    plot: Annotated[Path | None, _picture()] = None
    seed: Annotated[int, SEED] = 0
    effect_files: Annotated[Sequence[Path], EFFECT_FILES] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class MapRequest(Request):
    """What a map shows: the paths named or all with a profile, the zones of `limits`.

    `source` says where the frequency of volumes comes from.
    """

    paths: Annotated[Sequence[str], ONLY_PATHS] = ()
    limits: Annotated[str, LIMITS] = "swiss"
    source: VolumeSource = RECORDS
    seed: Annotated[int, SEED] = 0
    effect_files: Annotated[Sequence[Path], EFFECT_FILES] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class VolumesRequest(Request):
    """Return periods (years), where the frequency of volumes comes from, and paths; none: all."""

    paths: Sequence[str] = ()
    return_periods: Annotated[
        Sequence[float], _periods("May be given again. [default: 10, 30, 100, 300]")
    ] = ()
    source: VolumeSource = RECORDS
    plot: Annotated[Path | None, _picture("Draw the return levels")] = None
    seed: Annotated[int, SEED] = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class RunRequest(Request):
    """What of a project is done."""

    update: Annotated[bool, Option(help="Replace stored rows that differ.")] = False
    dry_run: Annotated[bool, Option(help="Say what would be done, and do nothing.")] = False
    force: Annotated[bool, Option(help="Do every step again, also what is up to date.")] = False


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportRequest(Request):
    """What the document is called, who answers for it, of which place it is; its language."""

    title: Annotated[str, Option(help="Title of the document.")] = ""
    author: Annotated[str, Option(help="Who answers for it.")] = ""
    place: Annotated[str, Option(help="Commune, valley or region.")] = ""
    date: Annotated[str, Option(help="Date of the document; else that of the calibration.")] = ""
    language: Annotated[LanguageName, Option(help="Language of the report.")] = "en"
    brief: Annotated[bool, Option(help="Without the annex.")] = False
    effect_files: Annotated[Sequence[Path], EFFECT_FILES] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class SynthRequest(Request):
    """The effects at work, and how much there is of it."""

    effects: Annotated[
        Sequence[str], Option(help="An effect that is at work; may be given again.", metavar="KEY")
    ] = ()
    strength: Annotated[
        float, Option(help="Of the effects: 1 is plain to see.", least=0.0, most=2.0)
    ] = 1.0
    events: Annotated[int, Option(help="How many events.", least=1)] = 240
    paths: Annotated[int, Option(help="How many paths.", least=1)] = 9
    speeds: Annotated[
        float | None,
        Option(
            help="Share of events with measured speeds; by itself only where an effect needs them.",
            what="share of events with speeds",
            least=0.0,
            most=1.0,
        ),
    ] = None
    seed: Annotated[int, Option(help="Another seed, another dataset.", least=0)] = 0
