"""The text report: what touched what, where and when, and what was not checked."""

from __future__ import annotations

from collections.abc import Iterator

from rich.cells import cell_len
from rich.console import Console
from rich.text import Text

from gcodesim.checking.verdict import (
    CONTRACT,
    PASS,
    CheckResult,
    ContactInterval,
    FirstContact,
    ReadingTaken,
    effect_at,
)
from gcodesim.findings.codes import FAIL, INCONCLUSIVE, Finding, Ignored
from gcodesim.findings.printing import printable
from gcodesim.report.outcome import RunOutcome
from gcodesim.report.rows import EFFECTS

COLORS = {PASS: "bold green", FAIL: "bold red", INCONCLUSIVE: "bold yellow"}
SEVERITY_COLORS = {"error": "red", "warning": "yellow", "note": "cyan"}
AXES = "XYZABCUVW"
"""Order in which a control shows its axes."""

BLOCK_WIDTH = 120
"""Longest stretch of a block that is printed [characters]: a binary file has blocks of any size."""


def print_report(result: CheckResult, console: Console) -> None:
    """Print the report of one program."""
    for line in report_lines(result):
        console.print(line)


def render(run: RunOutcome) -> str:
    """The reports of a run without colours, and the programs that could not be read."""
    lines = [line.plain for result in run.results for line in report_lines(result)]
    lines += [f"NOT READ  {printable(failure.message)}" for failure in run.failures]
    return "".join(f"{line}\n" for line in lines)


def report_lines(result: CheckResult, most: int | None = None) -> Iterator[Text]:
    """Yield the lines of a report, with at most so many findings."""
    head = Text(result.verdict.upper(), style=COLORS[result.verdict])
    head.append(f"  {printable(result.title)} on {result.machine}{_remarks(result)}", "default")
    yield head
    yield from _body(result, most)


def _remarks(result: CheckResult) -> str:
    """What has to stand beside the verdict."""
    remarks = []
    if result.verdict == PASS and not result.coverage.between_samples:
        remarks.append("at samples only")
    if not result.verified_model:
        remarks.append("unverified model")
    touches = sum(finding.is_contact for finding in result.ignored)
    if touches:
        remarks.append(f"{touches} contact{'s' if touches > 1 else ''} ignored")
    if others := len(result.ignored) - touches:
        remarks.append(f"{others} ignored")
    if result.fail_on != "error":
        remarks.append(f"--fail-on {result.fail_on}")
    return f" ({', '.join(remarks)})" if remarks else ""


def _body(result: CheckResult, most: int | None) -> Iterator[Text]:
    first = result.first_contact
    # What decided the verdict comes first, and the first contact before all else.
    findings = sorted(
        result.counted,
        key=lambda f: (not _tells(f, first), EFFECTS.index(effect_at(f, result.fail_on))),
    )
    for finding in findings[:most]:
        yield from _finding(finding)
        if first and _tells(finding, first):
            yield from _contact(first)
    if most is not None and len(findings) > most:
        yield Text(f"  {len(findings) - most} more findings: see the other reports")
    yield from _ignored(result.ignored)
    yield from map(Text, _listed(result))
    yield from map(Text, _checked(result))
    for title, entries in _gaps(result):
        if entries:
            yield Text(printable(f"  {title}: {'; '.join(entries)}"))
    yield Text(f"  {CONTRACT}", style="dim")


def _tells(finding: Finding, first: FirstContact | None) -> bool:
    """Whether this finding is the one about the first contact."""
    return (
        first is not None
        and finding.code.startswith("GC10")
        and (finding.time_s, finding.pair) == (first.time_s, first.pair)
    )


def _finding(finding: Finding) -> Iterator[Text]:
    place = ":".join(str(p) for p in (finding.file, finding.line, finding.column) if p)
    text = Text("  ")
    text.append(finding.severity, SEVERITY_COLORS[finding.severity])
    text.append(printable(f" {finding.code} {place}{': ' if place else ''}{finding.message}"))
    yield text
    if finding.block:
        yield from _block(finding.block, finding.column)


def _ignored(findings: tuple[Finding, ...]) -> Iterator[Text]:
    """Yield what was asked not to count: contacts one by one, the others by who asked."""
    groups: dict[tuple[object, ...], list[Finding]] = {}
    for finding in findings:
        alone = finding if finding.is_contact else None
        groups.setdefault((finding.code, finding.ignored, alone), []).append(finding)
    for group in groups.values():
        finding = group[0]
        place = f"{finding.file}:{finding.line}" if finding.line else finding.file
        what = f": {finding.message}" if finding.is_contact else ""
        what += f" and {len(group) - 1} more" if len(group) > 1 else ""
        mark = finding.ignored or Ignored("")
        why = f"{mark.by}: {mark.reason}" if mark.reason else mark.by
        yield Text(printable(f"  ignored {finding.code} {place}{what} ({why})"))


