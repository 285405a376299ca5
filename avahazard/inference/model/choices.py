"""Names of what a model can be made of and calibrated by."""

from collections.abc import Mapping
from typing import Literal, NamedTuple

ScatterName = Literal["constant", "volume"]
DistributionName = Literal["lognormal", "normal"]
TailsName = Literal["normal", "student"]
MethodName = Literal["marginal", "metropolis", "gibbs"]
ForwardName = Literal["block", "com1dfa"]
BLOCK: ForwardName = "block"


class Method(NamedTuple):
    """What a method of calibration is to the rest of the program.

    `words` name it in a sentence. `n_draws`: draws of each chain where the user names none.
    `knows_errors`: it accounts for the errors of records, and so has a likelihood in which effects
    can be tested. `in_metres`: what scatters is the stop's elevation, not friction.
    """

    words: str
    n_draws: int
    knows_errors: bool = False
    in_metres: bool = False


# The draws of the marginal method are nearly independent.
METHODS: Mapping[str, Method] = {
    "marginal": Method(
        "the marginal likelihood, which accounts for measurement error",
        n_draws=1000,
        knows_errors=True,
    ),
    "metropolis": Method(
        "the Metropolis-Hastings sampler of Ancey (2005)", n_draws=5000, in_metres=True
    ),
    "gibbs": Method("the Gibbs sampler of Ancey (2005)", n_draws=5000),
}
DEFAULT_METHOD: MethodName = "marginal"
