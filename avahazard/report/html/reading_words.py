"""How to read the figures of the paths, in words."""

from __future__ import annotations

from collections.abc import Sequence

from avahazard.report.html.content import PathView
from avahazard.report.language import ENGLISH, Language


def reading_words(
    views: Sequence[PathView], *, stops: bool = False, language: Language = ENGLISH
) -> list[str]:
    """How to read the figures of the paths: of what they hold, once for all."""
    say = language.say
    rows = [row for view in views for row in view.rows]
    words = []
    if any(row.get("design") for row in rows):
        words.append(
            say(
                "Thick bars above the ground hold 90 % of what the runout exceeded once in the "
                "return period may be; the tick is its median."
            )
        )
    if rows:
        words.append(
            say(
                "Thin lines hold 90 % of avalanches of one volume (that of the return period, or a "
                "given one), and the humps on them are their distribution; the small tick is their "
                "median. A bar that ends at the edge goes on beyond the profile."
            )
        )
    if stops:
        words.append(
            say(
                "Under the profile every record has a line: the tick is where it stopped, the "
                "bar holds 90 % of where the model shown expects it, the grey one behind it that "
                "of the parent, if it has one."
            )
        )
    if any(view.alpha_beta for view in views):
        words.append(
            say(
                "Stars: the α-β runout, from the shape of the ground alone, with one standard "
                "deviation."
            )
        )
    if any(view.zones for view in views):
        words.append(
            say(
                "The strip at the foot shows the zones. Speeds are those that a year exceeds with "
                "chance 1/T: the median full, 95 % dashed, 5 % dotted; hover for the pressure."
            )
        )
    elif any(view.speeds for view in views):
        words.append(say("Speeds are those of the block of median friction at that volume."))
    if any(row.get("reach") for row in rows):
        words.append(
            say(
                "The lowest panel gives the chance that an avalanche comes as far in a year, and "
                "90 % of what that may be."
            )
        )
    return words
