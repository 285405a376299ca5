"""Monte Carlo hazard mapping for avalanche paths, after Ancey (2005).

>>> import avahazard as av
>>> av.open(database).calibrate("first", chains=2, draws=100).result.n_events
60
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from avahazard.api import Model as Model
    from avahazard.api import Region as Region
    from avahazard.api import open_region as open
    from avahazard.hazard.volume_source import VolumeSource
    from avahazard.records.errors import AvahazardError as AvahazardError
    from avahazard.records.errors import RejectedRows as RejectedRows

__version__ = "1.0.0"

PUBLIC = {
    "open": ("avahazard.api", "open_region"),
    "Region": ("avahazard.api", "Region"),
    "Model": ("avahazard.api", "Model"),
    "VolumeSource": ("avahazard.hazard.volume_source", "VolumeSource"),
    "AvahazardError": ("avahazard.records.errors", "AvahazardError"),
    "RejectedRows": ("avahazard.records.errors", "RejectedRows"),
}
"""Public names, and where they are; they load when they are used."""
__all__ = ["AvahazardError", "Model", "Region", "RejectedRows", "VolumeSource", "open"]


def __getattr__(name: str) -> Any:
    if name not in PUBLIC:
        raise AttributeError(f"module 'avahazard' has no attribute '{name}'")
    module, attribute = PUBLIC[name]
    return getattr(import_module(module), attribute)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
