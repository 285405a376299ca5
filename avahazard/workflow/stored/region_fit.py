"""A stored model to be applied path by path, without the records of the region in memory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from avahazard.effects.effect import Definition
from avahazard.inference.likelihood.assemble import definitions_of
from avahazard.inference.model.observations import observations_without_ground, require_profiles
from avahazard.records.event import Event
from avahazard.records.lookup import only_paths, paths_to_run, unknown_path
from avahazard.store.records import load_without_profiles
from avahazard.store.session import reading
from avahazard.workflow.stored.fit import Fit, load_kept
from avahazard.workflow.stored.survey import Survey, any_events, fingerprint_of, survey


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class RegionFit(Fit):
    """A stored model with what is held of the records of the database, all of one moment.

    Its own events have no ground (`observations_without_ground`). `others` stand for the events
    of a path without any, where the model takes columns of the event.
    """

    survey: Survey
    records_changed: bool
    others: tuple[Event, ...]

    def paths_to_run(self, named: Sequence[str]) -> list[str]:
        """The paths that are named, or all with a profile. Raises as `lookup.paths_to_run`."""
        return paths_to_run(list(self.survey.digests), self.survey.with_profile, named)


def load_region_fit(database: str, name: str, own: Sequence[Definition] = ()) -> RegionFit:
    """The model `name` for work path by path; raises as `load_stored`."""
    with reading(database) as session:
        kept = load_kept(session, name, own)
        found = survey(session)
        for path_id in kept.paths:
            if path_id not in found.digests:
                raise unknown_path(path_id, list(found.digests))
        training = only_paths(load_without_profiles(session, kept.paths), kept.paths)
        today = fingerprint_of(session, kept.paths) if kept.paths else found.fingerprint
        by_columns = any(e.event_columns for e in definitions_of(kept.specification, kept.own))
        others = any_events(session) if by_columns else ()
    used = dict.fromkeys(e.path_id for e in training.events if e.path_id is not None)
    require_profiles(path_id for path_id in used if path_id not in found.with_profile)
    model = kept.on(observations_without_ground(training))
    return RegionFit(
        name=name,
        model=model,
        own=kept.own,
        fingerprint=kept.fingerprint,
        result=kept.result,
        version=kept.version,
        survey=found,
        records_changed=today != kept.fingerprint,
        others=others,
    )
