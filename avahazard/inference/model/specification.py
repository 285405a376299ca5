"""What a model is made of, apart from its data."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from avahazard.effects.effect import Definition, Setting
from avahazard.inference.model.choices import DistributionName, ScatterName, TailsName
from avahazard.inference.model.priors import GivenPrior, LawPrior


@dataclass(frozen=True, slots=True)
class Specification:
    """A friction law (of `laws.LAWS`) with its scatter and the effects added to the block.

    `distribution` is that of friction given volume; `tails` `student` lets friction scatter as
    Student's t with 4 degrees of freedom, which bears wrong records. `centrifugal` keeps the
    load of curvature on the bed. `reference_volume_m3` scales the coordinate of a scatter that
    changes with volume; it is taken from the data of the calibration. `prior` is that of the law,
    from other records or from numbers; None for the law's own weak one. `given` are the numbers,
    of parameters of the law and others.
    """

    law: str = "exponential"
    scatter: ScatterName = "constant"
    distribution: DistributionName = "lognormal"
    tails: TailsName = "normal"
    effects: tuple[str, ...] = ()
    centrifugal: bool = True
    reference_volume_m3: float = 1e5
    prior: LawPrior | None = None
    given: tuple[GivenPrior, ...] = ()

    def has(self, effect: Definition) -> bool:
        """Whether the effect is there, added or as a setting."""
        setting = effect.changes
        if setting is not None and setting.value is not None and self.of(setting) == setting.value:
            return True
        return effect.key in self.effects

    def of(self, setting: Setting) -> Any:
        """The present value of a setting."""
        return getattr(self, setting.field)

    def put(self, setting: Setting, value: Any) -> Specification:
        """The specification with another value of a setting."""
        return replace(self, **{setting.field: value})
