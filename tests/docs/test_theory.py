"""The theory pages give the numbers that the program uses."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import pytest

THEORY = Path(__file__).resolve().parents[2] / "docs" / "theory"

CONSTANTS = [
    ("motion", "degree 8", "physics.smooth_profile", "DEGREE", 8),
    ("motion", "λ = 1e-4", "physics.smooth_profile", "PENALTY", 1e-4),
    ("motion", "L = 100 m", "physics.smooth_profile", "BLOCK_M", 100.0),
    ("motion", "a tenth of the path", "physics.smooth_profile", "BLOCK_SHARE", 0.1),
    ("motion", "at least 0.1 m", "physics.smooth_profile", "FINEST_M", 0.1),
    ("motion", "fewer than 15 points", "physics.smooth_profile", "FEWEST_POINTS", 15),
    ("motion", "fourth differences", "physics.smooth_profile", "DIFFERENCES", 4),
    ("motion", "powers of μ up to the sixth", "physics.cells", "ORDER", 6),
    ("motion", "longer than 20 m", "physics.terrain", "MAX_CELL_M", 20.0),
    ("motion", "more than 0.05 rad", "physics.terrain", "MAX_TURN", 0.05),
    ("motion", "by 0.0025", "physics.runout_curve", "MU_STEP", 0.0025),
    ("motion", "more than 5 times as far", "physics.runout_curve", "JUMP_FACTOR", 5.0),
    ("likelihood", "by the 10 nodes", "inference.likelihood.quadrature", "N_NODES", 10),
    (
        "likelihood",
        "log 0.02 ± 1, cut to 0.001 to 0.4",
        "inference.model.layout",
        "WRONG_SHARE",
        0.02,
    ),
    ("likelihood", "averaged over 11", "inference.model.volumes", "N_NODES", 11),
    (
        "likelihood",
        "100\\,\\mathrm{m}",
        "inference.model.observations",
        "FRICTION_CORRELATION_M",
        100.0,
    ),
    ("likelihood", "log 0.15 ± 1", "inference.model.layout", "SCATTER_CENTRE", 0.15),
    ("likelihood", "scale 0.2", "effects.groups", "SPREAD", 0.2),
    ("likelihood", "log 0.075 ± 1", "inference.model.layout", "TRACK_SCATTER", 0.075),
    ("likelihood", "κ = 5", "inference.paper.apparent", "DEFAULT_KAPPA", 5.0),
    ("hazard", "8 equally probable", "hazard.future_events", "N_RELEASES", 8),
    ("hazard", "flattens to 10°", "hazard.alpha_beta", "BETA_SLOPE_DEG", 10.0),
    ("criticism", "k > 0.7", "criticism.scoring.loo", "BAD_K", 0.7),
    ("criticism", "three or more", "criticism.scoring.held_out", "MIN_PATHS", 3),
    ("criticism", "more than 24 paths", "criticism.scoring.held_out", "MAX_FITS", 24),
    ("criticism", "at least 20 m", "criticism.scoring.speed_misfit", "MIN_PIECE_M", 20.0),
    ("criticism", "p ≤ 0.03", "criticism.screening.screen", "LEVEL", 0.03),
    ("criticism", "0.3 % for paths", "criticism.diagnosis.full_fits", "PERSISTENT_LEVEL", 0.003),
    ("criticism", "0.1 % each", "criticism.diagnosis.full_fits", "TRANSIENT_LEVEL", 0.001),
    ("criticism", "its own at 0.3 %", "effects.record", "DETECTION_LEVEL", 0.003),
    ("criticism", "their own at 0.5 %", "effects.groups", "KINDS_LEVEL", 0.005),
    ("criticism", "its own, 0.5 %", "criticism.screening.screen", "PAIR_LEVEL", 0.005),
    ("criticism", "the 300 most correlated", "criticism.screening.screen", "MOST_PAIRS", 300),
    ("criticism", "At most 7 candidates", "criticism.diagnosis.full_fits", "FITTED", 7),
    ("criticism", "At most 4 forms", "criticism.diagnosis.laws", "FITTED", 4),
    ("criticism", "at 10 places", "criticism.diagnosis.laws", "PLACES", 10),
    ("criticism", "So are three", "criticism.diagnosis.full_fits", "BY_PATH", 3),
    ("criticism", "up to 40 dates", "effects.change", "MOST_DATES", 40),
    ("criticism", "nearby within 3 days", "effects.columns", "NEARBY_DAYS", 3),
    ("criticism", "more than 0.5 nats", "criticism.diagnosis.nuisances", "ASKED_FOR", 0.5),
    ("likelihood", "within 3 days", "effects.groups", "DAYS", 3),
    ("criticism", "within 3 nats", "criticism.diagnosis.naming", "MARGIN", 3.0),
    ("criticism", "above 0.7", "criticism.diagnosis.diagnose", "ALIKE", 0.7),
    ("criticism", "at one of 8 places", "criticism.diagnosis.measurements", "N_PLACES", 8),
    ("criticism", "for 3 of", "criticism.diagnosis.measurements", "N_TRACKS", 3),
    ("criticism", "8 draws of", "criticism.diagnosis.measurements", "N_DRAWS", 8),
    ("criticism", "than 0.05 nats", "criticism.diagnosis.measurements", "LEAST_GAIN", 0.05),
    ("criticism", "surveyed to 10 %", "criticism.diagnosis.measurements", "VOLUME_SIGMA", 0.1),
    ("criticism", "three best explanations", "criticism.diagnosis.diagnose", "EXPLANATIONS", 3),
    ("criticism", "1.5 m/s", "criticism.diagnosis.measurements", "SPEED_SIGMA_M_S", 1.5),
]


@pytest.mark.parametrize(("page", "words", "module", "name", "value"), CONSTANTS)
def test_constants(page: str, words: str, module: str, name: str, value: float) -> None:
    assert getattr(import_module(f"avahazard.{module}"), name) == value
    text = (THEORY / f"{page}.md").read_text(encoding="utf-8")
    assert words in " ".join(text.split())


def test_regressions_of_alpha_on_beta() -> None:
    from avahazard.hazard.alpha_beta import REGRESSIONS  # noqa: PLC0415

    text = (THEORY / "hazard.md").read_text(encoding="utf-8")
    for r in REGRESSIONS:
        assert f"| {r.slope:g} β - {-r.intercept_deg:g}° | {r.sd_deg:g}° |" in text
