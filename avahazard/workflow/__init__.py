"""One file a use case. Most load slowly: from outside they load as they are used."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from avahazard.workflow import calibrate as calibrate
    from avahazard.workflow import compare as compare
    from avahazard.workflow import database as database
    from avahazard.workflow import diagnose as diagnose
    from avahazard.workflow import effects as effects
    from avahazard.workflow import export as export
    from avahazard.workflow import friction as friction
    from avahazard.workflow import hazard as hazard
    from avahazard.workflow import listing as listing
    from avahazard.workflow import path as path
    from avahazard.workflow import report as report
    from avahazard.workflow import stored as stored


def __getattr__(name: str) -> Any:
    if name.startswith("_"):
        raise AttributeError(name)
    return import_module(f"{__name__}.{name}")
