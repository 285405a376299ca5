"""Names of what a model can be made of and calibrated by."""

from __future__ import annotations

from typing import Literal

ScatterName = Literal["constant", "volume"]
DistributionName = Literal["lognormal", "normal"]
TailsName = Literal["normal", "student"]
MethodName = Literal["marginal", "metropolis", "gibbs"]
