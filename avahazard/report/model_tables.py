"""Tables of a model: its parameters, its scores, where it fails, what it may lack, its ladder."""

from collections.abc import Callable, Sequence
from operator import attrgetter
from typing import Any

from avahazard.inference.model.laws import LAWS
from avahazard.report import words
from avahazard.report.language import say, spoken
from avahazard.report.tables import NO_NAMES, Column, Names, Table, made
from avahazard.results.base import RATIO
from avahazard.results.calibration import Calibration, ParameterSummary
from avahazard.results.comparison import (
    Comparison,
    Failure,
    LadderEntry,
    PredictedEvent,
    PredictedRecords,
    SpeedMisfit,
)
from avahazard.results.diagnosis import (
    LEVEL,
    Candidate,
    Diagnosis,
    FittedLaw,
    LawParameter,
    Measurement,
)
from avahazard.results.friction import Fits


def offsets_of(model: Calibration) -> dict[str, ParameterSummary]:
    """The offsets of a path effect by path; those of effects on one path are no such."""
    from avahazard.effects.groups import PATH  # noqa: PLC0415 (slow)

    own = tuple(f"{key}." for key in model.effects)
    return {
        key.removeprefix(PATH): found
        for key, found in model.parameters.items()
        if key.startswith(PATH) and not key.startswith(own)
    }


def parameters_table(model: Calibration, *, offsets: bool = True) -> Table:
    """The posterior of the parameters; `offsets`: with those of the paths."""

    def of(key: str) -> Callable[[Any], str | None]:
        # What is fixed has no spread.
        return lambda p: words.as_sure_as(p[1].sd, getattr(p[1], key)) if p[1].sd else None

    columns = (
        (say("parameter"), lambda p: p[0]),
        (">" + say("mean"), lambda p: words.as_sure_as(p[1].sd, p[1].mean)),
        (">" + say("± sd"), of("sd")),
        (">5 %", of("q05")),
        (">95 %", of("q95")),
        (">" + say("mode"), of("mode")),
        (say("unit"), lambda p: words.unit_text(p[1].unit) or None),
    )
    from avahazard.effects.covariate import VOLUME_LAW  # noqa: PLC0415 (slow)
    from avahazard.effects.groups import PATH  # noqa: PLC0415 (slow)

    hidden = () if offsets else {id(found) for found in offsets_of(model).values()}
    rows = [p for p in model.parameters.items() if id(p[1]) not in hidden]
    # Others keep their places.
    of_paths = iter(sorted((p for p in rows if p[0].startswith(PATH)), key=lambda p: p[0]))
    rows = [next(of_paths) if p[0].startswith(PATH) else p for p in rows]
    law = f"{spoken().effect(VOLUME_LAW.key)} ({LAWS[model.law].formula})"
    legend = [law] if VOLUME_LAW.key in model.effects else []
    return made("parameters", say("Parameters"), columns, rows, legend)


def kinds_table(model: Calibration) -> Table | None:
    """Each event's probability to be of the second kind, folded; None where there is one kind."""
    if model.kinds is None:
        return None
    rows = sorted(model.kinds.probability.items(), key=lambda row: -row[1])
    columns: tuple[Column, ...] = (
        (say("event"), lambda r: r[0]),
        (">" + say("probability"), lambda r: words.share(r[1])),
    )
    folded, title = words.events(len(rows)), say("Probability of the second kind")
    return made("kinds", title, columns, rows, shown=0, folded=folded)


