"""What the command line and the report say in sentences: of a model's error, its verdict."""

import math

from avahazard.report.language import plural, say, spoken
from avahazard.report.model_tables import failing, failing_speeds
from avahazard.report.tables import NO_NAMES, Names
from avahazard.report.words import (
    amount,
    axis_text,
    chance,
    coordinate_text,
    digits,
    events,
    in_unit,
    level_text,
    share,
    some,
)
from avahazard.results.calibration import Kinds
from avahazard.results.comparison import BeforeAndAfter, Comparison
from avahazard.results.diagnosis import Diagnosis


def kinds_text(kinds: Kinds) -> list[str]:
    """How many avalanches are of a second kind, how it differs, and what goes with it."""
    words = say(
        "{share} of the avalanches are of a second kind that no column records: their friction "
        "is {factor} times that of the others. {n} of {events} are more likely of it than not.",
        share=share(kinds.share),
        factor=digits(math.exp(kinds.shift), ".2f"),
        n=sum(p > 0.5 for p in kinds.probability.values()),
        events=events(len(kinds.probability)),
    )
    columns = [
        f"{axis_text(row.column)}"
        f"{f' = {level_text(row.level)}' if row.level else ''} "
        f"({digits(row.correlation, '+.2f')})"
        for row in kinds.in_common
    ]
    found = spoken().listed(columns)
    of_columns = say("Columns that go with it (rank correlation): {columns}.", columns=found)
    return some(words, columns and of_columns)


def _held_out(by: str) -> str:
    return say("held-out paths") if by == "path" else say("held-out fifths of the events")


def _held_out_error(by: str, crps_m: float, coordinate: str, along: float | None = None) -> str:
    """The held-out error in the coordinate of the records, and along the path if that is known."""
    values = {
        "by": _held_out(by),
        "crps": amount(crps_m, coordinate, 1),
        "coordinate": coordinate_text(coordinate),
    }
    if along is None or coordinate == "x":
        return say("Held-out CRPS ({by}): {crps} of {coordinate}.", **values)
    return say(
        "Held-out CRPS ({by}): {crps} of {coordinate}, {along} of distance along the path.",
        along=amount(along, "x", 1),
        **values,
    )


def error_text(found: Comparison) -> list[str]:
    """The held-out error of a model, and the measurement-error floor."""
    coordinate, held = found.coordinate, found.held_out
    along = None if held.runout_x is None else held.runout_x.crps_m
    return some(
        _held_out_error(held.by, held.runout.crps_m, coordinate, along),
        say(
            "Root mean square error, held-out: {rmse}; measurement-error floor (errors of recorded "
            "runout, volume and release): {floor}. Natural variability comes on top for every "
            "model.",
            rmse=amount(held.runout.rmse_m, coordinate, 0),
            floor=amount(held.runout.noise_floor_m, coordinate, 0),
        ),
        say(
            "{share} of the held-out records lie in the 90 % interval.",
            share=share(held.runout.coverage_90),
        ),
        held.speed
        and say(
            "Root mean square error of speeds, held-out: {error} m/s.",
            error=digits(held.speed.rmse_m_s, ".1f"),
        ),
    )


MOST_LEVELS = 3


def failure_text(
    found: Comparison, names: Names = NO_NAMES, diagnosis: Diagnosis | None = None
) -> str:
    """Where the model fails beyond chance, by stops and by speeds, the worst levels first.

    `names` are those of paths; a `diagnosis` is what was said before.
    """
    named = [
        plural(
            "{axis} “{level}” ({n} event, {bias})",
            "{axis} “{level}” ({n} events, {bias})",
            row.n,
            axis=axis_text(row.axis),
            level=names.get(row.level) or level_text(row.level),
            bias=off_text(row.bias_m, found.coordinate),
        )
        for row in failing(found)
    ]
    named += [
        say(
            "{axis} “{level}” ({n} speeds, {bias})",
            axis=axis_text(row.axis),
            level=level_text(row.level),
            n=row.n,
            bias=_speed_off(row.bias_m_s or 0.0),
        )
        for row in sorted(failing_speeds(found), key=lambda row: row.p_value or 0.0)
    ]
    if not named:
        return say("It fails significantly nowhere (corrected p above 0.05 on every axis).")
    few = spoken().few(named, MOST_LEVELS)
    if diagnosis is not None and diagnosis.verdict == "adequate":
        return say(
            "Yet it fails beyond chance by {levels}; no candidate effect has evidence enough to be "
            "named.",
            levels=few,
        )
    return say("It fails beyond chance by {levels}.", levels=few)


def off_text(bias: float, coordinate: str) -> str:
    """Which way runouts are predicted wrongly, and by how much, of predicted minus recorded."""
    size = amount(abs(bias), coordinate, 0)
    if coordinate == "elevation":
        return say("{size} too high", size=size) if bias > 0.0 else say("{size} too low", size=size)
    # The ratio H/L falls with the runout, and mixed records count as elevations.
    far = bias > 0.0 if coordinate in ("x", "length") else bias < 0.0
    return say("{size} too far", size=size) if far else say("{size} too short", size=size)


def _speed_off(bias: float) -> str:
    size = f"{digits(abs(bias), '.1f')} m/s"
    return say("{size} too fast", size=size) if bias > 0.0 else say("{size} too slow", size=size)


