"""The one step to do now, decided from what is stored of the models; every command prints this."""

import shlex
from collections.abc import Collection, Sequence
from functools import cached_property

from avahazard.criticism.scoring.change import before_and_after
from avahazard.effects.catalogue import definition
from avahazard.effects.motion import CENTRIFUGAL
from avahazard.inference.model.choices import BLOCK, METHODS
from avahazard.notes import Note
from avahazard.records.errors import AvahazardError
from avahazard.results.calibration import Calibration
from avahazard.results.comparison import Comparison
from avahazard.results.diagnosis import Diagnosis
from avahazard.store import results as store
from avahazard.store.records import load_events, path_summaries
from avahazard.store.session import Session, reading
from avahazard.workflow.by_path import Survey, fingerprint_of, survey

OPTIONS = {"law": "exponential", "scatter": "constant", "distribution": "lognormal"}
OPTIONS |= {"tails": "normal", "method": "marginal", "forward": BLOCK}
"""Options of `calibrate` that a new calibration repeats where they are not these."""
SHARPER = 6.0
"""Evidence (nats) by which a law must lead its smooth to be the next step: fewer parameters alone
bring it some."""


def next_step(database: str, name: str, done: Collection[str] = ()) -> Note | None:
    """The step to do now with the model `name`; None where none is left.

    It is a command, with the reason in its value `why`. `done` are commands that have just been
    done and leave nothing in the database, such as `report`.
    """
    with reading(database) as session:
        return StoredModels(session, done).step(name)


def after_import(database: str) -> Note | None:
    """The step to do after an import; None where a calibration would be refused."""
    with reading(database) as session:
        stored = StoredModels(session)
        if stored.models:
            return stored.step(stored.best())
        kinds = {event.in_ratio for event in load_events(session)}
        lacking = any(path.n_events and not path.n_points for path in path_summaries(session))
        if len(kinds) != 1 or lacking:
            return None
        return _step(("calibrate", "base"), Note("why_calibrate"))


def latest_comparison(session: Session, name: str) -> Comparison | None:
    """The comparison of a model that is stored, None where there is none."""
    document = store.latest_result(session, store.COMPARISON, name)
    return None if document is None else Comparison.from_dict(document)


def latest_diagnosis(session: Session, name: str) -> Diagnosis | None:
    """The last diagnosis of a model that is stored, None where there is none."""
    document = store.latest_result(session, store.DIAGNOSIS, name)
    return None if document is None else Diagnosis.from_dict(document)