def scores_table(coordinate: str, parts: Sequence[tuple[str, PredictedRecords]]) -> Table:
    """Scores of runouts in each coordinate, and of speeds if any; `parts` are on what they are.

    `coordinate` is that of the records.
    """
    rows: list[tuple[str, str, str, str | None, Any]] = []
    for name, scores in parts:
        unit = words.unit_of(coordinate)
        of = words.coordinate_text(coordinate)
        rows.append((name, f"{of}, {unit}" if unit == "m" else of, "m", coordinate, scores.runout))
        if coordinate != "x" and scores.runout_x is not None:
            rows.append((name, f"{words.coordinate_text('x')}, m", "m", "x", scores.runout_x))
        if scores.speed is not None:
            rows.append((name, say("speed") + ", m/s", "m_s", None, scores.speed))

    def of_error(key: str) -> Callable[[Any], str | None]:
        return lambda r: words.in_unit(getattr(r[4], f"{key}_{r[2]}"), r[3])

    columns = (
        (say("records"), lambda r: r[0]),
        (say("of"), lambda r: r[1]),
        (">n", lambda r: r[4].n),
        (">CRPS", of_error("crps")),
        (">RMSE", of_error("rmse")),
        (">" + say("bias"), of_error("bias")),
        (">" + say("in 50 %"), lambda r: words.share(r[4].coverage_50)),
        (">" + say("in 90 %"), lambda r: words.share(r[4].coverage_90)),
    )
    of_crps = say(
        "CRPS: mean error that counts the width of the forecast too; for a forecast without "
        "scatter it is the mean absolute error, and smaller is better."
    )
    of_bias = say(
        "bias: mean of predicted minus recorded; too far is above 0 in distance, and below 0 in "
        "elevation and where both are mixed. in 50 %, in 90 %: share of the records that lie in "
        "the 50 and 90 % intervals."
    )
    return made("scores", say("Scores against the records"), columns, rows, [of_crps, of_bias])


def compared_parts(found: Comparison) -> list[tuple[str, Any]]:
    """The parts of the table of scores of a comparison: held-out, then in-sample."""
    return [(say("held-out"), found.held_out), (say("in-sample"), found.scores)]


def failing(comparison: Comparison) -> list[Failure]:
    """Levels where the model fails beyond chance."""
    return [row for row in comparison.where_it_fails if row.p_value < words.SIGNIFICANT]


def failing_speeds(comparison: Comparison) -> list[SpeedMisfit]:
    """Levels where its speeds fail beyond chance."""
    rows = comparison.speed_misfit or ()
    return [row for row in rows if row.p_value is not None and row.p_value < words.SIGNIFICANT]


def failures_table(comparison: Comparison, names: Names = NO_NAMES) -> Table:
    """Where the model fails, the least likely by chance first; what may be chance is folded."""
    coordinate = comparison.coordinate
    rows = sorted(comparison.where_it_fails, key=lambda row: row.p_value >= words.SIGNIFICANT)

    columns: tuple[Column, ...] = (
        (say("by"), lambda r: words.axis_text(r.axis)),
        (say("level"), lambda r: names.get(r.level) or words.level_text(r.level)),
        (">" + say("events"), attrgetter("n")),
        (
            ">" + say("bias, {unit}", unit=words.unit_of(coordinate)),
            lambda r: f"{'+' if r.bias_m > 0 else ''}{words.in_unit(r.bias_m, coordinate, 0)}",
        ),
        (">p", lambda r: words.chance(r.p_value)),
    )
    legend = say(
        "bias: mean of predicted minus recorded; too far is above 0 in distance, and below 0 in "
        "elevation and where both are mixed. The p-values are corrected for the number of rows; "
        "under 0.05 a row needs an explanation."
    )
    n = len(failing(comparison))
    folded = say("{n} not significant", n=len(rows) - n)
    title = say("Where it fails")
    return made("failures", title, columns, rows, [legend], shown=n, folded=folded)


def misfit_table(comparison: Comparison) -> Table | None:
    """Misfit of speeds, friction fitted to each stop; None without measured speeds."""
    columns: tuple[Column, ...] = (
        (say("by"), lambda r: words.axis_text(r.axis)),
        (say("level"), lambda r: words.level_text(r.level)),
        (">n", attrgetter("n")),
        (">" + say("bias, {unit}", unit="m/s"), lambda r: words.digits(r.bias_m_s, "+.1f")),
        (">RMSE, m/s", lambda r: words.digits(r.rmse_m_s, ".1f")),
        (">p", lambda r: None if r.p_value is None else words.chance(r.p_value)),
    )
    title = say("Speeds, with friction fitted to each stop")
    rows = comparison.speed_misfit
    return made("misfit", title, columns, rows) if rows else None


