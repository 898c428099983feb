"""What a finding means and what to do about it: every code and every meaning."""

from __future__ import annotations

import difflib

from gcodesim.errors import UsageError
from gcodesim.findings.codes import CODES, FAIL, INCONCLUSIVE
from gcodesim.findings.meanings import MEANINGS

ADVICE: dict[str, str] = {
    "GC101": "Look at the block and the axis positions: retract further, or take another way.",
    "GC102": "Retract before the rotary axes turn, use a shorter holder or a longer tool.",
    "GC103": "Only the flute may touch stock and part: use a longer tool, or tilt it away.",
    "GC104": "Move the clamp, or lift the tool over it; look at rapids at the R level of cycles.",
    "GC105": "Retract before the rapid, or start the spindle before the feed move.",
    "GC106": "A body appears inside another: check start position, tool length and setup.",
    "GC107": "Two bodies meet between two samples: treat it as a contact; a finer --sample-period "
    "shows where.",
    "GC108": "Look at axis positions, clamping and work offset: no longer tool helps here.",
    "GC201": "Two bodies pass nearer than the machine file wants: give them more room.",
    "GC202": "The control may leave the programmed path by more than the room that is left.",
    "GC301": "Move the work offset, clamp the part elsewhere, or shorten the move.",
    "GC302": "Use the other solution of the rotary axes, or unwind the axis before.",
    "GC303": "The block takes longer than programmed, for an axis is at its rapid rate; nothing "
    "else changes.",
    "GC304": "Rotary axes turn far for a small change of the tool axis: tilt the part.",
    "GC401": "Correct the block as the finding says; every control would refuse it.",
    "GC402": "What follows was not checked: post without the code, or list it in the machine file "
    "when it moves nothing.",
    "GC403": "Nothing was read: post the program for this control, or name the language it is in "
    "with --dialect.",
    "GC404": "Correct end point, centre or radius; rounded posts may need `control: {arc: ...}`.",
    "GC405": "Program F before the first feed move, or start with --feed.",
    "GC406": "Correct the parameter or the expression; every control would stop here.",
    "GC407": "Correct the call, the loop or the block number; every control would stop here.",
    "GC408": "Give the cycle its missing or wrong word.",
    "GC409": "Give the offset or the variable in the setup file, or the tool in the tools file; "
    "what follows was not checked.",
    "GC410": "Correct the value of the word.",
    "GC412": "Put the subprogram into the program, or beside it as Onnnn.nc, or say what it does: "
    "`control: {programs: {9810: probe}}`; what follows was not checked.",
    "GC420": "If the code moves no axis, list it: `control: {m_codes: {123: none}}`.",
    "GC421": "Give the tool a shape in the tools file; until then its pairs are not checked.",
    "GC422": "Let the CAM system compensate, or check by hand: the tool runs beside the path that "
    "was checked.",
    "GC423": "The operator or a probe decides where the axes are: that cannot be checked from the "
    "program.",
    "GC424": "The program may not end: correct the loop, or raise the limit (--max-blocks).",
    "GC425": "Give the parameter a value before it is used.",
    "GC426": "Give the tools by turned shapes and the stock as a closed mesh, so that it is "
    "followed as it is cut away; or give a larger inset.",
    "GC427": "Controls read this in several ways, with different verdicts: look up the parameter, "
    "and write the key under `control:` in the machine file.",
    "GC430": "Nothing is wrong with the check; read the sentence once.",
    "GC431": "Correct H, unless the length of this tool is kept under another number on purpose.",
    "GC432": "Write G20 or G21 at the beginning: a control keeps the unit of the program before.",
    "GC501": "Close the mesh: an open one has no inside, so bodies wholly inside it are not seen.",
    "GC502": "Correct the meshes or the joint, or allow the pair with a reason.",
    "GC503": "Write `units:` at the mesh: only in another unit does it suit travel, link and tool.",
    "GC504": "Repair the mesh; triangles without area are checked as lines.",
    "GC601": "Give a reason, or correct the comment: (gcodesim: ignore GC201 reason=why). What was "
    "not checked, and the end of a refused program, cannot be ignored.",
    "GC602": "Take the comment out, or let --update-baseline take the entry out.",
    "GC901": "Run the check again; what was not reached is not decided.",
}
"""Code -> what to do."""

VERDICTS = {FAIL: "FAIL", INCONCLUSIVE: "INCONCLUSIVE"}


def explain(name: str) -> str:
    """Return title, advice and meanings of a code such as GC405, or a meaning such as feed_missing.

    Of what codes begin with, such as GC2, they are listed with their titles; of "" all are.

    Raises:
        UsageError: there is none of this name.
    """
    code = name.upper()
    if code in CODES:
        return "\n".join(_code_lines(code))
    family = [_title(known) for known in CODES if known.startswith(code)]
    if family:
        return "\n".join([*family, "`gcodesim explain CODE` says more about one of them"])
    meaning = name.lower().replace("-", "_")
    if meaning in MEANINGS:
        code, right = MEANINGS[meaning]
        return "\n".join([f"{meaning}: {right}", *_code_lines(code, listed=False)])
    near = difflib.get_close_matches(meaning, MEANINGS, n=3) or difflib.get_close_matches(
        code, CODES, n=3
    )
    hint = f"did you mean {', '.join(near)}?" if near else "codes are GC101 to GC901"
    raise UsageError(f"no code or meaning {name!r}; {hint}")


def _title(code: str) -> str:
    row = CODES[code]
    return f"{code} {row.title} ({row.severity}; verdict {VERDICTS.get(row.effect, 'unchanged')})"


def _code_lines(code: str, *, listed: bool = True) -> list[str]:
    lines = [_title(code), f"  {ADVICE[code]}"]
    of_code = {m: right for m, (c, right) in MEANINGS.items() if c == code}
    if listed:
        lines += [f"  {meaning}: {right}" for meaning, right in sorted(of_code.items())]
    return lines
