"""The overview of a batch as one HTML page that needs no other file and no network."""

from __future__ import annotations

import os
from collections.abc import Sequence
from datetime import UTC, datetime
from html import escape
from pathlib import Path, PurePath
from urllib.parse import quote

from gcodesim.checking.verdict import CONTRACT
from gcodesim.findings.printing import printable
from gcodesim.report.overview import ProgramRow, cells, columns, headline

_PAGE = """<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<meta http-equiv="Content-Security-Policy"
 content="default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'">
<title>{count}</title>
<style>
:root {{ color-scheme: light dark; font: 14px/1.5 system-ui, sans-serif }}
body {{ margin: 2rem }}
table {{ border-collapse: collapse; width: 100% }}
th, td {{ text-align: left; padding: .25rem .75rem; border-bottom: 1px solid #8884 }}
th button {{ all: unset; cursor: pointer; font-weight: 600 }}
td {{ vertical-align: top }}
th, td:nth-child(1), td:nth-child(4), td:nth-child(5) {{ white-space: nowrap }}
td:last-child {{ overflow-wrap: anywhere; min-width: 20rem }}
td:nth-child(5) {{ text-align: right; font-variant-numeric: tabular-nums }}
td:first-child {{ font-weight: 600; color: #b71c1c }}
.pass td:first-child {{ color: #2e7d32 }}
.inconclusive td:first-child {{ color: #b26a00 }}
footer {{ margin-top: 2rem; max-width: 60rem; opacity: .7 }}
</style>
<h1>{count}</h1>
<p>{when:%Y-%m-%d %H:%M} UTC, gcodesim {version}, {options}</p>
<p><label>Show only what contains <input id="filter" type="search"></label></p>
<table>
<thead><tr>{head}</tr></thead>
<tbody>
{body}
</tbody>
</table>
<footer>{contract}</footer>
<script>
const rows = [...document.querySelectorAll("tbody tr")];
document.getElementById("filter").oninput = event => {{
  const wanted = event.target.value.toLowerCase();
  for (const row of rows) row.hidden = !row.textContent.toLowerCase().includes(wanted);
}};
document.querySelectorAll("th button").forEach((button, column) => {{
  let up = false;
  button.onclick = () => {{
    up = !up;
    const text = row => row.cells[column].textContent;
    rows.sort((a, b) => (up ? 1 : -1) * text(a).localeCompare(text(b), "en", {{numeric: true}}));
    document.querySelector("tbody").append(...rows);
  }};
}});
</script>
"""


def overview_page(
    rows: Sequence[ProgramRow], version: str, options: Sequence[str], folder: Path
) -> str:
    """The page; a click on a column sorts by it.

    Args:
        rows: what it shows.
        version: of gcodesim.
        options: those of every row that are not the defaults.
        folder: of the page; pictures are linked from there.
    """
    body = "\n".join(_table_row(row, folder) for row in rows)
    return _PAGE.format(
        count=escape(headline(rows)),
        when=datetime.now(UTC),
        options=f"with <code>{escape(printable(' '.join(options)))}</code>"
        if options
        else "options as they are unless given",
        head="".join(f"<th><button>{escape(column)}</button></th>" for column in columns()),
        body=body,
        version=escape(version),
        contract=escape(CONTRACT),
    )


def _table_row(row: ProgramRow, folder: Path) -> str:
    links = "".join(f' <a href="{_link(file, folder)}">picture</a>' for file in row.pictures)
    texts = "".join(f"<td>{_breakable(text)}</td>" for text in cells(row))
    return f'<tr class="{row.verdict}">{texts.removesuffix("</td>")}{links}</td></tr>'


def _breakable(text: str) -> str:
    """The text as HTML that may be broken after a slash: folders make names long."""
    return escape(text).replace("/", "/<wbr>")


def _link(file: str, folder: Path) -> str:
    """A file as an address that holds wherever the page and its pictures lie together."""
    path = PurePath(os.path.relpath(file, folder)).as_posix()
    return escape(quote(f"./{path}", errors="surrogateescape"))