def budget_table(found: Comparison) -> Table | None:
    """The error budget: root mean squares, and shares of the squared error; None without one."""
    whole = sum(part.rms_m**2 for part in found.budget) or 1.0
    columns = (
        (say("source of error"), lambda p: words.part_text(p.source)),
        (
            ">" + say("rms, {unit}", unit=words.unit_of(found.coordinate)),
            lambda p: words.in_unit(p.rms_m, found.coordinate),
        ),
        (">" + say("share of squares"), lambda p: words.share(p.rms_m**2 / whole)),
    )  # fmt: skip
    legend = words.some(
        found.profile_m is not None
        and say(
            "Errors of the profiles' points move the predicted stops by {size} (rms): a part "
            "of the scatter and of what is unexplained, not one beside them.",
            size=words.amount(found.profile_m, found.coordinate),
        )
    )
    title = say("Where the error comes from")
    return made("budget", title, columns, found.budget, legend) if found.budget else None


def ladder_table(rows: Sequence[LadderEntry]) -> Table:
    """Every model and its error, oldest first; its parent by number, as names may be long."""
    number = {row.model: str(k) for k, row in enumerate(rows, 1)}
    known = {row.coordinate for row in rows if row.coordinate is not None}
    coordinate = known.pop() if len(known) == 1 else None
    unit = words.unit_of(coordinate)

    def error(key: str, of: str | None = None) -> Callable[[Any], str | None]:
        return lambda r: words.in_unit(getattr(r, key), of or r.coordinate)

    columns: tuple[Column, ...] = (
        ("#", lambda r: number[r.model]),
        (say("model"), attrgetter("model")),
        (">" + say("from"), lambda r: number.get(r.parent)),
        (say("added"), lambda r: ", ".join(spoken().effect(key) for key in r.added) or None),
        (">" + say("held-out CRPS, {unit}", unit=unit), error("held_out_crps_m")),
        (">" + say("of x, m"), error("held_out_crps_x_m", "x")),
        (">" + say("in-sample CRPS, {unit}", unit=unit), error("crps_m")),
        (">elpd", lambda r: words.digits(r.elpd_loo, ".0f")),
        (">" + say("in 90 %"), lambda r: None if r.coverage_90 is None
            else words.share(r.coverage_90)),
        (">" + say("speed RMSE"), lambda r: None if r.speed_rmse_m_s is None
            else spoken().number(f"{r.speed_rmse_m_s:.1f} m/s")),
    )  # fmt: skip
    of_scores = say(
        "held-out CRPS: the error of a model, on records that it was not calibrated on. CRPS: "
        "mean error that counts the width of the forecast too; smaller is better. elpd: log "
        "predictive density with each record left out in turn; higher is better. in 90 %: "
        "share of the records in the 90 % interval."
    )
    legend = [of_scores, say("from: the number of the parent.")]
    if coordinate != "x":
        legend.append(say("of x: held-out CRPS of the distance along the path."))
    floors = [row.noise_floor_crps_m for row in rows if row.noise_floor_crps_m]
    if floors:
        # What the error of a volume does to a stop is the model's own; gibbs knows none.
        low, high = (words.amount(f, coordinate, 1) for f in (min(floors), max(floors)))
        legend.append(
            say(
                "Measurement-error floor (CRPS; errors of runout, volume and release): {floor}.",
                floor=low if low == high else say("{low} to {high}", low=low, high=high),
            )
        )
    return made("models", say("Every model and its error, oldest first"), columns, rows, legend)


