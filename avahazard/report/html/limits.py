"""What is assumed, and where that ends: true of every model of this kind."""

from __future__ import annotations

from avahazard.inference.model.choices import METHODS
from avahazard.report.html.content import ReportContent


def assumptions(content: ReportContent) -> list[str]:
    """Assumptions of the model, its data and its bounds, a sentence or two each."""
    model, language = content.model, content.language
    say = language.say
    words = [
        say(
            "The avalanche is one block on one line. It does not spread, branch or pile up, and a "
            "runout is a point on that line, not an outline on the map."
        ),
        say(
            "The path is the smoothed profile. What dams, new forest or other works change is not "
            "in it."
        ),
        say(
            "Recorded volumes and runouts are taken with the errors that the records state. An "
            "avalanche that nobody recorded is not in the model, unless a limit of sight was given."
        ),
    ]
    design = next((row["design"] for row in content.rows if row.get("design")), None)
    if design is not None:
        words.append(
            say(
                "The design runout of a return period mixes avalanches of all volumes, as often "
                "as they come. Its interval: {interval}.",
                interval=language.told(design["interval"]),
            )
        )
    if content.rows:
        each = dict.fromkeys(language.told(row["interval"]) for row in content.rows)
        words.append(
            say(
                "The runout of a volume lets friction vary. Its interval: {interval}.",
                interval="; ".join(each),
            )
        )
    if any(row["return_period_years"] is not None for row in content.rows):
        words.append(
            say(
                "The climate, the forest and the way of recording are taken to be the same in the "
                "future as in the observed years."
            )
        )
    if METHODS[model.method].in_metres:
        words.append(
            say(
                "This model's scatter is in metres of elevation and holds all errors at once: "
                "natural scatter, errors of the records and of the model."
            )
        )
    speeds = any(view.speeds or view.zones for view in content.paths)
    if speeds and not content.speed_limited:
        words.append(
            say(
                "The model has no drag: nothing but friction limits its speeds, so that they are "
                "too high where a path is steep and long, and so are pressures."
            )
        )
    if any(view.alpha_beta for view in content.paths):
        words.append(
            say(
                "The α-β runouts are regressions of other regions' extreme avalanches on the "
                "shape of the ground. They know nothing of the records here."
            )
        )
    words.append(
        say(
            "A report is no permit: a line on a map is for those who know the place, its history "
            "and its use."
        )
    )
    return words


def zone_words(content: ReportContent) -> list[str]:
    """What the zones and their pressures mean."""
    zones = [view.zones for view in content.paths if view.zones]
    if not zones:
        return []
    language, density = content.language, zones[0]["density_kg_m3"]
    return [
        language.say(
            "Zones by the limits “{limits}”. Pressure is ρu², with a density of {mean} ± {sd} "
            "kg/m³. Speeds and pressures: {interval}.",
            limits=language.told(zones[0]["limits"]),
            mean=f"{density['mean']:.0f}",
            sd=f"{density['sd']:.0f}",
            interval=language.told(zones[0]["interval"]),
        )
    ]
