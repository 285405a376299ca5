"""Results made by hand, to be changed by `dataclasses.replace`."""

from __future__ import annotations

from avahazard.notes import Note
from avahazard.results.base import Rows
from avahazard.results.calibration import Calibration, Convergence
from avahazard.results.comparison import (
    Comparison,
    Failure,
    HeldOutScores,
    LadderEntry,
    MeasuredForce,
    RunoutScores,
    Scores,
    Standing,
)
from avahazard.results.diagnosis import Candidate, Diagnosis, GroupTest, Pair
from avahazard.results.friction import FrictionDensity, Frictions, PerturbationCheck
from avahazard.results.hazard import HazardRow, Spread

RUNOUT = RunoutScores(9, 70.0, 1.0, 40.0, 0.5, 0.9, 12.0, 7.0, (1,) * 9 + (0,))
FAILURE = Failure("volume", Note("above", edge=8e4, form=",.0f", unit=" m3"), 9, 63.0, 0.002)
FORCE = MeasuredForce("e1", 100.0, 12.0, 4.0, 0.5, 30.0)
COMPARISON = Comparison(
    model="base",
    coordinate="elevation",
    scores=Scores(RUNOUT, None, -50.0, 3.0, pareto_k_bad=0, pareto_k_refitted=0),
    held_out=HeldOutScores(RUNOUT, None, -55.0, 3.0, by="path"),
    where_it_fails=Rows([FAILURE]),
    speed_misfit=None,
    measured_force=None,
)
STANDING = Standing(70.0, 40.0, 72.0, 42.0, -55.0, -50.0, 3.0, 0.9, None, 12.0, 7.0)
LADDER_ENTRY = LadderEntry("base", None, (), 70.0, 40.0, 42.0, -50.0, 3.0, 0.9, None, 12.0, 8.0)
NOT_COMPARED = LadderEntry("new", None, (), *[None] * 9)
CANDIDATE = Candidate(
    effect="season",
    gain=30.0,
    evidence_gain=25.0,
    held_out_gain=20.0,
    p_value=0.005,
    screened_gain=30.0,
    chance_gain=2.0,
    p_value_alone=0.001,
    error_before_m=60.0,
    error_after_m=55.0,
    parameters={"season.slope": 0.1},
    physics="Wet snow slides farther.",
    confounded_with=(),
)
DIAGNOSIS = Diagnosis(
    model="base",
    verdict="adequate",
    missing=(),
    candidates=Rows(),
    pairs=Rows([Pair(("season", "snow-type"), 12.5, 6.0, 0.01, 60.0, {"season.slope": 0.1})]),
    groups=Rows([GroupTest("path-effect", 0.1, 0.7, 0.03)]),
    detectable_m=25.0,
    detectable_log_friction=0.05,
    measure_next=Rows(),
    still_needed={},
    heavy_tails=False,
    suspect_events=(),
    n_worlds=39,
    seed=0,
)
CALIBRATION = Calibration(
    model="m",
    parent=None,
    law="exponential",
    scatter="constant",
    distribution="lognormal",
    tails="normal",
    centrifugal=True,
    method="marginal",
    effects=(),
    n_events=12,
    left_out={},
    parameters={},
    diagnostics=Convergence(1.0021, 812.4, 800.0, 0.31, 0, True),
    chains=4,
    draws=100,
    seed=7,
    data_fingerprint="ab" * 32,
    notes=(),
)
FRICTIONS = Frictions(
    events=Rows(),
    density=Rows(
        [
            FrictionDensity(
                "all", 3, 40.0, (0.2, 0.3, 0.4), (1.0, 5.0, 1.0), (True, False, True), 0.3, 0.05
            )
        ]
    ),
    perturbation=PerturbationCheck(0, 0, None, None, None, {}),
)
SPREAD = Spread(1900.4, 1200.0, 1800.0, 2600.0)
NO_SPREAD = Spread(None, None, None, None)
HAZARD_ROW = HazardRow(
    path_id="p",
    return_period_years=None,
    volume_m3=123_456.0,
    runout_x_m=SPREAD,
    runout_elevation_m=SPREAD,
    runout_x_steps_m=(),
    interval="what varies",
    p_left_profile=0.0,
    p_not_released=0.0,
    n_draws=100,
    n_nonpositive_friction=0,
)