def candidates_table(diagnosis: Diagnosis) -> Table:
    """Candidate effects, best first.

    Folded are those that chance may have made and, where something is missing, those that were
    not worth a fit: the next diagnosis asks about them again.
    """
    floor = 1.0 / (diagnosis.n_worlds + 1)
    named, coordinate = diagnosis.named, diagnosis.coordinate
    unit = words.unit_of(coordinate)

    def errors(c: Candidate) -> str:
        both = (c.error_before_m, c.error_after_m)
        return " → ".join(filter(None, (words.in_unit(error, coordinate) for error in both)))

    columns = (
        (say("effect"), lambda c: spoken().effect(c.effect)),
        (">" + say("gain, nats"), lambda c: words.digits(c.screened_gain, ".1f")),
        (">" + say("evidence, nats"), lambda c: words.digits(c.evidence_gain, ".1f")),
        (">p", lambda c: words.chance(c.p_value, floor)),
        (">" + say("at-mode CRPS, {unit}", unit=unit), errors),
    )
    legend = say(
        "gain: log likelihood with the effect minus that without (2.3 nats: a likelihood "
        "ratio of 10, 4.6 nats: of 100). p: chance of such a gain among all candidates if "
        "nothing is missing. at-mode CRPS: in-sample, with the parameters at their mode and "
        "offsets of paths granted; the in-sample CRPS of a comparison is another figure."
    )
    legends = [legend]
    if any(c.evidence_gain is not None for c in diagnosis.candidates):
        legends.append(
            say("evidence: the log marginal likelihood it adds; it ranks the effects in the lead.")
        )
    for c in diagnosis.candidates:
        # A pair that holds the effect's own column is no other.
        column = c.effect.partition(":")[2]
        others = [k for k in c.confounded_with if column not in k.partition(":")[2].split("*")]
        if c.effect in named and others:
            effect, names = spoken().effect(c.effect), spoken().effects(others)
            legends.append(
                say("{effect} is confounded with {others}.", effect=effect, others=names)
            )
    low = [c.effect for c in diagnosis.candidates if c.p_value < words.SIGNIFICANT and not named]
    if low:
        legends.append(
            say(
                "No effect is named, though p is low for {effects}: a name needs p up to {level}, "
                "evidence over 3 nats and a gain on held-out records.",
                effects=spoken().effects(low),
                level=words.digits(LEVEL, ".2f"),
            )
        )

    def stands(c: Candidate) -> bool:
        fitted = not named or c.error_after_m is not None
        return c.effect in named or (c.p_value <= LEVEL and fitted)

    rows = sorted(diagnosis.candidates, key=lambda c: not stands(c))
    n = sum(map(stands, rows))
    folded = say("{n} not significant or not fitted", n=len(rows) - n) if named else ""
    folded = folded or say("{n} not significant", n=len(rows) - n)
    title = say("Candidate effects")
    return made("candidates", title, columns, rows, legends, cards=True, shown=n, folded=folded)


SHAPE_ROWS = 5


