"""What a diagnosis found: the verdict with all that it rests on."""

from __future__ import annotations

from dataclasses import dataclass

from avahazard.criticism.diagnosis.detectable import Detectable
from avahazard.criticism.diagnosis.force_witness import ForceWitness
from avahazard.criticism.diagnosis.refits import Refit
from avahazard.criticism.diagnosis.together import Together
from avahazard.criticism.screening.significance import Screened, Screening


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """One candidate, screened.

    With its full refit if it survived, and the evidence (nats) that it adds.
    """

    screened: Screened
    fit: Refit | None
    evidence_gain: float | None
    error_after_m: float | None
    held_out_gain: float | None
    confounded_with: tuple[str, ...]
    force_witness: ForceWitness | None

    @property
    def key(self) -> str:
        """The effect's key."""
        return self.screened.key


@dataclass(frozen=True, slots=True, eq=False)
class Diagnosis:
    """The verdict with all that it rests on; `base` is the model with the nuisances.

    `not_asked` holds, by key, what a column of the records lacks for its effect to be asked about.
    """

    verdict: str
    missing: tuple[str, ...]
    candidates: tuple[Candidate, ...]
    base: Refit
    screening: Screening
    error_before_m: float
    still_needed: dict[str, float]
    not_granted: tuple[str, ...]
    not_asked: dict[str, str]
    heavy_tails: bool
    detectable: Detectable
    suspects: tuple[str, ...]
    together: tuple[Together, ...]
    impossible_stops: tuple[str, ...]
