"""What bounds are wanted of: a volume on a path, or a return period and the volume of that."""

from __future__ import annotations

from dataclasses import dataclass

from avahazard.hazard.event_volumes import ANY_VOLUME_M3
from avahazard.hazard.volume_frequency import VolumeFrequency
from avahazard.results.volumes import ReturnLevel


@dataclass(frozen=True, slots=True)
class Scenario:
    """A row of `hazard` to come.

    `volume_m3` is None where the model has no use for it and nothing is known of it;
    `return_period` (years) is None for a volume that the user gave, and `returned` and
    `frequency`, the volume of the period and where it comes from, where they are not known.
    """

    path_id: str
    volume_m3: float | None
    return_period: float | None = None
    returned: ReturnLevel | None = None
    frequency: VolumeFrequency | None = None

    @property
    def any_volume_m3(self) -> float:
        """The volume, or one that stands for it where it does not matter."""
        return ANY_VOLUME_M3 if self.volume_m3 is None else self.volume_m3
