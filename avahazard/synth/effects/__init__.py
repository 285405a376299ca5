"""Every effect as a world shows it, by key.

An effect is a function of the world and a strength. It changes the world in place and
returns its true parameters. Strength 0 is no effect; at 1 it is plain to see with 250 events
on 10 paths.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from avahazard.records.errors import AvahazardError
from avahazard.synth.effects import friction, motion, observation
from avahazard.synth.world import World

Parameters = dict[str, object]
WorldEffect = Callable[[World, float], Parameters]

CATALOGUE: Mapping[str, WorldEffect] = {
    "centrifugal": motion.centrifugal,
    "turbulent-drag": motion.turbulent_drag,
    "speed-weakening": motion.speed_weakening,
    "cohesion": motion.cohesion,
    "entrainment": motion.entrainment,
    "forest-drag": motion.forest_drag,
    "volume-law": friction.volume_law,
    "volume-scatter": friction.volume_scatter,
    "snow-type": friction.snow_type,
    "path-section": friction.path_section,
    "release-elevation": friction.release_elevation,
    "season": friction.season,
    "path-effect": friction.path_effect,
    "observation-limit": observation.observation_limit,
    "epoch-bias": observation.epoch_bias,
    "leading-edge": observation.leading_edge,
}
NEED_SPEEDS = frozenset({"centrifugal", "speed-weakening", "cohesion"})


def find_effect(key: str) -> WorldEffect:
    """The effect of a key; `covariate:COLUMN` for any column.

    Raises AvahazardError when there is none.
    """
    if key.startswith("covariate:") and len(key) > len("covariate:"):
        return friction.covariate(key.partition(":")[2])
    if key not in CATALOGUE:
        raise AvahazardError(
            f"There is no effect {key!r}.",
            f"Use one of: {', '.join(CATALOGUE)}, covariate:COLUMN.",
        )
    return CATALOGUE[key]
