"""A calibrated model as the database keeps it, before it is put on records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.effect import Definition, Facts
from avahazard.inference.likelihood.assemble import build_effects, definitions_of, find_definition
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.choices import MethodName
from avahazard.inference.model.given_prior import GivenPrior
from avahazard.inference.model.law_prior import prior_from_document
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.prediction.fitted_model import FittedModel, fitted_model
from avahazard.records.errors import AvahazardError
from avahazard.results.calibration import Calibration
from avahazard.store.models import StoredModel, load_model
from avahazard.store.results import latest_calibration, load_draws
from avahazard.store.session import Session

COORDINATE, OFFSET = "coordinate:", "offset:"
"""How the draws of coordinates and path offsets are told from readable ones in the store."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Fit:
    """A stored model, fitted to events of the database.

    `own` are definitions from the user's file, given again; `fingerprint` is that of the records
    that it was calibrated on, `version` that of the program that made it.
    """

    name: str
    model: FittedModel
    own: tuple[Definition, ...]
    fingerprint: str
    result: Calibration
    version: str | None = None

    @property
    def specification(self) -> Specification:
        """What the model is made of."""
        return self.model.specification

    @property
    def definitions(self) -> tuple[Definition, ...]:
        """What its effects are."""
        return definitions_of(self.specification, self.own)

    @property
    def method(self) -> MethodName:
        """The method of the calibration."""
        return self.model.method


@dataclass(frozen=True, slots=True, eq=False)
class KeptModel:
    """What is stored of a calibrated model; `paths` are those of its calibration, none: all."""

    parent: str | None
    specification: Specification
    own: tuple[Definition, ...]
    facts: dict[str, Facts]
    paths: tuple[str, ...]
    grids: dict[str, tuple[float, ...]]
    slots: list[str]
    method: MethodName
    draws: dict[str, Floats]
    fingerprint: str
    result: Calibration
    version: str | None

    def on(self, observations: Observations) -> FittedModel:
        """The model fitted to the events that it was calibrated on."""
        posterior = Posterior(
            observations,
            self.specification,
            build_effects(self.specification, self.facts, self.own),
            self.grids,
        )
        fitted = fitted_model(
            posterior,
            self.slots,
            np.column_stack([self.draws[f"{COORDINATE}{slot}"] for slot in self.slots]),
            {k.removeprefix(OFFSET): v for k, v in self.draws.items() if k.startswith(OFFSET)},
            self.method,
        )
        # The paper's methods take volumes as exact.
        return fitted if self.method == "marginal" else fitted.on(observations)


def load_kept(session: Session, name: str, own: Sequence[Definition]) -> KeptModel:
    """What is stored of the model `name`; `own` are the effects of the user's file.

    Raises `AvahazardError` where there is no such model, or its own effects are not given.
    """
    model = load_model(session, name)
    calibration = latest_calibration(session, name)
    kept = model.specification
    fields = kept["specification"]
    specification = Specification(
        **{
            **fields,
            "effects": tuple(fields["effects"]),
            "prior": prior_from_document(fields.get("prior")),
            "given": tuple(GivenPrior(**told) for told in fields.get("given", ())),
        }
    )
    _require_own(model, specification, own)
    return KeptModel(
        parent=model.parent,
        specification=specification,
        own=tuple(own),
        facts=kept["facts"],
        paths=tuple(kept["paths"]),
        grids={key: tuple(grid) for key, grid in kept["grids"].items()},
        slots=kept["slots"],
        method=kept["method"],
        draws={key: v.ravel() for key, v in load_draws(session, calibration.id).items()},
        fingerprint=calibration.data_fingerprint,
        result=Calibration.from_dict(calibration.result),
        version=version_of(calibration.settings),
    )


def version_of(settings: Mapping[str, Any]) -> str | None:
    """The version of the program that made a calibration; None where it was not kept."""
    versions: dict[str, str] = (settings.get("made_with") or {}).get("versions", {})
    return versions.get("avahazard")


def _require_own(
    model: StoredModel, specification: Specification, own: Sequence[Definition]
) -> None:
    for key in specification.effects:
        try:
            find_definition(key, own)
        except AvahazardError as error:
            if model.effect_file is None:
                raise
            raise AvahazardError(
                f"The model {model.name} has the effect '{key}' from its user's file.",
                "Name that file again: --effect-file FILE. It is never run from the database.",
            ) from error
