"""Notes: sentences for people, as a key and its values; here stand all of them, in English.

Who finds something worth a note says `Note("stale", model="base")`. A note is its English sentence
too, so that whatever takes text takes it; the report says it in another language by its key
(`report.language`), and the database keeps key and values.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from string import Formatter
from typing import Any, Self

FEW = 3
"""Names that a line for people holds before `and n more`."""

SENTENCES: dict[str, str | tuple[str, str]] = {
    # A model
    "paths_differ": "paths differ by a standard deviation of {sd:.2f} on log friction (log "
    "evidence {nats:+.0f} nats); {model} has no path effect: its design runouts are too narrow. "
    "{remedy}",
    "add_effect": "The effect {effect} would take it up.",
    "too_few_paths": "{n} paths are too few to add one: take the intervals as too narrow, unless "
    "`diagnose` sets one apart.",
    "heavier_tails": "friction scatters with heavier tails than {model} has, or some records are "
    "wrong (log likelihood {nats:+.0f} nats; --tails student accounts for both): its scatter is "
    "too wide, and few records decide its law.",
    "prior_dominated": "{parameter} is weakly identified: in {model} it is prior-dominated (mean "
    "moved by {moved:.1f} standard deviations of the prior, posterior {width:.0%} as wide).",
    "prior_given": "the prior of {parameter} in {model} is {mean:g} ± {sd:g}, as given.",
    "prior_from": "the law of {model} has its prior from {source}.",
    "stale": "the records have changed since {model} was calibrated.",
    "unconverged": "the chains of {model} have not converged.",
    "not_converged": "the chains have not converged (R-hat {rhat:.3f}, smallest effective sample "
    "size {ess:.0f}): the model is stored as such. More --draws may help.",
    "few_events": ("{model} is based on {n} event only.", "{model} is based on {n} events only."),
    "older_version": "{model} was made with version {version} of this program, which is {now} now: "
    "avahazard rerun {model} shows whether that matters.",
    "weights": "the models have these weights, by which their mixture predicts left-out records "
    "best (stacking): {weights}.",
    "any_volume": "this model's friction is the same for every volume.",
    "held_out_by_event": "{model} has an effect on single paths, of which other paths say nothing: "
    "its held-out scores are by folds of events. By the same folds its parent has a held-out CRPS "
    "of {crps:.1f} m.",
    "largest_volume": "{model} takes no true volume to be larger than {largest:,.0f} m3, as its "
    "records together indicate: a larger record counts as an error.",
    "volume_shape": "{model} does not take true volumes to be lognormal: its records together "
    "indicate another shape of their spread within a path.",
    "events_left_out": "method {method} leaves out {n} of {total} events: {reasons}.",
    "no_speeds": "method {method} does not use measured speeds.",
    # Its records
    "misses_points": "the path that the block runs on misses the points of its profile by "
    "{away:.0f} m at x = {x:.0f} m. Look at it: avahazard path PATH --plot FILE.",
    "contradicts_itself": "the record of this event contradicts itself: {column} is {value:g}; "
    "accepted would be {accepted}.",
    "volume_of_deposit": "about {deposit:g}, half of length times width times thickness; or one of "
    "both",
    "elevation_there": "about {there:g}, where the profile is at runout_x_m {x:g}; or one of both",
    "not_beyond": "left_profile 0, or a runout at the end of the profile or beyond, or none",
    "below_release": "a stop below the release, which is at {release:g} ({whose})",
    "release_of_path": "release_elevation_m of the path",
    "above_limit": (
        "{n} record stops above observed_below_m ({limit:g} m), where none is said to be seen: "
        "event {events:few}, at {elevation:.0f} m. Correct the limit, or this record.",
        "{n} records stop above observed_below_m ({limit:g} m), where none is said to be seen: "
        "events {events:few}, up to {elevation:.0f} m. Correct the limit, or these records.",
    ),
    "outcome_column": "{column} orders the events as their stops do (rank correlation {rank:+.3f}, "
    "given the path): it is the runout in another form, and no effect may use it.",
    "recorded_twice": "alike in path, day and stop, or in all columns: is that one avalanche "
    "recorded twice? It would count twice: keep one row of it.",
    "spelled_variously": "spellings that are taken for one value: {parts}.",
    # A path and its profile
    "error_assumed": "{n} points do not give their error: {sigma:g} m was assumed. Give "
    "elevation_sigma_m.",
    "points_scatter": "the points scatter by {scatter:.1f} m about smooth ground, more than their "
    "elevation_sigma_m of {sigma:.1f} m: the block runs over bumps that may be errors.",
    "path_rises": "the path rises at {places:; }.",
    "sharp_bends": "the radius of curvature is below the length of the flow ({length:.0f} m) at "
    "{places:; }: the block is a poor model there.",
    "stretch": "x = {first:.0f}–{last:.0f} m",
    # Rows of `hazard`, and zones
    "not_started": "the block does not start in {share:.0%} of the draws, since the slope at its "
    "release is below the friction. {hint}",
    "held_at_release": "{share:.0%} of the avalanches stop at their release, where the slope is "
    "below the friction. {hint}",
    "check_release": "Real ones start: check where the releases are on the profile "
    "(release_elevation_m of the events, else of the path, else its top), and that the volume is "
    "like those on record.",
    "no_rate": "how often avalanches come down this path is not known, so it has no design runout: "
    "give its records dates.",
    "data_window": "the rate of avalanches counts the path's records over the {seasons} from "
    "{first} to {last}, in which paths of this data set have records, as observed_from or "
    "observed_to is missing. Give both if the path was observed for longer or shorter.",
    "of_winters": "winters",
    "of_years": "years",
    "rate_trend": "the rate of recorded avalanches changes over the years: from one decade to the "
    "next it is {factor:.2f} times as high (90 % interval {low:.2f} to {high:.2f}, p = {p:.1g}). "
    "Climate or more complete records can cause this. The design runout uses the mean over the "
    "observed years; --as-of YEAR uses the rate of one year.",
    "size_trend": "recorded volumes change over the years: from one decade to the next they are "
    "{factor:.2f} times as large (90 % interval {low:.2f} to {high:.2f}, p = {p:.1g}). The design "
    "runout uses those of all observed years; --as-of YEAR uses those of one year.",
    "as_of_rate": "the rate is that of {year}, by --as-of: from one decade to the next "
    "{factor:.2f} times as many avalanches are recorded (90 % interval {low:.2f} to {high:.2f}).",
    "as_of_size": "volumes are those of {year}, by --as-of: from one decade to the next they are "
    "recorded {factor:.2f} times as large (90 % interval {low:.2f} to {high:.2f}).",
    "as_of_beyond": "{year} is outside the observed years {first} to {last}: the trend of the "
    "records is extrapolated.",
    "part_beyond": "part of the interval of the {period:g}-year runout is beyond the end of the "
    "profile. A longer profile would show how far.",
    "all_beyond": "the {period:g}-year runout is beyond the end of the profile, and how far is not "
    "known: import a profile that reaches further.",
    "on_floor": "the {period:g}-year runout is at the lowest place of the path, which rises beyond "
    "it: scatter in metres of elevation (method metropolis) goes no further, so the interval ends "
    "there or has no width. Calibrate with --method marginal.",
    "extrapolated": "{period:g} years are over twice the observed years, or past the ends of the "
    "table: an extrapolation.",
    "periods_extrapolated": "T = {periods} is past twice the observed years, or past the table of "
    "volumes: an extrapolation.",
    "not_positive": "some draws of friction were not over 0, as the normal distribution has it; "
    "they are left out. The lognormal one never does this.",
    "rising_friction": "in {share:.0%} of the draws larger avalanches stop earlier: friction rises "
    "with volume between the smallest and the largest record ({smallest:,.0f} to {largest:,.0f} "
    "m3).",
    "beyond_both": "a volume of {volume:,.0f} m3 is {times_path:g} times the largest recorded on "
    "this path ({largest_of_path:,.0f} m3) and {times:g} times that of all paths ({largest:,.0f} "
    "m3): an extrapolation.",
    "beyond_path": "a volume of {volume:,.0f} m3 is {times_path:g} times the largest recorded on "
    "this path ({largest_of_path:,.0f} m3): an extrapolation.",
    "beyond_all": "a volume of {volume:,.0f} m3 is {times:g} times the largest recorded "
    "({largest:,.0f} m3): an extrapolation.",
    "friction_too_low": "FRICTION OUT OF BOUNDS: for {volume:,.0f} m3, {share:.0%} of the "
    "frictions drawn are under {limit:g} (median {median:.2g}), as no avalanche has. Do not use "
    "this runout; --law asymptotic keeps friction bounded.",
    "friction_too_high": "FRICTION OUT OF BOUNDS: for {volume:,.0f} m3, {share:.0%} of the "
    "frictions drawn are over {limit:g} (median {median:.2g}), as no avalanche has. Do not use "
    "this runout; --law asymptotic keeps friction bounded.",
    # What an interval holds
    "interval_any": "90 % of avalanches; varying: {parts}; the volume does not matter to this "
    "model",
    "interval_period": "90 % of avalanches; varying: {parts}; fixed: the volume of the return "
    "period (its own error apart)",
    "interval_volume": "90 % of avalanches; varying: {parts}; fixed: the volume",
    "interval_nature": "90 % of avalanches; varying: {parts}; fixed: the volume, and all "
    "parameters",
    "interval_parameters": "90 % of the posterior of the median runout; varying: {parts}",
    "interval_design": "90 % credible interval of the runout exceeded once in T years (chance 1/T "
    "a year); varying: {parts}; mixed: {mixed}",
    "interval_zones": "speed and pressure that a year exceeds with chance 1/T, all volumes and "
    "frictions mixed: 5, 50 and 95 % over the uncertainty of the parameters, of the frequency and "
    "of the density",
    "of_parameters": "uncertainty of the calibrated parameters",
    "of_unknown_path": "the unknown friction of a path without records",
    "of_volume_error": "error of the volume of the return period",
    "of_model": "not knowing which model is right",
    "of_rate_error": "error of the rate",
    "of_all_volumes": "all volumes",
    "of_frequency_error": "error of the frequency of volumes",
    "of_elevation": "scatter of the stop by sigma metres of elevation",
    "of_lognormal": "natural scatter of friction (lognormal) between avalanches",
    "of_normal": "natural scatter of friction (normal) between avalanches",
    "of_lognormal_student": "natural scatter of friction (lognormal, Student t) between avalanches",
    "of_normal_student": "natural scatter of friction (normal, Student t) between avalanches",
    "of_release": "the release, as in the records",
    "of_columns": "columns of the event, as in the records",
    # A comparison and a diagnosis
    "number": "{value:g}",
    "up_to": "up to {edge:{form}}{unit}",
    "from_to": "{low:{form}}{unit} to {high:{form}}{unit}",
    "above": "above {edge:{form}}{unit}",
    "fails_unexplained": "The comparison with the measurements shows places or speeds at which the "
    "model fails beyond chance; no candidate explains these.",
    "fails_on": "It fails beyond chance on {paths:and}; predicted minus recorded.",
    "path_bias": "{path} ({bias:+.0f} m)",
    "level_of_path": "{column} differs by path: {parts:; }.",
    "paths_at_level": "{paths:and}: {level}",
    "levels": "{column} of the {events} events: {parts}.",
    "levels_and_others": (
        "{column} of the {events} events: {parts} and {n} other level.",
        "{column} of the {events} events: {parts} and {n} other levels.",
    ),
    "forested": (
        "{paths:and} has forest ({events} of {total} events).",
        "{paths:and} have forest ({events} of {total} events).",
    ),
    "change_from": "The records differ most before and after {year:.1f} ({before} and {after} "
    "events).",
    "stretches": "What holds avalanches back lies on {where:and}, by x along the path.",
    "more_events": "{n} more events: effects of {size:.0f} m show",
    "more_events_ratio": "{n} more events: effects of {size:.4f} H/L show",
    "measure_runouts": "runouts of {n} more events on paths like these",
    "measure_mid_track": "speeds at mid-track on {n} events",
    "measure_whole_track": "speeds along the whole track of {n} events",
    "measure_further_path": "{n} events on a further path, like the one where they differ most",
    "measure_unlinked": "{n} events in which what {one:effect} and {other:effect} depend on does "
    "not vary together",
    # What a report lacks
    "no_profiles": "No path has a profile, so there are no lines to draw: import paths.csv and "
    "profiles.csv.",
    "no_bounds": "No bounds were computed. Make them: avahazard hazard {model}",
    "one_scatter": "A model by method metropolis holds all errors in one scatter, and cannot be "
    "compared with them. Calibrate with --method marginal to compare.",
    "not_compared": "The model was not compared with held-out records. Do it: avahazard compare "
    "{model}",
    "cannot_diagnose": "A model by method {method} cannot be diagnosed. Calibrate with --method "
    "marginal to diagnose.",
    "not_diagnosed": "The model was not diagnosed for missing effects. Do it: avahazard diagnose "
    "{model}",
    "map_instead": "The model runs on the terrain, not along lines: its result is a map. Draw it: "
    "avahazard map {model} -o {model}.tif",
    "no_zones": "Pressures and zones were not computed. Make them: avahazard zones {model}",
    "no_drag_zones": "Pressures and zones were not computed: {model} has neither drag on all of a "
    "path nor measured speeds, so its speeds are too high. To accept them: avahazard zones {model} "
    "--no-drag",
    "too_many_models": "more than {n} models",
    "effects_not_given": "its own effects were not given",
    "other_records": "calibrated on other records",
}
"""By key: the sentence, or for one thing and for `n` things; places as `str.format` has them.

