"""`avahazard paths`."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from typer.testing import Result

Run = Callable[..., Result]


def test_no_paths_yet(avahazard: Run) -> None:
    assert "There are no paths:" in avahazard("paths").stdout
    assert json.loads(avahazard("--json", "paths").stdout) == []


def test_paths_with_their_events(avahazard: Run, write: Callable[[str, str], Path]) -> None:
    write("paths.csv", "path_id,name,section\nQ [x],Quarry,open\n")
    write(
        "profiles.csv",
        "path_id,x_m,y_m\n" + "".join(f"P,{100 * i},{1000 - 90 * i}\n" for i in range(6)),
    )
    events = "event_id,path_id,date,runout_x_m,volume_m3,left_profile\n"
    file = write("events.csv", events + "a,P,1950,300,5000,\nb,P,1931,,900,1\nc,P,,200,,\n")
    avahazard("import", str(file.parent))
    quarry, path = json.loads(avahazard("--json", "paths").stdout)
    assert (quarry["name"], quarry["section"], quarry["drop_m"]) == ("Quarry", "open", None)
    assert path == {
        "path_id": "P",
        "name": None,
        "section": None,
        "n_points": 6,
        "top_m": 1000.0,
        "drop_m": 450.0,
        "length_m": 500.0,
        "n_events": 3,
        "n_left_profile": 1,
        "first_year": 1931,
        "last_year": 1950,
        "volume_min_m3": 900.0,
        "volume_max_m3": 5000.0,
    }
    shown = avahazard("paths").stdout
    assert "Q [x]" in shown
    assert max(map(len, shown.splitlines())) <= 80
