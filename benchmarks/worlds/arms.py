"""Which worlds the benchmark makes: arms, sizes, strengths, seeds."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import zip_longest
from math import ceil

from avahazard.synth.effects import CATALOGUE
from avahazard.synth.world import Settings
from benchmarks.worlds.outside import AXES

LARGE, SMALL = (250, 11), (120, 9)
"""Events and paths of the even and the odd worlds of an arm."""
NULLS_PER_ARM = 5
"""Nulls of each arm for one world of an effect and strength."""
FIRST_SEED, FIRST_TRAP_SEED, FINAL_SEED = 40_000, 500_000, 800_000
"""Seeds of the worlds, a thousand for each arm; of the final ones none was looked at before."""
FURTHER, FURTHER_AFTER, N_FURTHER = "volume errors", 50, 100
"""The trap in which an earlier version named 11 of 150 nulls falsely, and how many more are made
than of the others."""
FINAL_EFFECT = "observation-limit"
"""An effect that is made with the final seeds too."""
SETTLED_SEED = 950_000
"""Seeds of its worlds that are judged by what who is told the limits gains, settled beforehand."""
PLAIN = Settings()


@dataclass(frozen=True, slots=True)
class Plan:
    """One world: `effects` are in it, `true` are the answers that are right, `neutral` those that
    are no false alarm. `outside` names a file of benchmarks/outside; `speeds_later` asks again
    with speeds measured; `wrong` is a needless effect to add; `stated` are errors of the events
    that are stated otherwise than they are."""

    arm: str
    index: int
    seed: int
    n_events: int
    n_paths: int
    effects: dict[str, float] = field(default_factory=dict)
    settings: Settings = PLAIN
    true: tuple[str, ...] = ()
    neutral: tuple[str, ...] = ()
    outside: str | None = None
    speeds_later: bool = False
    wrong: str | None = None
    stated: dict[str, float] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The world by name, by which a finished one is known."""
        return f"{self.arm} #{self.index}"


PATHS = ("path-effect",)


@dataclass(frozen=True, slots=True)
class Trap:
    """A trap of `traps.TRAPS`, or of the settings: `neutral` names are no false alarm."""

    effects: dict[str, float] = field(default_factory=dict)
    settings: Settings = PLAIN
    n_paths: int | None = None
    stated: dict[str, float] = field(default_factory=dict)
    neutral: tuple[str, ...] = ()


NULLS: dict[str, tuple[dict[str, float], Settings, tuple[str, ...]]] = {
    "null: plain": ({}, Settings(), ()),
    "null: path effect": ({"path-effect": 1.0}, Settings(), ("path-effect",)),
    "null: heavy tails": ({}, Settings(student_df=4.0, wrong_share=0.02), ()),
    "null: scatter by volume": ({"volume-scatter": 1.0}, Settings(), ("volume-scatter",)),
    "null: censored": ({}, Settings(censored_share=0.3), ()),
    "null: decoy columns": ({}, Settings(decoys=8), ()),
}
PAIRS = (
    ("snow-type", "path-section"),
    ("turbulent-drag", "season"),
    ("release-elevation", "epoch-bias"),
    ("forest-drag", "snow-type"),
    ("leading-edge", "season"),
    ("volume-scatter", "snow-type"),
)
CONFOUNDED: dict[str, tuple[dict[str, float], Settings, bool]] = {
    "confounded: drag, no speeds": ({"turbulent-drag": 1.0}, Settings(speeds=0.0), True),
    "confounded: entrainment, no speeds": ({"entrainment": 1.0}, Settings(speeds=0.0), True),
    "confounded: cohesion, no speeds": ({"cohesion": 1.0}, Settings(speeds=0.0), True),
    "confounded: weakening, no speeds": ({"speed-weakening": 1.0}, Settings(speeds=0.0), True),
    "confounded: elevation, proxy": ({"proxy": 0.0, "release-elevation": 1.0}, Settings(), False),
}
TRAPS: dict[str, Trap] = {
    "storms": Trap({"storms": 1.0}, neutral=("storm-effect", "winter-effect")),
    "winters": Trap({"winters": 1.0}, neutral=("winter-effect",)),
    "2 paths": Trap({"path-effect": 1.0, "path columns": 1.0}, n_paths=2, neutral=PATHS),
    "3 paths": Trap({"path-effect": 1.0, "path columns": 1.0}, n_paths=3, neutral=PATHS),
    "4 paths": Trap({"path-effect": 1.0, "path columns": 1.0}, n_paths=4, neutral=PATHS),
    "volume errors": Trap(
        settings=Settings(volume_rel_sigma=1.0),
        stated={"volume_rel_sigma": 0.3},
        neutral=("volume-error",),
    ),
    "record errors": Trap(stated={"runout_sigma_m": 5.0}, neutral=("record-error",)),
    "gross errors": Trap(settings=Settings(wrong_share=0.3)),
    "declared limits": Trap(settings=Settings(censored_share=0.3)),
}
"""What real records do, with nothing else and with one effect."""
TRAP_NULLS = 2.5
"""Nulls of a trap for one world of an effect and strength."""
TRAPPED = "snow-type"
WRONG = ("turbulent-drag", "forest-drag", "snow-type", "season", "leading-edge", "epoch-bias")