A list is written with `, `, with the mark after the colon (`{places:; }`), with an `and`
(`{paths:and}`), or the first few of it (`{events:few}`); `{one:effect}` is the name of an effect.
A key keeps its places once released: databases hold its values.
"""


TERMINAL = {
    "left_out": "left out: {reason}",
    "went_on": "went on where it was interrupted: {n} of {total} paths were done.",
    "no_drag": "{model} has no drag: nothing but friction limits its speeds, so that they and the "
    "pressures are too high where the path is steep and long. Measured speeds, and the effect "
    "{effects}, would correct it.",
    "speeds_fail": "the speeds of {model} differ from the measured ones beyond chance, by "
    "{bias:+.0f} m/s somewhere: pressures and zones err with them. See avahazard compare {model}.",
    "no_terrain": "no terrain is stored for {paths}: import their lines with --dem.",
    "not_on_map": "not on the map, for want of terrain or runs: {paths}.",
    "friction_of_block": "the friction of {model} was calibrated for the block; for the runs of a "
    "flow model calibrate one with --forward.",
    "simulated_before": "all runs were there already.",
    "no_beta_point": "the profile never flattens to 10°: there is no β-point.",
    "flattens_again": "the path flattens to 10° again at x = {places} m; the first place is taken.",
    "friction_not_positive": "{share:.2%} of the draws of friction are 0 or less (normal "
    "distribution) and run beyond any profile",
    "level_unknown": "the model does not know {levels:and}, which counts as {level}.",
    "value_missing": "not given for {n} of {total} events: there it counts as {level}.",
    "in_ratio": "events without a profile, of which H/L alone is known, have H/L",
    "in_lengths": "events without a profile have runout lengths, not elevations",
    "speeds_off": "a factor of {factor:.2f} common to all measured speeds explains them better "
    "than {effect}: look at how they were measured before you look for a force.",
    "not_granted": "{effect} was not asked about: these records have too many groups (over {most} "
    "crossed with others) to fit together. Add it to the model to see what it does.",
    "not_asked": "{effect} was not asked about: {lack}.",
    "not_comparable": "{model} is not compared. {why}",
    # The next step
    "next": "{command}",
    "why_worse": "{model} has a larger held-out CRPS than {parent}: do not keep it. {why}",
    "why_calibrate": "No model is calibrated yet.",
    "why_compare": "{model} was not compared with its records.",
    "why_diagnose": "{model} was not diagnosed for missing effects.",
    "why_missing": "{model} lacks {effects:and}.",
    "why_write_law": "{model} lacks {effects:and}; its law {law} explains the records better than "
    "the smooth curve ({nats:.0f} nats). Write it as an effect.",
    "why_write_laws": "{model} lacks {effects:and}; its laws {laws:and} explain the records alike, "
    "and better than the smooth curve ({nats:.0f} nats). Write the first as an effect.",
    "why_law": "{model} lacks {effects:and}; its leading law is in {file}.",
    "why_speeds_off": "{model} misses all measured speeds by one factor: look at how they were "
    "measured.",
    "why_unexplained": "{model} fails along {along:and}, which no effect explains: write one.",
    "why_measure": "{model} lacks one of {effects}: these records cannot determine which (expected "
    "gain {nats:.1f} nats).",
    "why_each": "{model} lacks one of {effects}: these records cannot determine which. Add each, "
    "then average.",
    "why_average": "{model} lacks one of {effects}: these records cannot determine which. "
    "Average them.",
    "why_hazard": "{model} is the model to use; it has no design runouts yet.",
    "why_map": "{model} is the model to use: draw its map.",
    "why_report": "{model} is the model to use, and its design runouts are stored.",
}
"""Those that no report shows, and no language has."""


@dataclass(frozen=True, slots=True)
class Range:
    """From the least to the largest of the numbers of several notes."""

    low: float
    high: float


class Writer(Formatter):
    """Fills the places of sentences; as it is, in English."""

    def translated(self, sentence: str) -> str:
        """The sentence in the language."""
        return sentence

    def chosen(self, one: str, many: str, n: int) -> str:
        """The sentence in the language for `n` things."""
        return one if n == 1 else many

    def number(self, text: str) -> str:
        """A number as Python writes it (`-1,234.5`, `12%`) in the language."""
        return text

    def effect(self, key: str) -> str:
        """The name of an effect."""
        return key

    def say(self, message: str, /, **values: object) -> str:
        """A sentence in the language, with its places filled."""
        text = self.translated(message)
        return self.vformat(text, (), values) if values else text

    def plural(self, one: str, many: str, n: int, /, **values: object) -> str:
        """The same with a number `{n}` of things."""
        return self.vformat(self.chosen(one, many, n), (), {"n": n, **values})

    def note(self, stored: object) -> str:
        """The sentence of a note, or of what the database has of one."""
        note = Note.read(stored)
        if not note.key:
            return self.translated(str(note))
        return self.sentence(note.key, note.of, note.values)

    def sentence(self, key: str, of: Sequence[str], values: Mapping[str, Any]) -> str:
        """The sentence of that key, after what it is of."""
        sentence = SENTENCES.get(key) or TERMINAL.get(key)
        if sentence is None:  # of another version of the program
            text = ", ".join((key, *(f"{name} {value}" for name, value in values.items())))
        elif isinstance(sentence, str):
            text = self.vformat(self.translated(sentence), (), values)
        else:
            text = self.vformat(self.chosen(*sentence, values["n"]), (), values)
        return self.say("{of}: {text}", of=self.few(of), text=text) if of else text

    def few(self, names: Sequence[str], most: int = FEW) -> str:
        """The first few names in a row, and how many more."""
        if len(names) <= most:
            return ", ".join(names)
        first, rest = ", ".join(names[:most]), len(names) - most
        return self.say("{names} and {n} more", names=first, n=rest)

    def listed(self, names: Sequence[str]) -> str:
        """Names in a row, as a sentence has them."""
        if len(names) < 2:
            return "".join(names)
        return self.say("{some} and {last}", some=", ".join(names[:-1]), last=names[-1])

    def format_field(self, value: Any, format_spec: str) -> str:
        """What stands in a place: text, a note, a number in the language, or a row of these."""
        value = "–" if value is None else value  # a number that is not known
        if isinstance(value, Note):
            return self.note(value)
        if isinstance(value, str):
            return self.effect(value) if format_spec == "effect" else value
        if isinstance(value, Range):
            low, high = (self.number(format(v, format_spec)) for v in (value.low, value.high))
            return low if low == high else self.say("{low} to {high}", low=low, high=high)
        if isinstance(value, list | tuple):
            names = [self.format_field(item, "") for item in value]
            if format_spec in ("and", "few"):
                return self.listed(names) if format_spec == "and" else self.few(names)
            return (format_spec or ", ").join(names)
        return self.number(format(value, format_spec))


ENGLISH = Writer()


class Note(str):
    """An English sentence that knows its `key` of `SENTENCES`, its `values`, and what it is `of`.

    `of` are the names of paths or events that it is about, if any. A sentence without a key is
    one that was ready, as those in databases of earlier versions.
    """

    key: str
    of: tuple[str, ...]
    values: dict[str, Any]

    def __new__(cls, key: str, of: str | Sequence[str] = (), /, **values: Any) -> Self:
        """The note of that key, with the values of its places."""
        names = (of,) if isinstance(of, str) else tuple(of)
        return cls._made(ENGLISH.sentence(key, names, values), key, names, values)

    @classmethod
    def ready(cls, text: str) -> Self:
        """A sentence without a key, which no language translates."""
        return cls._made(text, "", (), {})

    @classmethod
    def _made(cls, text: str, key: str, of: tuple[str, ...], values: dict[str, Any]) -> Self:
        note = super().__new__(cls, text)
        note.key, note.of, note.values = key, of, values
        return note

    @classmethod
    def read(cls, stored: Any) -> Note:
        """The note that a database holds: key and values, or in old ones the sentence."""
        if isinstance(stored, Note):
            return stored
        if isinstance(stored, str):
            return cls.ready(stored)
        values = {name: _read(value) for name, value in stored.get("values", {}).items()}
        return cls(stored["key"], stored.get("of", ()), **values)

    def stored(self) -> Any:
        """What the database keeps of it: `read` gives it back."""
        if not self.key:
            return str(self)
        values = {name: _stored(value) for name, value in self.values.items()}
        found = {"key": self.key, "of": list(self.of), "values": values}
        return {name: value for name, value in found.items() if value}

    def about(self, *names: str) -> Note:
        """The same about these paths or events."""
        if self.key:
            return Note(self.key, names, **self.values)
        return Note.ready(f"{ENGLISH.few(names)}: {self}")

    def __reduce__(self) -> tuple[Any, ...]:
        return Note.read, (self.stored(),)

    @classmethod
    def __get_pydantic_core_schema__(cls, _source: Any, _handler: Any) -> Any:
        from pydantic_core import core_schema  # noqa: PLC0415 (slow to import)

        return core_schema.no_info_plain_validator_function(cls.read)


def _read(value: Any) -> Any:
    if isinstance(value, Mapping):
        return Note.read(value)
    return [_read(item) for item in value] if isinstance(value, list) else value


def _stored(value: Any) -> Any:
    if isinstance(value, Note):
        return value.stored()
    return [_stored(item) for item in value] if isinstance(value, list | tuple) else value


def placed(where: Mapping[Note, Iterable[str]], n_paths: int) -> list[Note]:
    """Each note with the paths that it is on; one that is on all of several is on none."""
    found = {note: tuple(paths) for note, paths in where.items()}
    return [n if len(p) == n_paths > 1 else n.about(*p) for n, p in found.items()]


def grouped(notes: Iterable[str]) -> list[Note]:
    """For people: notes that differ in numbers and in what they are of as one, with ranges."""
    found: dict[Any, Note] = {}
    for note in map(Note.read, notes):
        kind = _kind(note)
        found[kind] = _joined(found[kind], note) if kind in found else note
    return list(found.values())


def _kind(value: Any) -> Any:
    """What must be equal for two notes to be one: all but numbers and rows of names."""
    if isinstance(value, Note) and value.key:
        places = sorted((name, _kind(item)) for name, item in value.values.items())
        return (value.key, bool(value.of), *places)
    return str(value) if value is None or isinstance(value, str) else ""


def _joined(one: Any, other: Any) -> Any:
    """Two values of one kind as one: the names of both, the least and the largest number."""
    if isinstance(one, Note) and one.key:
        values = {
            name: value + other.values[name] if name == "n" else _joined(value, other.values[name])
            for name, value in one.values.items()
        }
        of = dict.fromkeys((*one.of, *other.of))
        # The same note of the same path twice is no second thing.
        return one if one == other else Note(one.key, tuple(of), **values)
    if isinstance(one, str) or one == other:
        return one
    if isinstance(one, list | tuple):
        return list(dict.fromkeys((*one, *other)))
    low, high = ((v.low, v.high) if isinstance(v, Range) else (v, v) for v in (one, other))
    return Range(min(low[0], high[0]), max(low[1], high[1]))


def counted(n: int, thing: str) -> str:
    """A number of things in English: `1 event`, `3 events`."""
    return f"{n} {thing if n == 1 else thing + 's'}"
