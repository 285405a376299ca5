"""Runs of the block for a model's effects, and the records to be expected from them."""

from __future__ import annotations

from copy import copy

from avahazard.effects.effect import Effect, MotionEffect, RecordEffect, of_kind
from avahazard.inference.likelihood.block_runs import BlockRuns, Values, run_blocks
from avahazard.inference.likelihood.keeping import make_room, within
from avahazard.inference.likelihood.predicted import Predicted, predict_records
from avahazard.inference.likelihood.stops_asked import stops_asked
from avahazard.inference.model.observations import Observations
from avahazard.physics.near_stops import Asked
from avahazard.physics.runout_curve import MU

KEPT_RUNS = 64
"""Runs of the block (several MB each)."""
KEPT_ASKED = 16
"""Values of effects on the record for which it is kept where blocks must stop."""
RUN_BYTES = 17 * len(MU)
"""Bytes of one curve of a run (x, elevation, status)."""


class KeptRuns:
    """Runs on the sites of observations; `curvature` is that of `run_blocks`.

    Without a motion among the effects, or with a limit of sight (not `in_sight`), blocks are run
    over all frictions wherever their records lie.
    """

    def __init__(
        self,
        observations: Observations,
        effects: tuple[Effect, ...],
        curvature: float,
        in_sight: bool,
    ) -> None:
        self._observations = observations
        self._effects = effects
        self._curvature = curvature
        self._moving = of_kind(effects, MotionEffect)
        # What sight is limited of is looked at over all frictions.
        self._near = in_sight and len(self._moving) > 0
        self._runs: dict[tuple[bytes, ...], BlockRuns] = {}
        self._asked: dict[tuple[bytes, ...], tuple[Asked, ...]] = {}

    def emptied(self) -> KeptRuns:
        """The same without the runs kept so far, which hold much memory."""
        other = copy(self)
        other._runs = {}
        return other

    def records(self, values: Values, moved: Values | None = None) -> Predicted:
        """Tables of expected records at these values, of a block that moves as at `moved`."""
        return self._predicted(values, self._block_runs(values if moved is None else moved))

    def fresh_records(self, values: Values) -> Predicted:
        """The same; where blocks move by the values, they are run afresh and not kept."""
        return self._predicted(values, None if self._moving else self._block_runs(values))

    def near_records(self, values: Values) -> Predicted:
        """Tables of expected records, which nodes are made of: right near the records alone."""
        return self._predicted(
            values, self._near_runs(values) if self._near else self._block_runs(values)
        )

    def _block_runs(self, values: Values) -> BlockRuns:
        """Runs of the block, kept: effects on the record alone leave them as they are."""
        key = tuple(values[effect.key].tobytes() for effect in self._moving)
        if key not in self._runs:
            n_curves = sum(len(site.release_x) for site in self._observations.sites)
            n_speeds = sum(len(track.x) for track in self._observations.speeds)
            size = n_curves * RUN_BYTES + n_speeds * 8 * len(MU)
            make_room(self._runs, within(KEPT_RUNS, size))
            self._runs[key] = run_blocks(self._observations, self._effects, values, self._curvature)
        return self._runs[key]

    def _predicted(self, values: Values, runs: BlockRuns | None) -> Predicted:
        return predict_records(self._observations, self._effects, values, self._curvature, runs)

    def _near_runs(self, values: Values) -> BlockRuns:
        """Runs of the block near the records; not kept, as nodes are."""
        on_record = of_kind(self._effects, RecordEffect)
        key = tuple(values[e.key].tobytes() for e in on_record)
        if key not in self._asked:
            make_room(self._asked, KEPT_ASKED)
            self._asked[key] = stops_asked(self._observations, self._effects, values)
        runs = run_blocks(
            self._observations, self._effects, values, self._curvature, self._asked[key]
        )
        assert runs.middle is not None
        # The next place is near this one, and so are its frictions.
        self._asked[key] = tuple(
            asked._replace(middle=middle)
            for asked, middle in zip(self._asked[key], runs.middle, strict=True)
        )
        return runs
