"""Limits of one's own."""

from __future__ import annotations

from pathlib import Path

import pytest

from avahazard.hazard.zones.limits import FRENCH, SWISS, Rule, ZoneLimits, ZoneSystem, read_limits
from avahazard.records.errors import AvahazardError

GOOD = """
[[zone]]
name = "red"
color = "#C8102E"
[[zone.rule]]
return_period_years = 300
pressure_kpa_min = 30
[[zone.rule]]
return_period_years = 30.0

[[zone]]
name = "blue"
color = "#0072b2"
rule = [{ return_period_years = 300 }]
"""


def test_the_zones_of_a_file() -> None:
    assert read_limits("own.toml", GOOD) == ZoneSystem(
        "own.toml",
        (
            ZoneLimits("red", "#c8102e", (Rule(300.0, 30.0), Rule(30.0, 0.0))),
            ZoneLimits("blue", "#0072b2", (Rule(300.0, 0.0),)),
        ),
    )


def test_the_example_of_the_documentation() -> None:
    page = (Path(__file__).resolve().parents[3] / "docs" / "zones.md").read_text(encoding="utf-8")
    text = page.split('```toml title="valley.toml"\n')[1].split("```")[0]
    found = read_limits("valley.toml", text)
    assert [len(zone.rules) for zone in found.zones] == [2, 1]


def test_the_return_periods_of_limits() -> None:
    assert SWISS.return_periods == (30.0, 300.0)
    assert FRENCH.return_periods == (100.0, 300.0)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[[zone]]\n", "[[zone\n", "own.toml is not a TOML file"),
        (GOOD, "", "own.toml, zone: Field required"),
        (GOOD, "zone = []", "own.toml, zone: List should have at least 1 item"),
        (
            "return_period_years = 300\n",
            "return_period_years = 1\n",
            r"own.toml, zone 1, rule 1, return_period_years: Input should be greater than 1",
        ),
        (
            "pressure_kpa_min = 30",
            'pressure_kpa_min = "30"',
            r"zone 1, rule 1, pressure_kpa_min: Input should be a valid number \(given: '30'\)",
        ),
        ("pressure_kpa_min = 30", "pressure_kpa_min = -1", "pressure_kpa_min: .* \\(given: -1\\)"),
        ("pressure_kpa_min", "presure_kpa_min", "zone 1, rule 1, presure_kpa_min: Extra inputs"),
        ("return_period_years = 30.0", "pressure_kpa_min = 3", "rule 2, return_period_years: F"),
        ('color = "#0072b2"', 'color = "blue"', "zone 2, color: String should match pattern"),
        ("rule = [{ return_period_years = 300 }]", "rule = []", "zone 2, rule: List should have"),
        ('name = "blue"', 'name = "red"', "own.toml has two zones 'red'"),
    ],
)
def test_one_message_that_says_where(old: str, new: str, message: str) -> None:
    with pytest.raises(AvahazardError, match=message) as caught:
        read_limits("own.toml", GOOD.replace(old, new, 1))
    assert caught.value.hint


def test_the_limits_of_two_countries() -> None:
    def told(limits: ZoneSystem) -> dict[str, list[tuple[float, float]]]:
        return {
            zone.name: [(rule.return_period_years, rule.pressure_kpa_min) for rule in zone.rules]
            for zone in limits.zones
        }

    assert told(SWISS) == {"red": [(300.0, 30.0), (30.0, 0.0)], "blue": [(300.0, 0.0)]}
    assert told(FRENCH) == {
        "red": [(100.0, 30.0)],
        "blue": [(100.0, 0.0)],
        "yellow": [(300.0, 0.0)],
    }
