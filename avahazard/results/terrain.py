"""Paths: records, profiles, runs down them or over their terrain, and the runout by terrain."""

from dataclasses import field

from avahazard.notes import Note
from avahazard.results.base import ABSENT, Result, Rows


class PathSummary(Result):
    """A path, its profile's size (m), and its records; None where unknown."""

    path_id: str
    name: str | None
    section: str | None
    n_points: int
    top_m: float | None
    drop_m: float | None
    length_m: float | None
    n_events: int
    n_left_profile: int
    first_year: int | None
    last_year: int | None
    volume_min_m3: float | None
    volume_max_m3: float | None


class Stretch(Result):
    """A stretch of a path, x in m."""

    from_x_m: float
    to_x_m: float


class ProfileFit(Result, kw_only=True):
    """How a profile was regularised: `degree` of a polynomial, or `smoothing` of a spline.

    The error of the points `elevation_sigma_m` is given, estimated or assumed (`sigma_from`); their
    own scatter gives `sigma_estimate_m`, None where they are too few. `ground_sd_m` is the error of
    the ground that follows, `block_m` the length of the block that feels it.
    """

    method: str
    degree: int | None = field(default=None, metadata=ABSENT)
    smoothing: float | None = field(default=None, metadata=ABSENT)
    polynomial_rms_m: float
    rms_m: float
    max_deviation_m: float
    elevation_sigma_m: float
    sigma_from: str | None
    sigma_estimate_m: float | None
    ground_sd_m: float | None
    block_m: float


class PathCheck(Result):
    """One path, and whether the block's assumptions hold on it; lengths in m."""

    path_id: str
    n_points: int
    n_events: int
    fit: ProfileFit
    monotone: bool
    rises: Rows[Stretch]
    min_curvature_radius_m: float
    flow_length_m: float | None
    sharp_bends: Rows[Stretch]
    drop_m: float
    length_m: float
    notes: tuple[Note, ...]


class SpeedHere(Result):
    """Speed (m/s) of the block at a place (m)."""

    x_m: float
    speed_m_s: float


class RunoutAt(Result):
    """F(μ) and F'(μ) at one friction: where the block stops, m, and how that moves with μ.

    None where the block ran beyond the profile; no derivative where the block does not stop and
    within jumps.
    """

    mu: float
    runout_x_m: float | None
    runout_elevation_m: float | None
    status: str
    dx_dmu_m: float | None
    dy_dmu_m: float | None


class RunoutJump(Result):
    """A jump of F between two frictions of its table: none stops the block between the places."""

    mu_low: float
    mu_high: float
    from_x_m: float
    to_x_m: float


class Runout(Result, kw_only=True):
    """One run of the block: where it stops, and its speed on the way.

    `status` is stopped, left_profile or not_released; `lift_off_x_m` is where it first lost the
    ground. `table` and `jumps`, where they were asked for, are F(μ) under the same resistance.
    """

    path_id: str
    model: str | None = field(default=None, metadata=ABSENT)
    volume_m3: float | None = field(default=None, metadata=ABSENT)
    mu_from: str | None = field(default=None, metadata=ABSENT)
    mu: float
    status: str
    release_x_m: float
    release_elevation_m: float
    runout_x_m: float | None
    runout_elevation_m: float | None
    speed_max_m_s: float
    lift_off_x_m: float | None
    speeds: Rows[SpeedHere]
    table: Rows[RunoutAt] | None = field(default=None, metadata=ABSENT)
    jumps: Rows[RunoutJump] | None = field(default=None, metadata=ABSENT)
    notes: tuple[Note, ...] | None = field(default=None, metadata=ABSENT)


class TerrainRunout(Result):
    """The α-β runout of a path by one regression, the shorter of α + sd, the longer of α - sd."""

    path_id: str
    coefficients: str
    source: str
    status: str
    release_x_m: float
    beta_deg: float | None
    beta_x_m: float | None
    alpha_deg: float | None
    alpha_sd_deg: float
    runout_x_m: float | None
    runout_elevation_m: float | None
    runout_x_low_m: float | None
    runout_x_high_m: float | None
    notes: tuple[Note, ...]


PERIOD_COLORS = {300.0: "#56b4e9", 100.0: "#0072b2", 30.0: "#e69f00", 10.0: "#d55e00"}
"""Return periods (years) whose areas a map has, the largest area first, and their colours."""


class SimulatedPath(Result):
    """The runs of a path: how many there are, and were made now; over which ranges, and how far.

    The stops are the shortest and the longest (m along the line), None where nothing moved.
    `seconds` is what a run took, on average; `left` is how many passed the end of the line.
    """

    path_id: str
    engine: str
    n_runs: int
    n_new: int
    friction_min: float
    friction_max: float
    volume_min_m3: float
    volume_max_m3: float
    stop_min_x_m: float | None
    stop_max_x_m: float | None
    left: int
    seconds: float


class Simulations(Result):
    """The runs of all paths, with notes for people."""

    rows: Rows[SimulatedPath]
    notes: tuple[Note, ...] = ()


class SimulationPlan(Result):
    """What `simulate` takes before it refines; `measured`: from stored runs, not from cells."""

    n_runs: int
    n_done: int
    workers: int
    seconds_per_run: float
    measured: bool
    seconds: float
    stored_bytes: int


class MappedBy(Result):
    """A path of a map: by which engine, and its largest annual chance in a cell."""

    path_id: str
    engine: str
    n_runs: int
    chance_max: float


class ChanceMap(Result):
    """A map of annual chances that was written: its file, what it holds, and its paths."""

    model: str
    file: str
    crs: str
    cell_m: float
    bands: tuple[str, ...]
    paths: Rows[MappedBy]
    notes: tuple[Note, ...] = ()
