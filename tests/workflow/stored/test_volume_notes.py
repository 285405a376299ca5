"""What is said where true volumes are not taken for lognormal."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.inference.model.volume_shape import VolumeShape
from avahazard.inference.model.volumes import VolumeNodes, bounded, rescaled
from avahazard.inference.prediction.fitted_model import FittedModel, exact_volumes, fitted_model
from avahazard.workflow.stored.volume_notes import volume_notes
from tests.inference import studies

SHAPE = VolumeShape(np.linspace(-3.0, 3.0, 25), -np.abs(np.linspace(-3.0, 3.0, 25)))


def _model(volumes: VolumeNodes, law: str = "exponential") -> FittedModel:
    observations = replace(studies.observations(), volumes=volumes)
    posterior = studies.posterior(observations, law=law)
    return fitted_model(posterior, studies.near(posterior)[None], {})


def _shaped(volumes: VolumeNodes) -> VolumeNodes:
    """The same with a population of that shape."""
    return rescaled(replace(volumes, population=replace(volumes.population, shape=SHAPE)), 1.5)


def test_of_lognormal_volumes_nothing_is_said() -> None:
    assert volume_notes(_model(studies.observations().volumes), "m") == ()


def test_the_largest_volume_is_told() -> None:
    (note,) = volume_notes(_model(bounded(studies.observations().volumes, 812345.0)), "m")
    assert note.startswith("m takes no true volume for larger than 810000 m3")


def test_a_shape_of_its_own_is_told() -> None:
    (note,) = volume_notes(_model(_shaped(studies.observations().volumes)), "m")
    assert note.startswith("m does not take true volumes for lognormal")


@pytest.mark.parametrize("change", [_shaped, lambda volumes: bounded(volumes, 1e6)])
def test_where_volumes_do_not_count_or_have_no_error_nothing_is_said(change) -> None:  # type: ignore[no-untyped-def]
    volumes = change(studies.observations().volumes)
    assert volume_notes(_model(volumes, "constant"), "m") == ()
    observations = studies.observations()
    all_known = np.nan_to_num(observations.columns.log_volume, nan=10.0)
    columns = replace(observations.columns, log_volume=all_known)
    known = replace(observations, columns=columns, volumes=volumes)
    assert volume_notes(_model(exact_volumes(known)), "m") == ()
