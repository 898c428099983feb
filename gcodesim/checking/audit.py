"""The audit: the same check with nothing left out must give the same answer."""

from __future__ import annotations

from dataclasses import replace

from gcodesim.collision.detector import Detection, Task, detect
from gcodesim.constants import AUDIT_GOOD_TO_MM
from gcodesim.findings.codes import Finding


def audit(task: Task, detection: Detection) -> list[Finding]:
    """Check again with every pair, compare, and confirm each margin by the smallest distance.

    Returns:
        A note that all agrees, or an error (GC901) for each disagreement.
    """
    aims = replace(task.aims, leave_out=False, minimum=True, stop_all=False)
    full = detect(replace(task, aims=aims))
    wrong = []
    if _key(full) != _key(detection):
        wrong.append(f"first contact {_key(full)} instead of {_key(detection)}")
    items = [item for span in detection.findings for item in span.left_out]
    smallest: dict[str, float] = {}
    for span in full.findings:
        for pair, near in span.minimums:
            smallest[pair.name] = min(near.distance, smallest.get(pair.name, near.distance))
    pairs = [item for item in items if item.what in smallest]
    for item in pairs:
        distance = smallest[item.what]
        if distance < item.bound_mm + item.margin_mm - AUDIT_GOOD_TO_MM:
            wrong.append(f"{item.what} comes to {distance:.6g} mm, left out with {item.margin_mm}")
    if wrong:
        return [Finding("GC901", f"audit disagrees: {text}", "audit_disagrees") for text in wrong]
    text = f"audit: the same answer with nothing left out; {len(pairs)} pair margins hold"
    return [Finding("GC430", text, "audit_agrees")]


def _key(detection: Detection) -> tuple[int, str, bool] | None:
    contact = detection.contact
    return (contact.sample, contact.pair.name, contact.between) if contact else None
