"""What a report is made of, gathered by the use case; lengths in m, volumes in m3."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from avahazard.arrays import Bools, Floats
from avahazard.effects.site import release_place, stop_place
from avahazard.notes import Note
from avahazard.physics.smooth_profile import SmoothProfile, smooth_profile
from avahazard.records.collection import Event, Path, Records, TerrainCrop, of_path
from avahazard.results.calibration import Calibration
from avahazard.results.comparison import Comparison, LadderEntry
from avahazard.results.diagnosis import Diagnosis, Shape
from avahazard.results.friction import FrictionDensity
from avahazard.results.hazard import HazardRow, PlaceQuantiles, Zone, ZonedPath
from avahazard.results.terrain import PathSummary, TerrainRunout


@dataclass(frozen=True, slots=True)
class EventView(Event):
    """One record, and what the model says of it.

    `coordinate` is what was recorded: `elevation`, `x` or `length`; `observed_m` is None where
    the event ran beyond its profile. `stop_x_m` is its place on the path, None off the profile.
    `predicted` holds the 5, 50 and 95 % quantiles in the same coordinate, None where the model
    predicts nothing for this event. `mu_reference` is apparent friction under the model less what
    its effects on friction and its path add to it, None where no friction stops the block there.
    """

    stop_x_m: float | None = None
    coordinate: str = "elevation"
    observed_m: float | None = None
    mu_reference: float | None = None
    predicted: tuple[float, float, float] | None = None


def event_view(event: Event, smooth: SmoothProfile | None) -> EventView:
    """One event by itself, with its place on the path's smoothed profile, where it has one."""
    recorded = {field.name: getattr(event, field.name) for field in fields(event)}
    return EventView(**recorded, stop_x_m=None if smooth is None else stop_place(smooth, event))


@dataclass(frozen=True, slots=True, eq=False)
class FrictionView:
    """Friction against `volume` `[n_volumes]`.

    `law` `[3, n_volumes]`: 5, 50 and 95 % of the median friction over the posterior; `scatter`
    `[4, n_volumes]`: 5, 25, 75 and 95 % of the friction of avalanches, None where the model's
    scatter is not one of friction.
    """

    volume: Floats
    law: Floats
    scatter: Floats | None


@dataclass(frozen=True, slots=True, eq=False)
class FlowView:
    """Annual chance by a flow model in the cells of the ground, `[n_rows, n_columns]`.

    `runouts` are the places along the line that it comes to once in the periods (years).
    """

    chance: Floats
    runouts: Mapping[float, PlaceQuantiles]


@dataclass(frozen=True, slots=True, eq=False)
class PlanView:
    """A path on the map: `east`, `north` `[n]` at places `x`; degrees where `crs` is None.

    `ground` is the terrain around it, in the same system, and `flow` what comes to its cells.
    """

    x: Floats
    east: Floats
    north: Floats
    crs: str | None
    ground: TerrainCrop | None = None
    flow: FlowView | None = None

    def at(self, x: Any) -> tuple[Floats, Floats]:
        """East and north of places x (m)."""
        return np.interp(x, self.x, self.east), np.interp(x, self.x, self.north)


SpeedLine = tuple[HazardRow, Floats, Floats]
"""A row of bounds, and for it places x (m) with the speed (m/s) of the block there, `[n]`."""


@dataclass(frozen=True, slots=True, eq=False)
class PathView:
    """One path: what is known of it, its profile if any, and the results on it.

    `rows` are those of `hazard`, `alpha_beta` and `zones` those of the commands of that name.
    """

    path: Path
    smooth: SmoothProfile | None
    release_x: float | None
    events: tuple[EventView, ...]
    rows: Sequence[HazardRow] = ()
    notes: Sequence[Note] = ()
    speeds: Sequence[SpeedLine] = ()
    alpha_beta: Sequence[TerrainRunout] = ()
    zones: ZonedPath | None = None
    plan: PlanView | None = None

    @property
    def name(self) -> str:
        """How people call it."""
        return self.path.name or self.path.path_id

    @property
    def flow(self) -> FlowView | None:
        """What flow comes to on its terrain."""
        return self.plan.flow if self.plan else None

    @property
    def drawn_zones(self) -> list[Zone]:
        """Its zones, without those of no length."""
        zones = self.zones.zones if self.zones else ()
        return [zone for zone in zones if zone.to_x_m > zone.from_x_m]


