"""The API takes what the requests do."""

from __future__ import annotations

from collections.abc import Callable
from inspect import Parameter, signature
from typing import Any

import pytest

from avahazard.api.model import Model
from avahazard.api.region import Region
from avahazard.request import Request
from avahazard.workflow.requests import (
    CalibrateRequest,
    DiagnoseRequest,
    HazardRequest,
    ReportRequest,
    VolumesRequest,
    ZonesRequest,
)

OF_THE_MODEL = {"effect_files"}
WITH_A_PICTURE_BY_PLOT = {"plot"}


@pytest.mark.parametrize(
    ("method", "request_class"),
    [
        (Region.calibrate, CalibrateRequest),
        (Region.volumes, VolumesRequest),
        (Model.diagnose, DiagnoseRequest),
        (Model.hazard, HazardRequest),
        (Model.zones, ZonesRequest),
        (Model.report, ReportRequest),
    ],
)
def test_names_and_defaults_are_those_of_the_request(
    method: Callable[..., Any], request_class: type[Request]
) -> None:
    asked = signature(request_class).parameters
    taken = {
        name: parameter.default
        for name, parameter in signature(method).parameters.items()
        if parameter.kind is Parameter.KEYWORD_ONLY and name in asked
    }
    without = OF_THE_MODEL | (set() if "plot" in taken else WITH_A_PICTURE_BY_PLOT)
    assert taken.keys() == asked.keys() - without
    empty = request_class()
    assert {n: v or None for n, v in taken.items()} == {n: getattr(empty, n) or None for n in taken}