def shape_table(diagnosis: Diagnosis) -> Table | None:
    """The curve of the leading smooth, at a few places; None where there is none."""
    named = (c for c in diagnosis.candidates if c.shape and c.effect in diagnosis.missing)
    found = next(named, None)
    if found is None or found.shape is None:
        return None
    shape = found.shape
    n = len(shape.q50)
    places = [k * (n - 1) // (SHAPE_ROWS - 1) for k in range(SHAPE_ROWS)]
    if shape.path is not None:
        # It is the same along each of some stretches.
        places = [k for k in range(n) if k == 0 or shape.q50[k] != shape.q50[k - 1]]
    if levels := shape.levels:
        places = sorted(range(len(levels)), key=lambda k: -shape.q50[k])
    state, value = words.shape_text(shape)

    def of(values: Sequence[float], form: str = "+.3f") -> Any:
        return lambda k: words.digits(values[k], form)

    columns: tuple[Column, ...] = (
        (state, lambda k: levels[k]) if levels else (">" + state, of(shape.x, ".4g")),
        (">5 %", of(shape.q05)),
        (">" + say("median"), of(shape.q50)),
        (">95 %", of(shape.q95)),
    )  # fmt: skip
    title = say("Shape of {effect}: {value}", effect=spoken().effect(found.effect), value=value)
    return made("shape", title, columns, places)


def laws_table(diagnosis: Diagnosis) -> Table | None:
    """The laws that the leading smooth may be; None where there is none."""
    found = diagnosis.lawful
    if found is None or not found.laws:
        return None

    def of(name: str, p: LawParameter) -> str:
        values = {"low": p.q05, "median": p.q50, "high": p.q95}
        told = {
            key: words.digits(value, ".0f" if abs(value) >= 1000.0 else ".3g")
            for key, value in values.items()
        }
        text = say("{name} {median} ({low} to {high})", name=name, **told)
        unit = words.law_unit(name, p, found.shape)
        return f"{text} {unit}" if unit else text

    def values(law: FittedLaw) -> str:
        return "; ".join(of(name, p) for name, p in law.parameters.items())

    columns: tuple[Column, ...] = (
        (say("law"), lambda law: law.form),
        (">" + say("evidence, nats"), lambda law: words.digits(law.evidence, ".1f")),
        (say("parameters: median (90 % credible interval)"), values),
    )
    legend = say(
        "Laws whose evidence differs by less than 3 nats cannot be distinguished. s: {of}. "
        "{formulas}.",
        of=words.law_state(found.shape) if found.shape else "",
        formulas="; ".join(f"{law.form}: {law.formula}" for law in found.laws),
    )
    title = say("Laws of {effect}", effect=spoken().effect(found.effect))
    return made("laws", title, columns, found.laws, [legend])


def measure_table(diagnosis: Diagnosis) -> Table | None:
    """What to measure next; None where nothing is proposed."""

    def between(m: Measurement) -> str:
        text = ", ".join(map(spoken().effect, m.between))
        return say("{effect} or none", effect=text) if len(m.between) == 1 else text

    columns: tuple[Column, ...] = (
        (say("measurement"), lambda m: spoken().note(m.measurement)),
        (say("to distinguish"), between),
        (">" + say("expected gain, nats"), lambda m: words.digits(m.expected_gain, ".1f")),
        (">" + say("days in the field"), lambda m: words.digits(m.field_days, "g")),
    )
    title = say("What to measure next")
    rows = diagnosis.measure_next
    return made("measure", title, columns, rows) if rows else None


def fits_table(fits: Fits) -> Table:
    """Laws by least squares."""
    rows = [(fit, *entry) for fit in fits.rows for entry in fit.parameters.items()]
    columns: tuple[Column, ...] = (
        ("law", lambda r: LAWS[r[0].law].formula),
        ("", lambda r: r[1]),
        (">value", lambda r: r[2].value),
        (">± se", lambda r: r[2].se),
        ("unit", lambda r: r[2].unit or None),
        (">r²", lambda r: f"{round(r[0].r2, 3) + 0.0:.3f}"),
        (">AIC", lambda r: f"{r[0].aic:.1f}"),
    )
    return made("fits", "Least squares of apparent friction", columns, rows)


def predicted_table(rows: Sequence[PredictedEvent]) -> Table:
    """Predicted stops of events; the title has what is predicted where it is the same of all."""
    units = {r.coordinate: "H/L" if r.coordinate == RATIO
        else words.coordinate_text(r.coordinate) + ", m" for r in rows}  # fmt: skip

    def of(key: str) -> Any:
        return lambda r: words.in_unit(getattr(r, key), r.coordinate, 0)

    columns: tuple[Column, ...] = (
        ("event", attrgetter("event_id")),
        ("path", attrgetter("path_id")),
        ("of", lambda r: units[r.coordinate] if len(units) > 1 else None),
        (">mean", of("mean_m")),
        (">± sd", of("sd_m")),
        (">5 %", of("q05_m")),
        (">median", of("q50_m")),
        (">95 %", of("q95_m")),
        (">beyond", lambda r: words.share(r.p_left_profile)
            if r.p_left_profile else None),
    )  # fmt: skip
    title = ", ".join(("Predicted stops", *(units.values() if len(units) == 1 else ())))
    return made("predicted", title, columns, rows)
