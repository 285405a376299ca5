"""Blocks of ```math as MathML, which browsers draw by themselves, without a network."""

from __future__ import annotations

import re

from latex2mathml.converter import convert

BLOCK = re.compile(r"^```math\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def with_equations(markdown: str) -> str:
    """Return the page with each block of LaTeX (one equation a line) as MathML."""
    return BLOCK.sub(_drawn, markdown)


def _drawn(block: re.Match[str]) -> str:
    lines = [line for line in block[1].splitlines() if line.strip()]
    equations = "".join(convert(line, display="block") for line in lines)
    return f'<div class="equation">{equations}</div>'
