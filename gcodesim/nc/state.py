"""Where the control stands between two blocks: modal state, frames, position, and what it said."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

from gcodesim.findings import Finding
from gcodesim.nc.block import Block
from gcodesim.nc.control import ZERO, Control, WorkOffset
from gcodesim.nc.frames import Frames
from gcodesim.nc.modal import Modal
from gcodesim.nc.program import AXES, Kind
from gcodesim.nc.recorder import Recorder

INCH = 25.4
"""Millimetres per inch, exact by definition."""

LIMIT = 1e12
"""Largest position, feed or speed taken from a program; beyond it sums lose a thousandth of a mm."""


class State:
    """What a block finds and leaves behind.

    Attributes:
        point: current position as the program counts it, X Y Z [mm], A B C [deg].
        position: the same as machine position of the controlled point.
        recorder: canonical commands so far.
        ignored: what was dropped or listed as doing nothing -> times.
        unsupported: what was not followed, with its line.
        ended: M2, M30 or the closing % was reached.
    """

    def __init__(self, control: Control) -> None:
        self.control = control
        self.modal = Modal(
            cycle_return=980 if control.dialect.cycle_return == "G98" else 990,
            unit=200 if control.inch else 210,
        )
        first = control.offsets.get(1, WorkOffset())
        self.frames = Frames(g5x=list(first.value), rotation=first.rotation)
        self.frames.update()
        self.start = [control.start.get(letter, 0.0) for letter in AXES]
        self.position = list(self.start)
        self.point = self.frames.program(self.position)
        self.recorder = Recorder()
        self.ignored: Counter[str] = Counter()
        self.unsupported: list[str] = []
        self.ended = False
        self._findings: dict[tuple[str, str], tuple[Finding, int]] = {}

    @property
    def scale(self) -> float:
        """Millimetres per programmed length unit."""
        return INCH if self.modal.unit == 200 else 1.0

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Findings in the order met; the first of a kind stands for all, with their count."""
        return tuple(
            replace(finding, message=f"{finding.message} ({count} times)") if count > 1 else finding
            for finding, count in self._findings.values()
        )

    def report(self, finding: Finding, subject: str = "") -> None:
        """Keep a finding; the same meaning about the same subject is only counted."""
        key = (finding.meaning, subject)
        first, count = self._findings.get(key, (finding, 0))
        self._findings[key] = (first, count + 1)

    def reframe(self) -> None:
        """Count the position anew after a change of frames: offsets never move the machine."""
        self.frames.update()
        self.point = self.frames.program(self.position)

    def emit(
        self, kind: Kind, block: Block, value: list[float] | None = None, aux: int = 0
    ) -> None:
        """Record a command that is no move."""
        self.recorder.add(kind, block.line, value or ZERO, aux=aux)
