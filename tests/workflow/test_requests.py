"""The API takes what the requests do."""

from __future__ import annotations

from collections.abc import Callable
from inspect import Parameter, signature
from typing import Any

import pytest

from avahazard.api import Model, Region
from avahazard.request import Request
from avahazard.workflow.requests import (
    CalibrateRequest,
    DiagnoseRequest,
    HazardRequest,
    ReportRequest,
    VolumesRequest,
    ZonesRequest,
)


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
    taken = signature(method).parameters
    assert {n: p.default for n, p in asked.items()}.items() <= {
        n: p.default for n, p in taken.items() if p.kind is Parameter.KEYWORD_ONLY
    }.items()
