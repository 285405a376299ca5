"""The words of a part of the page."""

from __future__ import annotations

import html
import re

from avahazard.report.html.content import ReportContent
from avahazard.report.html.page import render


def section_words(content: ReportContent, key: str) -> str:
    """The text of the page's section of that id, without marks and scripts, in one line."""
    (part,) = re.findall(rf'<section id="{key}">(.*?)</section>', render(content), re.DOTALL)
    part = re.sub(r"<script.*?</script>", "", part, flags=re.DOTALL)
    return " ".join(html.unescape(re.sub(r"<[^>]*>", " ", part)).split())
