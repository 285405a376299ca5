"""The second part of the demo in words: what was hidden, what was named, what came of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from rich.console import Console
from rich.padding import Padding

from avahazard.cli.comparison_table import fall_of_error, unit_words
from avahazard.report.verdict_words import verdict_words
from avahazard.results.diagnosis import Diagnosis
from avahazard.results.made import HiddenEffect


def show_loop(console: Console, found: HiddenEffect) -> None:
    """Print the loop as it went, whatever came out."""
    console.print(
        f"\nA made world: {found.model.n_events} events on {found.n_paths} paths, with an effect "
        "that its first model is not told of."
    )
    for k, line in enumerate(_story(found), 1):
        console.print(Padding(f"{k}. {line}", (0, 0, 0, 2), expand=False))


def last_model(found: HiddenEffect) -> str:
    """The model that the loop ends with."""
    return (found.child or found.model).model


def _story(found: HiddenEffect) -> Iterator[str]:
    model, by = found.model.model, "paths" if found.held_out.by == "path" else "folds"
    yield (
        f"“{model}” is calibrated without it. Its error, on {by} held out: "
        f"{found.held_out.runout.crps_m:.1f} m (CRPS in {unit_words(found.coordinate)})."
    )
    told = replace(found.diagnosis, where=())
    yield f"{verdict_words(told, f'“{model}”')}{_evidence(told)}"
    yield from found.diagnosis.where
    child = found.child
    if child is None or child.comparison is None:
        yield "No single effect is named, so none is added."
    else:
        added = ", ".join(key for key in child.effects if key not in found.model.effects)
        yield f"“{child.model}” is “{model}” with {added}. {fall_of_error(child.comparison)}"
    hidden = ", ".join(found.hidden)
    named = set(found.diagnosis.missing)
    right = found.diagnosis.verdict == "missing-effect" and named == set(found.hidden)
    if right:
        yield f"The world was made with {hidden}: the diagnosis is right."
    elif named & set(found.hidden):
        yield f"The world was made with {hidden}: it is among what was named, not alone."
    else:
        yield f"The world was made with {hidden}: the diagnosis did not find it."


def _evidence(diagnosis: Diagnosis) -> str:
    best = next((c for c in diagnosis.candidates if c.effect in diagnosis.missing), None)
    if best is None:
        return ""
    floor = 1.0 / (diagnosis.n_worlds + 1)
    p = f"p = {best.p_value:.2f}"
    if best.p_value <= floor:
        p = f"p < 1/{diagnosis.n_worlds + 1}"
    return f" By chance: {p}, from {diagnosis.n_worlds} worlds in which nothing is missing."