def path_view(
    records: Records, path_id: str, smooth: SmoothProfile | None = None, **found: Any
) -> PathView:
    """A path of the records with its own events; `found` are further fields of `PathView`.

    `smooth` is its smoothed profile where that is known already.
    """
    own = of_path(records, path_id)
    for profile in own.profiles if smooth is None else ():
        smooth = smooth_profile(profile.x_m, profile.y_m, profile.elevation_sigma_m)
    path = own.paths[0]
    values: dict[str, Any] = {
        "release_x": None if smooth is None else release_place(smooth, path.release_elevation_m),
        "events": tuple(event_view(event, smooth) for event in own.events),
    }
    return PathView(path=path, smooth=smooth, **(values | found))


@dataclass(frozen=True, slots=True, eq=False)
class StateView:
    """What a model predicts for the records.

    `key` is its name in the page. `predicted` and `x` `[n_events, 3]` are the 5, 50 and 95 % of
    each record in its own coordinate and of its place (m), nan where nothing is predicted; `error`
    `[n_events]` (m) is predicted mean minus record as `compare` counts it. `rmse_m` and `crps_m`
    are in-sample, `held_out_m` is the held-out CRPS, None where it was never compared; `failed`
    `[n_events]` are the events of levels where the model fails beyond chance.
    """

    key: str
    predicted: Floats
    x: Floats
    error: Floats
    rmse_m: float
    crps_m: float
    held_out_m: float | None
    failed: Bools


@dataclass(frozen=True, slots=True, eq=False)
class ForceView:
    """The fitted resistance of an added effect on the motion over the state that it goes by.

    `x` and `y` `[n_points]`, with the standard deviation `sd`, are what resisted measured tracks
    beyond the rest of the model, in the unit of the shape; none without speeds. `event` are theirs.
    """

    shape: Shape
    event: Sequence[str]
    x: Floats
    y: Floats
    sd: Floats


@dataclass(frozen=True, slots=True, eq=False)
class SuspectView:
    """Partial residuals of the last added `effects`.

    `missed` `[n_events]` is the log friction that stops the record's block without them, less the
    law of the model with them; `explained` `[n_events]` what they add to it, with its 5 and 95 %
    (`band` `[2, n_events]`) where it is by columns of the events; nan where a record has no
    friction. `values` `[n_events]` are those of the `column` that the effect goes by; None without
    one. `force` is of an effect on the motion.
    """

    effects: tuple[str, ...]
    missed: Floats
    explained: Floats
    band: Floats | None
    column: str | None
    values: Sequence[float | str] | None
    force: ForceView | None


@dataclass(frozen=True, slots=True, eq=False)
class LoopView:
    """The model among those of the same records.

    `models` are the states of the models, oldest first. `comparisons` and `diagnoses` are those of
    the ladder by model, `lineage` the model and its ancestors, the first one first; `left_out` are
    models that are not shown, with the reason.
    """

    models: tuple[StateView, ...]
    lineage: tuple[str, ...]
    comparisons: Mapping[str, Comparison]
    diagnoses: Mapping[str, Diagnosis]
    left_out: Mapping[str, Note]
    suspect: SuspectView | None = None

    @property
    def before(self) -> StateView | None:
        """The model before the last step of the lineage, or the model itself where it is first."""
        known = {state.key: state for state in self.models}
        return known.get(self.lineage[-2] if len(self.lineage) > 1 else self.lineage[-1])


@dataclass(frozen=True, slots=True)
class Cover:
    """What a document is called, who wrote it, and of which place; empty where it is not said."""

    title: str = ""
    author: str = ""
    place: str = ""
    date: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class ReportContent:
    """All of a report.

    `draws` are posterior draws `[n_draws]` of the model's parameters. `comparison` and
    `diagnosis` are None where they were never made. `lacking` says by key what is missing from
    the report and how to get it, `of_model` what every output notes on the model. `physics` is what
    each effect means; `speed_limited` whether one of them holds speeds. `brief`: without the annex.
    """

    model: Calibration
    draws: Mapping[str, Floats]
    paths: tuple[PathView, ...]
    events: tuple[EventView, ...]
    n_speeds: int
    covariates: Mapping[str, int]
    friction: FrictionView | None
    densities: Sequence[FrictionDensity]
    summaries: Sequence[PathSummary]
    ladder: Sequence[LadderEntry]
    comparison: Comparison | None
    diagnosis: Diagnosis | None
    rows: Sequence[HazardRow]
    averages: Sequence[HazardRow]
    records_changed: bool
    of_model: tuple[Note, ...]
    calibrated_paths: Sequence[str]
    effect_sha256: str | None
    physics: Mapping[str, str]
    speed_limited: bool
    versions: Mapping[str, str]
    lacking: Mapping[str, Note]
    loop: LoopView
    cover: Cover = Cover()
    brief: bool = False

    @property
    def names(self) -> dict[str, str]:
        """How people call the paths, by their id."""
        return {view.path.path_id: view.name for view in self.paths}
