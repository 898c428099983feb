"""What a finding means and what to do about it: every code and every meaning."""

from __future__ import annotations

import difflib

from gcodesim.errors import UsageError
from gcodesim.findings.codes import CODES, CONTAINMENT_UNDECIDED, FAIL, INCONCLUSIVE
from gcodesim.findings.meanings import MEANINGS

ADVICE: dict[str, str] = {
    "GC101": "Look at the block and the axis positions: retract further, or take another way.",
    "GC102": "Retract before the rotary axes turn, use a shorter holder or a longer tool.",
    "GC103": "Only the flute may touch stock and part: use a longer tool, or tilt it away.",
    "GC104": "Move the clamp, or lift the tool over it; look at rapids at the R level of cycles.",
    "GC105": "A rapid meets material: retract before, or approach at the feed.",
    "GC106": "A body appears inside another: check start position, tool length and setup.",
    "GC107": "Two bodies meet between two samples: treat it as a contact; a finer --sample-period "
    "shows where.",
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
    "GC404": "Correct end point, centre or radius; rounded posts may need `control: {arc: ...}`.",
    "GC405": "Program F before the first feed move, or start with --feed.",
    "GC406": "Correct the parameter or the expression; every control would stop here.",
    "GC407": "Correct the call, the loop or the block number; put subprograms beside the program.",
    "GC408": "Give the cycle its missing or wrong word.",
    "GC409": "Give the offset in the setup file, or the tool in the tools file.",
    "GC410": "Correct the value of the word.",
    "GC420": "If the code moves no axis, list it: `control: {m_codes: {123: none}}`.",
    "GC421": "Give the tool a shape in the tools file; until then its pairs are not checked.",
    "GC422": "Let the CAM system compensate, or check by hand: the tool runs beside the path that "
    "was checked.",
    "GC423": "The operator moves the machine here; nobody can check that from the program.",
    "GC424": "The program may not end: correct the loop, or raise the limit (--max-blocks).",
    "GC425": "Give the parameter a value before it is used.",
    "GC430": "Nothing is wrong with the check; read the sentence once.",
    "GC501": "Close the mesh: an open one has no inside, so bodies wholly inside it are not seen.",
    "GC502": "Correct the meshes or the joint, or allow the pair with a reason.",
    "GC503": "Set `units:` of the machine file: the mesh is far larger or smaller than the travel.",
    "GC504": "Repair the mesh; triangles without area are left out.",
    "GC601": "Give a reason, or correct the comment: (gcodesim: ignore GC201 reason=why). What was "
    "not checked, and the end of a refused program, cannot be ignored.",
    "GC602": "Take the comment out, or let --update-baseline take the entry out.",
    "GC901": "Run the check again; what was not reached is not decided.",
}
"""Code -> what to do."""

