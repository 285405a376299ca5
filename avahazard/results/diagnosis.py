"""Which physical effect a model lacks."""

from dataclasses import field

from avahazard.notes import Note
from avahazard.results.base import ABSENT, Result, Rows
from avahazard.results.calibration import Kinds

LEVEL = 0.03
"""Family-wise level of the candidates. With those of groups, pairs and limits of detection it adds
up to 5 in 100 (Bonferroni)."""
MOST_MISSED = 0.5
"""Share of the scatter's variance that an effect may be and be missed, for an adequate model."""
FAR_BEHIND = 6.0
"""Evidence (nats) by which what may be missing is behind what leads, not to be added as well."""

FIELD_DAYS = {"runout": 1.0, "volume": 1.0, "speed": 2.0, "track": 3.0}
"""Days in the field to measure one avalanche, by what is measured: its speed at one place or along
the whole track. For who states none."""


class MeasuredAmount(Result):
    """An effect's first parameter, less its neutral value, as the measured force has it."""

    value: float
    se: float


class Declared(Result):
    """Effects that were expected before the records were asked, and when that was said (UTC)."""

    effects: tuple[str, ...]
    at: str


class Shape(Result):
    """A smooth of a state or a column (`of`, in `unit`) with its 90 % credible band at places `x`.

    `value` says what it is of: friction that is added, log friction, a force per mass, or drag. Of
    a column of texts it is at its `levels`, and `x` is empty.
    """

    of: str
    unit: str
    value: str
    x: tuple[float, ...]
    q05: tuple[float, ...]
    q50: tuple[float, ...]
    q95: tuple[float, ...]
    path: str | None = None
    levels: tuple[str, ...] | None = field(default=None, metadata=ABSENT)


class LawParameter(Result):
    """Posterior quantiles of a law's parameter."""

    q05: float
    q50: float
    q95: float
    unit: str


class FittedLaw(Result):
    """A law that a smooth may be, its formula in s, the state; `effect` names its effect file.

    `evidence` (nats) is over the model without it, `evidence_over_curve` over the smooth.
    """

    form: str
    effect: str
    formula: str
    parameters: dict[str, LawParameter]
    evidence: float
    evidence_over_curve: float = 0.0


class Candidate(Result):
    """One effect that could be missing.

    Gains are in nats of log likelihood (`gain`), of evidence with its price paid, and of records
    held-out; `p_value` is family-wise, `p_value_alone` by itself; `chance_gain` is exceeded in one
    of twenty datasets in which nothing is missing. What a full fit gives is None where it was not
    worth one. A smooth that was fitted has its `shape`, the leading one the `laws` that it may be,
    those within 3 nats of the first.
    """

    effect: str
    gain: float
    evidence_gain: float | None
    held_out_gain: float | None
    p_value: float
    screened_gain: float
    chance_gain: float
    p_value_alone: float
    error_before_m: float
    error_after_m: float | None
    parameters: dict[str, float]
    physics: str
    confounded_with: tuple[str, ...]
    force_witness: MeasuredAmount | None = None
    kinds: Kinds | None = None
    shape: Shape | None = field(default=None, metadata=ABSENT)
    laws: Rows[FittedLaw] | None = field(default=None, metadata=ABSENT)


class GroupTest(Result):
    """An effect on groups of events (paths, winters, storms), tested by itself beside the others.

    `gain` in nats; `spread` of the groups on log friction.
    """

    effect: str
    gain: float
    p_value: float
    spread: float


class Measurement(Result):
    """A measurement, the nats by which it distinguishes explanations, and its days in the field.

    `between` are the effects of these; where it is one, the other is the model itself. `path_id`
    and the place `x_m` along it are None where any will do.
    """

    measurement: Note
    expected_gain: float
    between: tuple[str, ...] = ()
    field_days: float | None = None
    path_id: str | None = None
    x_m: float | None = None


class Pair(Result):
    """Two effects, or three, that are needed together, and what they gain (nats).

    `gain` is over the model, `gain_over_best_single` over the best of them alone. `p_value` is the
    largest of theirs; of a pair of which neither shows alone, that among all pairs.
    """

    effects: tuple[str, ...]
    gain: float
    gain_over_best_single: float
    p_value: float
    error_after_m: float
    parameters: dict[str, float]


class Diagnosis(Result):
    """The verdict (`adequate`, `missing-effect`, `ambiguous`, `unexplained`) with its reasons.

    `missing` holds the effect, the set that cannot be distinguished, or the axis. `groups` are
    those that were let to differ before anything was blamed on physics. `pairs` are effects that
    are needed together, in the place of the one that is missing. An effect of `detectable_m` would
    have been detected with 80 % power; it would be `detectable_share` of the variance of log
    friction, that of the records' errors included (None: stored by a version without it).
    `still_needed` is the evidence (nats) that the model would lose without each of its effects;
    `suspect_events` are records hard to believe, `impossible_stops` those on ground too steep for
    any block to stop. `law_text` is the leading law as an effect file, `effect_file` where it was
    written; `given_files` are those of the user's own effects, by key.
    """

    model: str
    verdict: str
    missing: tuple[str, ...]
    candidates: Rows[Candidate]
    detectable_m: float
    detectable_log_friction: float
    measure_next: Rows[Measurement]
    still_needed: dict[str, float]
    heavy_tails: bool
    suspect_events: tuple[str, ...]
    n_worlds: int
    seed: int
    groups: Rows[GroupTest] = field(default_factory=Rows)
    pairs: Rows[Pair] = field(default_factory=Rows)
    impossible_stops: tuple[str, ...] = ()
    declared: Declared | None = None
    notes: tuple[Note, ...] = ()
    where: tuple[Note, ...] = ()
    coordinate: str = "elevation"
    detectable_share: float | None = None
    law_text: str | None = field(default=None, metadata=ABSENT)
    effect_file: str | None = field(default=None, metadata=ABSENT)
    given_files: dict[str, str] | None = field(default=None, metadata=ABSENT)
    next: Note | None = field(default=None, metadata=ABSENT)

    @property
    def named(self) -> tuple[str, ...]:
        """All keys that the verdict speaks of: what is missing, and what is needed together."""
        together = self.pairs[-1].effects if self.pairs else ()
        return tuple(dict.fromkeys((*self.missing, *together)))

    @property
    def near(self) -> list[str]:
        """What may be missing, without what has far less evidence than the rest."""
        evidence = {c.effect: c.evidence_gain for c in self.candidates}
        known = [nats for key in self.missing if (nats := evidence.get(key)) is not None]
        least = max(known, default=0.0) - FAR_BEHIND
        return [k for k in self.missing if (nats := evidence.get(k)) is None or nats > least]

    @property
    def lawful(self) -> Candidate | None:
        """The candidate of which laws were asked."""
        return next((c for c in self.candidates if c.laws), None)

    @property
    def leading_law(self) -> FittedLaw | None:
        """The first of them."""
        found = self.lawful
        return found.laws[0] if found and found.laws else None

    @property
    def effect_files(self) -> dict[str, str]:
        """The effect files that it knows of, by the key of their effect."""
        law = {self.leading_law.effect: self.effect_file} if self.leading_law else {}
        return {**(self.given_files or {}), **{key: file for key, file in law.items() if file}}

    @property
    def cannot_tell(self) -> bool:
        """Whether nothing was found where an effect behind half of the scatter could be missed."""
        share = self.detectable_share
        return self.verdict == "adequate" and share is not None and share > MOST_MISSED
