"""The page of what came out on real records: docs/real-data.md."""

from __future__ import annotations

from typing import Any

HEAD = """# Real records: the loop end to end

Three sets of real records, none of them made for this project, none part of it. Written by
`make real-data`, as it came out, good or bad.

Fixed before the run: a third of the events, drawn at random with one seed, is kept back from
everything: calibration, diagnosis and regressions see two thirds. The figure that judges is the
**CRPS of the runouts of that third** (mean error in metres that counts the width of the forecast
too). The loop: calibrate the power law, `diagnose`, `add` the one effect or column that it names,
and so on, twice at most. Four sensor tracks are too few for a third: there each path is held out
in turn.

Not fixed before: that the loop adds a column where the verdict is `unexplained`, as well as an
effect where it is `missing-effect`. That rule was chosen after the first run on the slides was
seen, so that what the slides gain by it is no test of the rule. Data, split and figure were not
changed.

Beside it stands a plain regression of log(H/L) by least squares, with Student's t, on the same two
thirds; the mean slope enters as a cubic.
"""

TITLES = {
    "rock-avalanches-canada": "Rock avalanches of Canada",
    "submarine-slides": "Slides of the sea floor",
    "avanodes": "Sensors inside avalanches",
}
SOURCES = {
    "rock-avalanches-canada": """\
49 rock avalanches with height of fall, reach, volume, confinement, substrate and geology (Mitchell
and others 2019, Landslides; repository admitchell/PRE-RA). `--expect covariate:confinement` was
declared before the run. The area of the deposit is a column too, although nobody knows it
beforehand.

Known before: over all 49 events a regression of log10(H/L) on log10(V) has a slope of about
-0.085, lateral confinement lowers it by about 0.10 (p about 0.01), and substrate does nothing (p
about 0.9). The authors predict runout by regressions on these events, with the scatter about them.
""",
    "submarine-slides": """\
558 slides of the Mediterranean, H/L down to 0.002, volumes over seven decades (Urgeles and
Camerlenghi 2013, JGR Earth Surface; as compiled in zanejobe/S4SlideDB). Nothing was declared.

The authors' abstract is of causes and sizes, which differ by tectonic setting; of runout it gives
no law to set beside this. The mean slope of a slide is close to its H/L in another form (their
logs correlate by 0.87), so that it tells much is no discovery: the test is whether it is found, and
used as well as a regression does.
""",
    "avanodes": """\
Four sensors carried along inside small avalanches (Neuhauser and others 2023, Annals of
Glaciology), with speeds every 10 m; their own page is [measured speeds](avanodes.md). A regression
of the measured force on the square of speed gives -0.003 ± 0.003 1/m: the force asks for no drag.
""",
}


def page(found: dict[str, Any]) -> str:
    """All sections of what was kept, in their order."""
    parts = [HEAD]
    for name, title in TITLES.items():
        if name in found:
            parts += [f"## {title}\n", SOURCES[name], *_section(found[name])]
    return "\n".join(parts).rstrip() + "\n"


def _section(found: dict[str, Any]) -> list[str]:
    kept = found["rounds"][0]["kept"]
    learnt = found["n_events"]
    if kept is None:
        return [_verdicts(found), _speeds(found), ""]
    told = f"Learnt from {learnt} events, judged by {kept['runout']['n']}.\n"
    return [told, _verdicts(found), _scores(found), _in_words(found), _regressions(found)]


def _verdicts(found: dict[str, Any]) -> str:
    lines = [
        "| model | verdict | named | leading: gain in nats, p of the best of all, p alone |",
        "|---|---|---|---|",
    ]
    for k, one in enumerate(found["rounds"]):
        verdict = one["diagnosis"]
        best = "; ".join(
            f"{c['effect']} {c['gain']:.1f}, {_p(c['p_value'])}, {_p(c['p_value_alone'])}"
            for c in verdict["candidates"][:3]
        )
        named = ", ".join(verdict["missing"]) or "–"
        lines.append(f"| {_name(found, k)} | `{verdict['verdict']}` | {named} | {best} |")
    text = "\n".join(lines) + "\n"
    worst = found["rounds"][0]["diagnosis"]["impossible_stops"]
    if worst:
        text += f"\nStops on ground too steep for any block: {', '.join(worst)}.\n"
    return text