def _block(block: str, column: int | None) -> Iterator[Text]:
    """The block without its indentation, and a caret under its column where one is known."""
    text = printable(block).rstrip()
    indent = len(text) - len(text.lstrip())
    place = column - 1 if column else indent
    # Of a very long block only the surroundings of the column are shown.
    begin = max(min(indent, place), place - BLOCK_WIDTH // 2)
    end = begin + BLOCK_WIDTH
    lead = "    ..." if begin > indent else "    "
    yield Text(lead + text[begin:end] + ("..." if len(text) > end else ""), style="dim")
    if column:
        # Cells, not characters: East Asian characters of a comment are two columns wide.
        yield Text(" " * (len(lead) + cell_len(text[begin:place])) + "^", style="dim")


def _contact(first: FirstContact) -> Iterator[Text]:
    tool = f", tool {first.tool}" if first.tool is not None else ""
    yield Text(f"    when   {first.time_s:.6f} s, sample {first.sample}{tool}")
    letters = sorted(first.axes, key=lambda name: (AXES + name).index(name))
    axes = "  ".join(f"{letter} {first.axes[letter] + 0.0:.4f}" for letter in letters)
    yield Text(f"    axes   {axes}  (machine coordinates)")
    if first.point_mm:
        point = "  ".join(f"{n} {q + 0.0:.4f}" for n, q in zip("XYZ", first.point_mm, strict=True))
        numbers = first.triangles or ()
        named = [f"triangle {n} of {p}" for n, p in zip(numbers, first.parts, strict=False)]
        yield Text(f"    point  {point}  ({', '.join(['world frame', *named])})")


def _listed(result: CheckResult) -> Iterator[str]:
    """Yield what was asked for besides the first contact: all contacts, smallest distances."""
    for interval in result.contacts:
        kind = " between samples" if interval.between_samples else ""
        yield (
            f"  contact {_names(interval)}{kind}: {interval.from_s:.6f} to "
            f"{interval.to_s:.6f} s, deepest {interval.deepest_mm:.4g} mm at "
            f"{interval.deepest_at_s:.6f} s"
        )
    for nearest in sorted(result.clearances, key=lambda n: n.minimum_mm):
        yield (
            f"  nearest {'-'.join(nearest.pair)}: {nearest.minimum_mm:.4g} mm at "
            f"{nearest.time_s:.6f} s, line {nearest.line}"
        )
    if clear := _clear(result):
        yield f"  proved apart without search: {', '.join(clear)}"


def _names(interval: ContactInterval) -> str:
    """The bodies, and their parts where these have names of their own."""
    both = zip(interval.pair, interval.parts, strict=True)
    return "-".join(body if part == body else f"{body}.{part}" for body, part in both)


def _clear(result: CheckResult) -> list[str]:
    """Pairs whose reaches never meet, and how many triangles never come near, with the margins."""
    names = {f"{a}-{b}" for a, b in result.coverage.pairs}
    clear = [(item.what, item.margin_mm) for item in result.left_out if item.what in names]
    parts = [item for item in result.left_out if item.triangles]
    if parts:
        bodies = ", ".join(item.what.removeprefix("triangles of ") for item in parts)
        count, margin = sum(item.triangles for item in parts), min(i.margin_mm for i in parts)
        clear.append((f"{count} triangles of {bodies}", margin))
    return [f"{what} ({margin:.4g} mm to spare)" for what, margin in clear]


def _checked(result: CheckResult) -> Iterator[str]:
    looked = f"every {result.sample_period_s * 1e3:g} ms and at block ends"
    motion = f"{result.blocks} blocks, {result.duration_s:.3f} s, {result.samples} samples"
    yield f"  motion: {motion} ({looked})"
    if result.largest_step:
        yield f"  between samples: {_between(result)}"
    if len(result.tool_times) > 1:
        times = (f"{_spindle(tool)} {time_s:.3f} s" for tool, time_s in result.tool_times)
        yield f"  tools: {', '.join(times)}"
    pairs = [f"{a}-{b}" for a, b in result.coverage.pairs]
    if not pairs or not result.samples:
        yield "  checked: nothing"
        return
    until = " up to the first contact" if result.first_contact and not result.contacts else ""
    yield f"  checked: {', '.join(pairs)}{until}; {result.method} on {result.device}"
    for each in result.coverage.stocks:
        looked = f"{each.moves} moves near it, {each.beams} beams"
        yield f"  {each.stock} as it is cut away: to {each.inset_mm:g} mm ({looked})"


def _between(result: CheckResult) -> str:
    """What a sample can miss, in millimetres, and what is proved beyond it."""
    step = result.largest_step
    assert step is not None
    moved = f"a vertex moves up to {step.mm:.3g} mm ({'-'.join(step.pair)}, line {step.line})"
    if result.coverage.between_samples:
        return f"{moved}; proved free down to {result.tolerance_mm:g} mm"
    return f"{moved}; what is thinner can be stepped over"


def _spindle(tool: int | None) -> str:
    return "as started" if tool is None else f"T{tool}"


def _gaps(result: CheckResult) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield what was not checked: a title, and what belongs under it."""
    coverage = result.coverage
    between = (
        () if coverage.between_samples else ("a touch that begins and ends there is not seen",)
    )
    yield "not followed", coverage.unsupported
    yield "ignored", coverage.ignored
    yield "not checked, between samples", between
    yield "not certified", coverage.uncertified
    yield "not checked by rule", coverage.unchecked_by_rule
    yield "off the path", coverage.off_path
    yield "read as", tuple(map(_reading, coverage.readings))
    lines = (f"{entry.what}: {entry.count} from line {entry.line}" for entry in coverage.not_run)
    yield "not run, or in one of several ways", tuple(lines)


def _reading(reading: ReadingTaken) -> str:
    """One line: how a word was read, where, and what the other ways would give."""
    times = f" and {reading.count - 1} more" if reading.count > 1 else ""
    other = f"; the other way: {reading.verdict.upper()}" if reading.varied else ""
    return f"{reading.key}: {reading.value} (line {reading.line}{times}{other})"
