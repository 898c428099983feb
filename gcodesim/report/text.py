"""The text report: what touched what, where and when, and what was not checked."""

from __future__ import annotations

from collections.abc import Iterator

from rich.console import Console
from rich.text import Text

from gcodesim.findings import Finding
from gcodesim.verdict import CONTRACT, CheckResult, FirstContact

COLORS = {"pass": "bold green", "fail": "bold red", "inconclusive": "bold yellow"}
SEVERITY_COLORS = {"error": "red", "warning": "yellow", "note": "cyan"}
MODELS = {True: "", False: ", unverified model"}


def print_report(result: CheckResult, console: Console) -> None:
    """Print the report of one program."""
    head = Text(result.verdict.upper(), style=COLORS[result.verdict])
    head.append(f"  {result.program} on {result.machine}{MODELS[result.verified_model]}", "default")
    console.print(head)
    for line in _body(result):
        console.print(line)


def _body(result: CheckResult) -> Iterator[Text]:
    if result.first_contact:
        yield from _contact(result.first_contact)
    for finding in result.findings:
        yield from _finding(finding)
    yield Text(_checked(result))
    for title, entries in (
        ("not followed", result.coverage.unsupported),
        ("ignored", result.coverage.ignored),
        ("not certified", result.coverage.uncertified),
        ("not checked by rule", result.coverage.unchecked_by_rule),
    ):
        if entries:
            yield Text(f"  {title}: {'; '.join(entries)}")
    if not result.coverage.between_samples:
        yield Text(
            f"  only samples were looked at, every {result.sample_period_s * 1e3:g} ms and every "
            "block end: what begins and ends between two of them is not seen"
        )
    yield Text(f"  {CONTRACT}", style="dim")


def _contact(contact: FirstContact) -> Iterator[Text]:
    a, b = (
        body if part == body else f"{body} ({part})"
        for body, part in zip(contact.pair, contact.parts, strict=True)
    )
    yield Text(f"  {a} touches {b}", style="bold")
    yield Text(f"  at {contact.time_s:.6f} s, sample {contact.sample}, {_place(contact)}")
    axes = "  ".join(f"{name} {q:.4f}" for name, q in contact.axes.items())
    yield Text(f"  axes   {axes}")
    if contact.point_mm:
        x, y, z = contact.point_mm
        numbers = (
            f", triangles {contact.triangles[0]} and {contact.triangles[1]}"
            if (contact.triangles)
            else ""
        )
        yield Text(f"  point  ({x:.3f}, {y:.3f}, {z:.3f}) mm in the machine{numbers}")


def _place(contact: FirstContact) -> str:
    return f"line {contact.line}: {contact.block}" if contact.line else "before the first block"


def _finding(finding: Finding) -> Iterator[Text]:
    place = ":".join(str(p) for p in (finding.file, finding.line, finding.column) if p)
    text = Text("  ")
    text.append(finding.severity, SEVERITY_COLORS[finding.severity])
    text.append(
        f" {finding.code} {place}: {finding.message}"
        if place
        else f" {finding.code} {finding.message}"
    )
    yield text
    if finding.block:
        yield Text(f"    {finding.block}", style="dim")
        if finding.column:
            yield Text(" " * (3 + finding.column) + "^", style="dim")


def _checked(result: CheckResult) -> str:
    pairs = ", ".join("-".join(pair) for pair in result.coverage.pairs) or "none"
    return (
        f"  {result.blocks} blocks, {result.duration_s:.3f} s of motion, {result.samples} samples; "
        f"{len(result.coverage.pairs)} pairs: {pairs}; {result.method} on {result.device}"
    )