OTHER_MEANINGS: dict[str, tuple[str, str]] = {
    "audit_agrees": ("GC430", "checking with nothing left out gives the same answer"),
    "audit_disagrees": ("GC901", "checking with nothing left out gives another answer: report it"),
    "axis_too_slow": ("GC303", "the block is stretched to the rapid rate of its slowest axis"),
    "baseline_unused": ("GC602", "what was accepted is gone: --update-baseline removes the entry"),
    "body_unpaired": ("GC430", "name the body in `pairs`, or leave `pairs` out"),
    "clearance": ("GC201", "give the pair more room, or a smaller clearance"),
    "contact": ("GC101", "surfaces of two bodies touch or cross; GC102 to GC107 in the same way"),
    "containment": ("GC106", "one body lies wholly inside the other"),
    CONTAINMENT_UNDECIDED: ("GC501", "the mesh must be closed to tell inside from outside"),
    "ignore_refused": ("GC601", "a contact needs a reason, and what was not checked always counts"),
    "ignore_unreadable": ("GC601", "write (gcodesim: ignore GC201 reason=why) in the block's line"),
    "ignore_unused": ("GC602", "take the comment out: its block has no such finding"),
    "max_pieces": ("GC424", "turn less under tool centre point control, or in several programs"),
    "mesh_degenerate": ("GC504", "triangles without area cannot be touched and are left out"),
    "mesh_inward": ("GC504", "the triangles face inwards; they were turned over"),
    "mesh_open": ("GC501", "close the mesh where it has edges with one triangle"),
    "mesh_repeated": ("GC504", "draw every triangle once: export the mesh again, without doubles"),
    "mesh_unit": ("GC503", "set units: in the machine file"),
    "model_unverified": ("GC430", "measure the machine, then write `verified: true`"),
    "near_pole": ("GC304", "tilt the tool away from the axis of the table or fork, or feed slower"),
    "no_motion": ("GC430", "nothing can collide, and nothing was checked"),
    "offsets_missing": ("GC430", "give the work offsets in the machine or setup file"),
    "overdue": ("GC901", "give the batch a longer --time-limit, or check this program alone"),
    "overtravel": ("GC301", "positions stay inside the travel; GC302 for rotary axes"),
    "pair_out_of_reach": ("GC430", "nothing to do: such a pair is proved apart before each search"),
    "pairs_missing": ("GC430", "give links a shape, and name pairs or leave `pairs` out"),
    "path_tolerance_missing": ("GC430", "ask the builder how far the control rounds corners"),
    "reference_out_of_travel": ("GC301", "the reference position, or the travel, is wrong"),
    "rest": ("GC502", "correct shapes, joints or start; or `allow` the pair, with a reason"),
    "search_undecided": ("GC901", "the search gave up; use --method exhaustive for this stretch"),
    "stopped_at_ignored": ("GC901", "--stop all looks at what follows an ignored contact"),
    "time_limit": ("GC424", "what follows the limit of program time was not checked"),
    "tool_centre_unsolved": ("GC430", "X Y Z between work and tool, and A B C that point the tool"),
    "tool_part_without_shape": ("GC421", "give shank and holder in the tools file"),
    "tool_without_shape": MEANINGS["tool_without_shape"],
    "worker_lost": ("GC901", "check this program alone: it may need more memory, or find a defect"),
    "tools_missing": ("GC430", "give a tools file, or `for: all` with the mounted tool"),
    "travel_unlimited": ("GC430", "give the slide its `limits`"),
    "zero_out_of_travel": ("GC430", "draw the shapes at a pose within the travel, or correct it"),
}
"""Meaning that is not of the language -> code it comes with, and what would be right."""

EFFECTS = {FAIL: "FAIL", INCONCLUSIVE: "INCONCLUSIVE"}


def explain(name: str) -> str:
    """Return what is to be said about a code such as GC405, or a meaning such as feed_missing.

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
    meanings = MEANINGS | OTHER_MEANINGS
    meaning = name.lower().replace("-", "_")
    if meaning in meanings:
        code, right = meanings[meaning]
        return "\n".join([f"{meaning}: {right}", *_code_lines(code, listed=False)])
    near = difflib.get_close_matches(meaning, meanings, n=3) or difflib.get_close_matches(
        code, CODES, n=3
    )
    hint = f"did you mean {', '.join(near)}?" if near else "codes are GC101 to GC901"
    raise UsageError(f"no code or meaning {name!r}; {hint}")


def _title(code: str) -> str:
    row = CODES[code]
    return f"{code} {row.title} ({row.severity}; verdict {EFFECTS.get(row.effect, 'unchanged')})"


def _code_lines(code: str, *, listed: bool = True) -> list[str]:
    lines = [_title(code), f"  {ADVICE[code]}"]
    of_code = {m: right for m, (c, right) in (MEANINGS | OTHER_MEANINGS).items() if c == code}
    if listed:
        lines += [f"  {meaning}: {right}" for meaning, right in sorted(of_code.items())]
    return lines