def _scores(found: dict[str, Any]) -> str:
    lines = [
        "| | CRPS of the third kept back, m | in 90 % | log density | CRPS by folds, m |",
        "|---|---|---|---|---|",
    ]
    rows = [(_name(found, k), one) for k, one in enumerate(found["rounds"])]
    if "declared" in found:
        rows.append((f"with {', '.join(found['expect'])}, as declared", found["declared"]))
    for name, one in rows:
        runout = one["kept"]["runout"]
        folds = one["compare"]["held_out"]["runout"]["crps_m"]
        lines.append(
            f"| {name} | {runout['crps_m']:,.0f} | {runout['coverage_90']:.0%} | "
            f"{one['kept']['elpd_loo']:.1f} | {folds:,.0f} |"
        )
    for one in found["regressions"]:
        lines.append(
            f"| regression on {one['name']} | {one['crps_m']:,.0f} | {one['coverage_90']:.0%} | "
            f"{one['elpd']:.1f} | – |"
        )
    return "\n".join(lines) + "\n"


def _in_words(found: dict[str, Any]) -> str:
    first, last = found["rounds"][0], found["rounds"][-1]
    before = first["kept"]["runout"]["crps_m"]
    words = []
    if first is last:
        words.append("The loop named nothing, so nothing was added.")
    else:
        words.append(_change("The loop's last model", before, last["kept"]["runout"]["crps_m"]))
    if "declared" in found:
        after = found["declared"]["kept"]["runout"]["crps_m"]
        words.append(_change("What was declared, added whatever the verdict,", before, after))
    best = min(found["regressions"], key=lambda one: one["crps_m"])
    words.append(f"The best of the regressions has {best['crps_m']:,.0f} m.")
    return " ".join(words) + "\n"


def _change(what: str, before: float, after: float) -> str:
    verb = "lowers" if after < before else "raises"
    return f"{what} {verb} the CRPS of the third by {abs(after - before) / before:.1%}."


def _regressions(found: dict[str, Any]) -> str:
    lines = ["| regression | coefficients on log(H/L) | all but log V: p |", "|---|---|---|"]
    for one in found["regressions"]:
        terms = ", ".join(
            f"{name} {c['value']:.3f} ± {c['se']:.3f}"
            for name, c in one["coefficients"].items()
            if name != "1"
        )
        p = one["p_extra"]
        lines.append(f"| {one['name']} | {terms} | {'–' if p is None else _p(p)} |")
    return "\n".join(lines) + "\n"


def _speeds(found: dict[str, Any]) -> str:
    lines = [
        "| each path held out | CRPS of speed, m/s | in 90 % | CRPS of runout, m | in 90 % |",
        "|---|---|---|---|---|",
    ]
    for k, one in enumerate(found["rounds"]):
        held = one["compare"]["held_out"]
        speed, runout = held["speed"], held["runout"]
        lines.append(
            f"| {_name(found, k)} | {speed['crps_m_s']:.1f} | {speed['coverage_90']:.0%} | "
            f"{runout['crps_m']:.0f} | {runout['coverage_90']:.0%} |"
        )
    witnesses = [
        f"{c['effect']} {c['force_witness']['value']:.2g} ± {c['force_witness']['se']:.2g}"
        for c in found["rounds"][0]["diagnosis"]["candidates"]
        if c["force_witness"] is not None
    ]
    told = f"\nWhat the measured force says of each effect: {'; '.join(witnesses)}.\n"
    return "\n".join(lines) + "\n" + (told if witnesses else "")


def _name(found: dict[str, Any], k: int) -> str:
    """The model of a round by what was added to get there."""
    law = f"{found['law']} law"
    added = [key for one in found["rounds"][:k] for key in one["diagnosis"]["missing"]]
    return f"{law} with {', '.join(added)}" if added else law


def _p(value: float) -> str:
    return "< 0.001" if value < 0.001 else f"{value:.3f}"