class StoredModels:
    """What is stored of all models, and what to do next with each."""

    def __init__(self, session: Session, done: Collection[str] = ()) -> None:
        self.session, self.done = session, done
        self.models = {model.name: model for model in store.list_models(session)}
        self.found = {n: Calibration.from_dict(m.result) for n, m in self.models.items()}
        self.today: dict[tuple[str, ...], str] = {}

    @cached_property
    def survey(self) -> Survey:
        """The records of today."""
        return survey(self.session)

    def worse(self, name: str) -> bool:
        """Whether a child is not to be kept: by its scores and its parent's on the same records."""
        child, parent = self.found[name], self.found.get(self.found[name].parent or "")
        if parent is None or parent.data_fingerprint != child.data_fingerprint:
            return False
        before = latest_comparison(self.session, parent.model)
        after = latest_comparison(self.session, name)
        return after is not None and before_and_after(before, after).worse

    def best(self) -> str:
        """The model to use among those on today's records, else on those of the latest model.

        The one of least held-out error, or its child where this is not worse; without scores the
        latest.
        """
        latest = self.found[next(reversed(self.models))].data_fingerprint
        names = [name for name in self.models if not self.stale(name)]
        names = names or [n for n in self.models if self.found[n].data_fingerprint == latest]
        compared = {name: latest_comparison(self.session, name) for name in names}
        error = {n: found.held_out.runout.crps_m for n, found in compared.items() if found}
        if not error:
            return names[-1]
        best, left = "", list(error)
        while left:
            best = min(left, key=lambda name: error[name])
            left = [n for n in error if self.found[n].parent == best and not self.worse(n)]
        return best

    def stale(self, name: str) -> bool:
        """Whether the records have changed since a model was calibrated."""
        paths = self.models[name].paths
        if paths not in self.today:
            found = fingerprint_of(self.session, paths) if paths else self.survey.fingerprint
            self.today[paths] = found
        return self.today[paths] != self.found[name].data_fingerprint

    def step(self, name: str) -> Note | None:
        """What to do now with a model."""
        found = self.found[name]
        if self.stale(name):
            best = self.best()
            if self.stale(best):
                return _step(self._calibrate(self.found[best]), Note("why_stale", model=best))
            return self._instead(best, "why_stale_of", model=name)
        if found.parent and self.worse(name):
            return self._instead(found.parent, "why_worse", model=name, parent=found.parent)
        if opened := self._open(found):
            return opened
        unclear = self._unclear(found)
        return self._answer(name) if unclear is None else self._either(unclear, name)

    def _of_other(self, name: str) -> Note | None:
        """The same with a model with which nothing has just been done."""
        self.done = ()
        return self.step(name)

    def _instead(self, other: str, key: str, **values: str) -> Note | None:
        """What to do now with another model than the one that was asked about."""
        step = self._of_other(other)
        why = step and Note(key, **values, why=step.values["why"])
        return step and Note("next", command=str(step), why=why)

    def _open(self, found: Calibration) -> Note | None:
        """What is not known yet of a model, or what its diagnosis asks for."""
        name, method = found.model, METHODS[found.method]
        diagnosis = latest_diagnosis(self.session, name) if method.knows_errors else None
        if diagnosis is not None:
            return self._by_verdict(diagnosis)
        if not method.in_metres and latest_comparison(self.session, name) is None:
            return self._with_files(("compare", name), Note("why_compare", model=name))
        if not method.knows_errors:
            return None
        return self._with_files(("diagnose", name), Note("why_diagnose", model=name))

    def _by_verdict(self, found: Diagnosis) -> Note | None:
        """What a diagnosis asks for; None where it asks for nothing that was not tried."""
        name, missing, near = found.model, list(found.missing), found.near
        likely = found.verdict == "ambiguous" and len(near) == 1
        effects: tuple[str, ...] = ()
        if found.pairs:
            effects = found.pairs[-1].effects
        elif found.verdict == "missing-effect" or likely:
            effects = tuple(near)
        elif found.verdict == "unexplained":
            effects = tuple(key for key in missing if _is_effect(found, key))
            if not effects:
                return _without_effect(found, missing)
        law, written = found.leading_law, found.effect_file
        if law is not None and written is not None:
            # Its law, which has been written, stands for the smooth.
            effects = tuple(law.effect if k == missing[0] else k for k in effects) or (law.effect,)
        if not effects:
            return None
        if tried := self._child(name, effects):
            return None if self.worse(tried) else self._of_other(tried)
        if written is None and law is not None and law.evidence_over_curve > SHARPER:
            # The smooth follows it too little to stand for it.
            lead = {"model": name, "effects": missing, "nats": law.evidence_over_curve}
            alike = [other.form for other in (found.lawful and found.lawful.laws) or ()]
            why = Note("why_write_law", law=law.effect, **lead)
            if len(alike) > 1:
                why = Note("why_write_laws", laws=alike, **lead)
            return self._with_files(("diagnose", name, "--write-effect", f"{name}-law.py"), why)
        child = store.free_name(f"{name}+{'+'.join(effects)}", self.models)
        why = Note("why_missing", model=name, effects=list(effects))
        if written is not None:
            why = Note("why_law", model=name, effects=missing, file=written)
            if found.verdict == "ambiguous":
                why = Note("why_each", model=name, effects=missing)
        if likely:
            why = Note("why_likely", model=name, effects=missing, effect=effects[0])
        files = self._own_files(name, effects)
        return _step(("add", name, *effects, "--as", child, *files), why)

    def _unclear(self, found: Calibration) -> Diagnosis | None:
        """The diagnosis that cannot tell what is missing: of a model, or of the one it stems from.

        Of the latter where the model has one of the effects that may be missing.
        """
        for name in (found.model, found.parent):
            told = latest_diagnosis(self.session, name or "")
            if told is None or told.verdict != "ambiguous" or told.pairs:
                continue
            near = told.near
            keys = [key for key in near if _is_effect(told, key)]
            children = [self._child(told.model, (key,)) for key in keys]
            if len(near) > 1 and found.model in (told.model, *children):
                return told
        return None

    def _either(self, found: Diagnosis, name: str) -> Note | None:
        """Where one of several effects is missing: add each, then average them.

        What to measure stands in the diagnosis; it is the step where there is nothing to average.
        """
        base, told = found.model, found.near
        children = {key: self._child(base, (key,)) for key in told if _is_effect(found, key)}
        if len(children) < 2:
            if not found.measure_next:
                return self._answer(name)
            best = found.measure_next[0]
            why = Note("why_measure", model=base, effects=told, nats=best.expected_gain)
            return Note("next", command=f"measure {best.measurement}", why=why)
        for key, child in children.items():
            if child is None:
                new = store.free_name(f"{base}+{key}", self.models)
                why = Note("why_each", model=base, effects=told)
                if name != base:
                    why = Note("why_instead", child=name, model=base, effect=key)
                words = ("add", base, key, "--as", new, *self._own_files(base, (key,)))
                return _step(words, why)
        names = [child for child in children.values() if child is not None]
        averaged = store.latest_run(self.session, store.AVERAGE, names[0]) is not None
        if averaged or "hazard" in self.done or not self.survey.with_profile:
            return self._report(names[0])
        words = ("hazard", *names, *self._own_files(base))
        return _step(words, Note("why_average", model=base, effects=told))

    def _answer(self, name: str) -> Note | None:
        """The answers by a model that is good enough, first those that are not there yet."""
        if self.models[name].specification["specification"].get("forward", BLOCK) != BLOCK:
            words = ("map", name, "-o", f"{name}.tif")
            return self._with_files(words, Note("why_map", model=name))
        stored = store.latest_run(self.session, store.BOUNDS, name) is not None
        if self.survey.with_profile and not (stored or "hazard" in self.done):
            return self._with_files(("hazard", name), Note("why_hazard", model=name))
        return self._report(name)

    def _report(self, name: str) -> Note | None:
        if "report" in self.done:
            return None
        words = ("report", name, "-o", f"{name}.html")
        why = "why_report" if self.survey.with_profile else "why_report_alone"
        return self._with_files(words, Note(why, model=name))

    def _child(self, name: str, effects: Sequence[str]) -> str | None:
        """The latest child that has these effects more, on today's records."""
        before = set(self.models[name].effects)
        for child in reversed(self.models.values()):
            more = set(child.effects) - before
            if child.parent == name and more == set(effects) and not self.stale(child.name):
                return child.name
        return None

    def _calibrate(self, found: Calibration) -> tuple[str, ...]:
        """The command that makes a model of the same kind on the records of today."""
        words = ["calibrate", store.free_name(found.model, self.models)]
        for key, usual in OPTIONS.items():
            if (value := getattr(found, key)) != usual:
                words += [f"--{key}", value]
        words += [word for key in found.effects for word in ("--with", key)]
        words += [] if found.centrifugal else ["--without", CENTRIFUGAL.key]
        paths = self.models[found.model].paths
        return (*words, *(word for path in paths for word in ("--path", path)))

    def _own_files(self, name: str, more: Sequence[str] = ()) -> tuple[str, ...]:
        """Options that name the effect files of a model with `more` effects.

        Of those that diagnoses were given, or have written.
        """
        effects, files = {*self.models[name].effects, *more}, dict[str, str]()
        for other in self.models if more or self.models[name].effect_sha256 else ():
            if found := latest_diagnosis(self.session, other):
                files |= {key: file for key, file in found.effect_files.items() if key in effects}
        return tuple(word for file in files.values() for word in ("--effect-file", file))

    def _with_files(self, words: Sequence[str], why: Note) -> Note:
        """A command on the model `words[1]`, with its effect files."""
        return _step((*words, *self._own_files(words[1])), why)


def _without_effect(found: Diagnosis, missing: Sequence[str]) -> Note:
    """What to do where a model fails along something, and no effect is named."""
    if any(note.key == "speeds_off" for note in found.notes):
        why = Note("why_speeds_off", model=found.model)
        return Note("next", command="measure speeds in another way", why=why)
    why = Note("why_unexplained", model=found.model, along=missing)
    return _step(("effect", "new", f"{found.model}-effect.py"), why)


def _step(words: Sequence[str], why: Note) -> Note:
    return Note("next", command=shlex.join(("avahazard", *words)), why=why)


def _is_effect(found: Diagnosis, key: str) -> bool:
    """Whether what a diagnosis names can be added, as one of the user's own or of the catalogue."""
    if key in found.effect_files:
        return True
    try:
        definition(key)
    except AvahazardError:
        return False
    return True