def plans(size: int) -> list[Plan]:
    """All worlds: `size` for each effect and strength, `NULLS_PER_ARM` times as many nulls of an
    arm. They come in `size` rounds of all arms, so that a run that is cut short has seen all."""
    return _in_rounds(_all_arms(size), size)


def final_worlds(size: int) -> list[Plan]:
    """The worlds with a trap, and of `FINAL_EFFECT`, with seeds on which no rule was made."""
    arms = _traps(0, size, FINAL_SEED)
    return _in_rounds(arms + _final_effect(size, FINAL_SEED + 1000 * len(arms)), size)


def settled_worlds(size: int) -> list[Plan]:
    """Worlds of `FINAL_EFFECT` alone, with seeds of their own."""
    return _in_rounds(_final_effect(size, SETTLED_SEED), size)


def further_nulls() -> list[Plan]:
    """More nulls of the trap `FURTHER`, with the final seeds."""
    n = FURTHER_AFTER + N_FURTHER
    arms = _traps(0, ceil(n / TRAP_NULLS), FINAL_SEED)
    (arm,) = (arm for arm in arms if arm[0].arm == f"null: {FURTHER}")
    return arm[FURTHER_AFTER:n]


def _final_effect(size: int, first_seed: int) -> list[list[Plan]]:
    """`FINAL_EFFECT` of full and of half strength."""
    arms: list[list[Plan]] = []
    for strength in (1.0, 0.5):
        arm = next(a for a in _effects(strength, 0, size) if a[0].true == (FINAL_EFFECT,))
        seed = first_seed + 1000 * len(arms)
        arms.append([replace(world, seed=seed + k) for k, world in enumerate(arm)])
    return arms


def _all_arms(size: int) -> list[list[Plan]]:
    arms: list[list[Plan]] = []
    for name, (effects, settings, neutral) in NULLS.items():
        arms.append(
            [
                _plan(len(arms), name, k, effects, settings=settings, neutral=neutral)
                for k in range(NULLS_PER_ARM * size)
            ]
        )
    arms += _effects(1.0, len(arms), size)
    for pair in PAIRS:
        effects = dict.fromkeys(pair, 1.0)
        name = f"pair: {' + '.join(pair)}"
        arms.append([_plan(len(arms), name, k, effects, true=pair) for k in range(size)])
    for name, (effects, settings, later) in CONFOUNDED.items():
        true = tuple(k for k in effects if k != "proxy")
        arms.append(
            [
                _plan(
                    len(arms), name, 2 * k, effects, settings=settings, true=true,
                    speeds_later=later,
                )
                for k in range(size)
            ]
        )  # fmt: skip
    for name, axis in AXES.items():
        arms.append(
            [
                _plan(len(arms), f"outside: {name}", k, {name: 1.0}, true=(axis,), outside=name)
                for k in range(2 * size)
            ]
        )
    arms.append(
        [
            _plan(len(arms), "wrong effect", k, {}, wrong=WRONG[k % len(WRONG)])
            for k in range(3 * size)
        ]
    )
    arms += _effects(0.5, len(arms), size)
    arms += _traps(len(arms), size, FIRST_TRAP_SEED)
    return arms


def _in_rounds(arms: list[list[Plan]], size: int) -> list[Plan]:
    rounds = ([arm[_share(arm, k, size)] for arm in arms] for k in range(size))
    turns = (turn for parts in rounds for turn in zip_longest(*parts))
    return [world for turn in turns for world in turn if world is not None]


def _share(arm: list[Plan], k: int, size: int) -> slice:
    """What an arm gives to round k."""
    return slice(k * len(arm) // size, (k + 1) * len(arm) // size)


def _effects(strength: float, first: int, size: int) -> list[list[Plan]]:
    """An arm for every effect of the catalogue, and a covariate, at one strength."""
    return [
        [
            _plan(
                first + j, f"{key} x {strength:g}", k, {key: strength},
                true=(key,), neutral=("path-effect",),
            )
            for k in range(size)
        ]
        for j, key in enumerate((*CATALOGUE, "covariate:new_snow_cm"))
    ]  # fmt: skip


def _traps(first: int, size: int, first_seed: int) -> list[list[Plan]]:
    """Two arms for every trap: with no effect, and with one."""
    arms = []
    for name, trap in TRAPS.items():
        for effects, n in (({}, int(TRAP_NULLS * size)), ({TRAPPED: 1.0}, size)):
            arm = f"trap: {name} + {TRAPPED}" if effects else f"null: {name}"
            worlds = [
                _plan(
                    first + len(arms), arm, k, {**trap.effects, **effects}, settings=trap.settings,
                    true=tuple(effects), neutral=trap.neutral, stated=trap.stated,
                )
                for k in range(n)
            ]  # fmt: skip
            seed = first_seed + 1000 * len(arms)
            arms.append(
                [
                    replace(w, n_paths=trap.n_paths or w.n_paths, seed=seed + k)
                    for k, w in enumerate(worlds)
                ]
            )
    return arms


def _plan(  # type: ignore[no-untyped-def]
    arm: int, name: str, index: int, effects: dict[str, float], **others
) -> Plan:
    n_events, n_paths = SMALL if index % 2 else LARGE
    return Plan(name, index, FIRST_SEED + 1000 * arm + index, n_events, n_paths, effects, **others)