def change_text(found: BeforeAndAfter) -> str:
    """How the held-out error changes from a parent to its child."""
    coordinate, after, fall = found.coordinate, found.after.held_out_crps_m, found.fall
    if found.before is None:
        return _held_out_error(found.held_out_by, after, coordinate)
    before = found.before.held_out_crps_m
    values = {"before": amount(before, coordinate, 1), "after": amount(after, coordinate, 1)}
    values["by"] = _held_out(found.held_out_by)
    if found.worse:
        return (
            say(
                "The held-out CRPS ({by}) stays at {after}: do not use the child for runouts.",
                **values,
            )
            if values["before"] == values["after"]
            else say(
                "The held-out CRPS ({by}) rises from {before} to {after}: do not use the child for "
                "runouts.",
                **values,
            )
        )
    if found.rises:
        return say(
            "The held-out CRPS ({by}) rises slightly, from {before} to {after}, but the elpd of "
            "held-out records rises by {nats:.1f} nats: keep the child.",
            **values,
            nats=found.gain,
        )
    if fall is None:
        return say("The held-out CRPS ({by}) falls from {before} to {after}.", **values)
    values |= {
        "low": str(in_unit(fall.q05_m, coordinate)),
        "high": amount(fall.q95_m, coordinate, 1),
    }
    if fall.q05_m > 0.0:
        return say(
            "The held-out CRPS ({by}) falls from {before} to {after}, by {low} to {high} (90 % "
            "interval).",
            **values,
        )
    return say(
        "The held-out CRPS ({by}) changes from {before} to {after}; a fall is not certain (90 % "
        "interval {low} to {high}).",
        **values,
    )


def doubt_text(found: BeforeAndAfter, parent: str) -> str:
    """That a child errs less than its parent is not certain; empty where it is, or not known."""
    fall, coordinate = found.fall, found.coordinate
    if fall is None or found.before is None or fall.q05_m > 0.0:
        return ""
    return say(
        "That it errs less than “{parent}” ({before}) is not certain: the 90 % interval of the "
        "difference is {low} to {high}.",
        parent=parent,
        before=amount(found.before.held_out_crps_m, coordinate, 0),
        low=in_unit(fall.q05_m, coordinate, 0),
        high=amount(fall.q95_m, coordinate, 0),
    )


def before_and_after_text(found: BeforeAndAfter) -> str:
    """The error of a child beside its parent's, and the floor of both."""
    floor = say(
        "Measurement-error floor (CRPS; errors of runout, volume and release): {floor}.",
        floor=amount(found.after.noise_floor_crps_m, found.coordinate, 1),
    )
    return f"{change_text(found)} {floor}"


def verdict_text(diagnosis: Diagnosis, who: str | None = None) -> str:
    """What a diagnosis says of the model, and where the records have what is missing."""
    verdict = short_verdict(diagnosis, who)
    where = [spoken().note(note) for note in diagnosis.where]
    kinds = [
        words
        for c in diagnosis.candidates
        if c.kinds is not None and c.effect in diagnosis.missing
        for words in kinds_text(c.kinds)
    ]
    factors = [
        say("The errors would be {factor:.2g} times those stated.", factor=math.exp(value))
        for c in diagnosis.candidates
        if c.effect in diagnosis.missing
        for name, value in c.parameters.items()
        if name.endswith(".log_factor")
    ]
    together = [
        say(
            "Together they gain {nats:.1f} nats over the best of them alone (p {p}).",
            nats=largest.gain_over_best_single,
            p=chance(largest.p_value, 1.0 / (diagnosis.n_worlds + 1)),
        )
        for largest in diagnosis.pairs[-1:]
    ]
    return " ".join([verdict, *factors, *together, *kinds, *where])


def short_verdict(diagnosis: Diagnosis, who: str | None = None) -> str:
    """What a diagnosis says of the model, and which effect it would have detected."""
    who = say("The model") if who is None else who
    values = {"who": who, "missing": ", ".join(spoken().effect(key) for key in diagnosis.missing)}
    values["size"] = amount(diagnosis.detectable_m, diagnosis.coordinate, 0)
    if diagnosis.pairs and diagnosis.missing:
        values["missing"] = spoken().effects(diagnosis.pairs[-1].effects)
        return say("{who} lacks effects that are needed together: {missing}.", **values)
    if diagnosis.verdict == "missing-effect":
        return say("{who} lacks an effect: {missing}.", **values)
    if diagnosis.verdict == "ambiguous":
        near = diagnosis.near
        values["rest"] = ", ".join(spoken().effect(k) for k in diagnosis.missing if k not in near)
        values["likely"] = spoken().effect(near[0])
        return (
            say("{who} lacks an effect; these data cannot determine which: {missing}.", **values)
            if len(near) > 1 or not values["rest"]
            else say(
                "{who} lacks an effect: most likely {likely}; these data do not rule out {rest}.",
                **values,
            )
        )
    if diagnosis.verdict == "unexplained":
        return say(
            "{who} fails along {missing}, and no effect of the catalogue explains it.", **values
        )
    if diagnosis.cannot_tell:
        return say(
            "{who} shows no missing effect, but these data are insufficient: one behind half of "
            "the scatter could have been missed. Detectable with 80 % power: a candidate effect "
            "that moves runouts by {size} (rms).",
            **values,
        )
    return say(
        "{who} is adequate: these data show no missing effect. Detectable with 80 % power: a "
        "candidate effect that moves runouts by {size} (rms).",
        **values,
    )
