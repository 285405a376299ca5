"""What a model would lose without each of its effects."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from avahazard.criticism.diagnosis import still_needed as module
from avahazard.inference.model.specification import Specification

EVIDENCE = {("season",): -12.0, ("snow-type",): -9.0}


def test_a_loss_is_what_the_others_alone_lack(monkeypatch: pytest.MonkeyPatch) -> None:
    def refit(_observations: Any, specification: Specification, *_: Any) -> Any:
        return SimpleNamespace(evidence=EVIDENCE[specification.effects])

    monkeypatch.setattr(module, "refit", refit)
    specification = Specification(effects=("snow-type", "season"))
    whole: Any = SimpleNamespace(evidence=-10.0, specification=specification, facts={})
    observations: Any = None
    lost = module.still_needed(observations, (), whole)
    assert lost == {"snow-type": 2.0, "season": -1.0}
