"""A toy language: proof that a new one needs its own files and no line elsewhere.

tool 3                 select and load        go X1 Y2        rapid
frame 10 0 5           shift the frame        cut X1 Y2 F300  feed
loop 4 ... again       four times             arc X Y centre U V   counter-clockwise
1.0 2.0 -3.5           a plain line: feed to X Y Z, read by the thousand through columns
"""

import numpy as np

from gcodesim.nc.control import moves, tool_changes
from gcodesim.nc.control.columns import columns_of
from gcodesim.nc.control.frames import WORK, Level
from gcodesim.nc.control.language_base import Language
from gcodesim.nc.control.modal import Motion
from gcodesim.nc.control.place import Place
from gcodesim.nc.control.program_flow import ProgramFlow
from gcodesim.nc.control.state import State
from gcodesim.nc.program import AXES, Kind


class Toy(Language[Place]):
    def __init__(self, control):
        super().__init__(State(control), ProgramFlow(control.max_blocks))
        self.opened = []

    def place(self, source, index):
        return Place(source.file, index + 1, source.lines[index], source.first + index + 1)

    def scan(self, lines, first, last, shortest):
        rows = [self.numbers(lines[i]) for i in range(first, last)]
        words = {letter: np.array([row[i] for row in rows]) for i, letter in enumerate("XYZ")}
        columns = columns_of(first, words, shortest)
        columns.plain &= ~columns.blank
        columns.find_runs(shortest)
        return columns

    @staticmethod
    def numbers(line):
        words = line.split()
        plain = len(words) == 3 and not any(word[:1].isalpha() for word in words)
        return [float(word) for word in words] if plain else [np.nan] * 3

    def run(self, line):
        state, flow, (verb, *words) = self.state, self.flow, line.text.split() or ["", ""]
        state.blocks, state.last_line = state.blocks + 1, line.row
        named = {AXES.index(w[0]): float(w[1:]) for w in words if w[:1] in AXES}
        feeds = [float(w[1:]) for w in words if w[:1] == "F"]
        if feeds:
            state.modal.feed, state.modal.feed_given = feeds[0], True
        if verb == "tool":
            tool_changes.select_tool(state, int(words[0]), "tool ")
            tool_changes.change_tool(state, "tool")
        elif verb == "frame":
            state.set_frame(WORK, Level([*map(float, words), 0.0, 0.0, 0.0]))
        elif verb in ("go", "cut"):
            kind = Kind.RAPID if verb == "go" else Kind.FEED
            moves.straight(state, kind, moves.point_to(state, named))
            state.modal.motion = Motion.FEED
        elif verb == "arc":
            centre = float(words[-2]), float(words[-1])
            end = moves.point_to(state, named)
            moves.arc(state, end, clockwise=False, centre=centre)
        elif verb == "loop":
            self.opened.append(flow.index - 1)
            flow.count_down(flow.index - 1, int(words[0]))
        elif verb == "again":
            flow.index = self.opened[-1] + 1 if flow.count_down(self.opened[-1]) else flow.index
        else:
            x, y, z = self.numbers(line.text)
            moves.straight(state, Kind.FEED, moves.point_to(state, {0: x, 1: y, 2: z}))
