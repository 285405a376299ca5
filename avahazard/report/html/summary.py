"""The first page in words: which model, and how sure it is."""

from __future__ import annotations

from avahazard.inference.model.choices import METHODS
from avahazard.inference.model.laws import law
from avahazard.report.html.content import ReportContent
from avahazard.report.html.words import (
    amount,
    axis_words,
    events,
    kept_back,
    level_words,
    number,
    of_coordinate,
    paths,
    share,
)
from avahazard.results.comparison import Comparison, Failure

SIGNIFICANT = 0.05


def model_words(content: ReportContent) -> list[str]:
    """What the model is, in two or three sentences."""
    model, language = content.model, content.language
    say = language.say
    n_paths = len({e.path_id for e in content.events if e.path_id is not None})
    words = [
        say(
            "The avalanche is a block that slides down the path; its friction μ {law}.",
            law=language.told(law(model.law).words),
        ),
        say(
            "The model was calibrated on {events} on {paths}, by {method}.",
            events=events(model.n_events, language),
            paths=paths(n_paths, language),
            method=language.told(METHODS[model.method].words),
        )
        if n_paths
        else say(
            "The model was calibrated on {events}, without profiles, by {method}.",
            events=events(model.n_events, language),
            method=language.told(METHODS[model.method].words),
        ),
    ]
    if METHODS[model.method].in_metres:
        words.append(say("Stops scatter about that of the block by σ metres of elevation."))
    else:
        families = {"lognormal": say("lognormal"), "normal": say("normal")}
        family = families[model.distribution]
        if model.tails == "student":
            family += say(", with heavy tails (Student's t)")
        words.append(
            say(
                "From one avalanche to the next friction scatters ({family}), less or more by "
                "volume.",
                family=family,
            )
            if model.scatter == "volume"
            else say("From one avalanche to the next friction scatters ({family}).", family=family)
        )
    if model.effects:
        named = ", ".join(language.effect(key) for key in model.effects)
        words.append(say("It has these effects besides: {effects}.", effects=named))
    if not model.centrifugal:
        words.append(say("The load of the path's curvature on the bed is left out."))
    if model.parent:
        words.append(say("It was made from the model “{model}”.", model=model.parent))
    return words


def why_words(content: ReportContent) -> list[str]:
    """Why this model and not another of the ladder: its error on what it had not seen."""
    say = content.language.say
    known = {
        row.model: row.held_out_crps_m for row in content.ladder if row.held_out_crps_m is not None
    }
    name = content.model.model
    if len(known) < 2 or name not in known:
        return []
    best = min(known, key=lambda key: known[key])
    coordinate = next(row.coordinate for row in content.ladder if row.model == name)
    own, least = (amount(known[key], coordinate, language=content.language) for key in (name, best))
    if best == name:
        words = [
            say(
                "Of {n} compared models it has the least error, the CRPS on records kept back: "
                "{error}.",
                n=len(known),
                error=own,
            )
        ]
    else:
        words = [
            say(
                "Of {n} compared models “{best}” has the least error, the CRPS on records kept "
                "back: {least}; this one has {error}.",
                n=len(known),
                best=best,
                least=least,
                error=own,
            )
        ]
    parent = content.model.parent
    if parent in known and parent != best:
        error = amount(known[parent], coordinate, language=content.language)
        words.append(say("Its parent “{parent}” has {error}.", parent=parent, error=error))
    return words


def sure_words(content: ReportContent) -> list[str]:
    """How far the model misses records that it had not seen; empty where it was not compared."""
    if content.comparison is None:
        return []
    language, held = content.language, content.comparison.held_out
    say, runout = language.say, held.runout
    coordinate = content.comparison.coordinate
    crps, rmse, floor = (
        amount(value, coordinate, digits, language)
        for value, digits in ((runout.crps_m, 1), (runout.rmse_m, 0), (runout.noise_floor_m, 0))
    )
    error = of_coordinate(crps, coordinate, language)
    if held.runout_x is not None and coordinate != "x":
        error = say(
            "{error} and {along} m of distance along the path",
            error=error,
            along=number(held.runout_x.crps_m, language),
        )
    words = [
        say(
            "The error of the model, {where}: {error} (CRPS; of a forecast without scatter it "
            "would be the mean absolute error).",
            where=kept_back(held.by, language),
            error=error,
        ),
        say(
            "Root mean square of predicted mean less record: {error}. Errors of the records "
            "alone (runout, volume, release) would leave {floor}; what varies from avalanche to "
            "avalanche comes on top for every model.",
            error=of_coordinate(rmse, coordinate, language),
            floor=floor,
        ),
        say(
            "{share} of these records lie in the interval that should hold 90 %.",
            share=share(runout.coverage_90, language),
        ),
    ]
    if held.speed is not None:
        words.append(
            say(
                "Measured speeds are missed by {error} m/s (root mean square).",
                error=language.number(f"{held.speed.rmse_m_s:.1f}"),
            )
        )
    fails = failing(content.comparison)
    if fails:
        words.append(
            language.plural(
                "It fails where chance cannot explain it: first by {axis}, “{level}” ({n} level "
                "in all).",
                "It fails where chance cannot explain it: first by {axis}, “{level}” ({n} levels "
                "in all).",
                len(fails),
                axis=axis_words(fails[0].axis, language),
                level=level_words(fails[0].level, language),
            )
        )
    else:
        words.append(say("It fails nowhere that chance could not explain."))
    return words


def failing(comparison: Comparison) -> list[Failure]:
    """Levels where the model fails beyond chance."""
    return [row for row in comparison.where_it_fails if row.p_value < SIGNIFICANT]
