"""The overview of a batch: at every width of a terminal, and as a page."""

from __future__ import annotations

from io import StringIO
from pathlib import Path

import pytest
from needs import need
from report import browser
from rich.cells import cell_len
from rich.console import Console

from gcodesim.report.overview import ProgramRow as Row
from gcodesim.report.overview import print_overview
from gcodesim.report.overview_page import overview_page

LONG = "GC402 B is no axis here: the machine file has no such axis; add it or ignore_words of it"
ROWS = [
    Row("samples/arc_into_trunnion.nc", "table_tilt", "", "fail", 0.0, "cutter-A", 4.6, LONG, 16),
    Row("samples/tcp_nutating_head.nc", "table_tilt", "", "inconclusive", None, "", 0.0, LONG, 10),
    Row("samples/tcp_spindle_into_table.nc", "table_tilt", "", "pass", 203.531, "cutter-C", 5.9),
]


def printed(rows: list[Row], width: int) -> list[str]:
    """Lines of the overview on a terminal."""
    out = StringIO()
    print_overview(rows, Console(file=out, width=width))
    return out.getvalue().splitlines()


@pytest.mark.parametrize("width", [80, 100, 120, 140, 160, 1000])
def test_no_width_hides_what_a_row_says(width: int) -> None:
    lines = printed(ROWS, width)
    assert all(cell_len(line) <= width for line in lines)
    heads = [line for line in lines if line.startswith(("FAIL", "INCONCLUSIVE", "PASS"))]
    assert [head.split()[0] for head in heads] == ["FAIL", "INCONCLUSIVE", "PASS"]
    for row, head in zip(ROWS, heads, strict=True):
        assert row.program[-16:] in head
        assert row.machine in head
        assert f"{row.cycle_s} " in f"{head} "
        assert row.clearance_mm is None or f"{row.clearance_mm:.3f} {row.pair}" in head
    words = " ".join(" ".join(lines).split())
    assert words.count("GC402 B is no axis") == 2
    if width <= 80 or width == 1000:  # below its row, or on one line
        assert words.count(f"line 16: {LONG}") == 1


def test_of_many_programs_the_ones_to_look_at_are_shown() -> None:
    passing = [Row(f"{n}.nc", "m", "", "pass") for n in range(60)]
    waived = Row("waived.nc", "m", "", "pass", 0.0, ignored="1 contact ignored (comment: dummy)")
    lines = printed([*ROWS, waived, *passing], 160)
    shown = [line for line in lines if ".nc" in line]
    assert len(shown) == 3
    assert shown[-1].endswith("1 contact ignored (comment: dummy)")


def test_no_word_of_the_page_is_broken(tmp_path: Path) -> None:
    program = browser.find()
    need(program, "chromium-headless-shell")
    file = tmp_path / "overview.html"
    file.write_text(overview_page(ROWS, "1.2.3", ["--stop all", "--ignore <b>"], tmp_path))
    with browser.Browser(program) as page:
        size = {"width": 1400, "height": 900, "deviceScaleFactor": 1, "mobile": False}
        page.ask("Emulation.setDeviceMetricsOverride", **size)
        page.ask("Page.navigate", url=file.as_uri())
        page.wait("document.querySelectorAll('tbody tr').length === 3")
        broken = page.value(
            "[...document.querySelectorAll('td')].flatMap(cell => [...cell.childNodes])"
            ".flatMap(node => [...node.textContent.matchAll(/[^ ]+/g)].filter(word => {"
            " const range = document.createRange(); range.setStart(node, word.index);"
            " range.setEnd(node, word.index + word[0].length);"
            " return range.getClientRects().length > 1; }).map(word => word[0]))"
        )
        assert broken == []
        assert page.value("document.body.scrollWidth") <= 1400
        told = page.value("document.querySelector('p').textContent")
        assert told.endswith(" UTC, gcodesim 1.2.3, with --stop all --ignore <b>")
        assert not page.errors
