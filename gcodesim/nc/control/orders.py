"""Orders that move nothing: dwell, stop, path mode, radius compensation, and the stock."""

from __future__ import annotations

from collections.abc import Sequence

from gcodesim.nc.control.modal import CutterSide
from gcodesim.nc.control.readings import BOTH
from gcodesim.nc.control.state import State
from gcodesim.nc.program import Kind, Turning


def dwell(state: State, seconds: float) -> None:
    """Stand still for a time [s]; none is no command."""
    if seconds:
        state.recorder.add(Kind.DWELL, state.place.row, f=seconds)


def stop(state: State, code: int = 0, *, ends: bool = False) -> None:
    """Stop, for the operator to go on, or at the end of the program.

    Args:
        state: of the control.
        code: number of the M code that asks for it.
        ends: the program is over.
    """
    state.emit(Kind.STOP, aux=code)
    state.ended = ends
    way = state.control.readings.spindle_at_stop
    if ends or way == "stops":
        state.recorder.turn(Turning.STANDS)
    elif way == BOTH and state.recorder.turning != Turning.STANDS:
        state.recorder.turn(Turning.HALTED)


def set_path(state: State, code: int, tolerance: float) -> None:
    """Set how near the control keeps to the path; the exact path is checked in any case.

    Args:
        state: of the control.
        code: G code in tenths, see Kind.PATH.
        tolerance: [mm], 0 where none is given.
    """
    state.path = code, tolerance
    state.recorder.add(Kind.PATH, state.place.row, f=tolerance, aux=code)


def compensate(state: State, side: CutterSide, code: str) -> None:
    """Begin or end cutter radius compensation: it is reported, and the path runs as written.

    Args:
        state: of the control.
        side: on which the cutter runs.
        code: name of the code that asks for it.
    """
    state.modal.side = side
    if side is not CutterSide.NONE:
        state.unsupported.append(f"{code} line {state.place.line}")
        state.report("cutter_comp_uncompensated", code, code, subject=code)


def define_stock(state: State, lower: Sequence[float], upper: Sequence[float]) -> None:
    """Give the stock as a box along the axes of the frame in force.

    Args:
        state: of the control.
        lower: corner X Y Z with the smaller coordinates [mm], in the program frame.
        upper: the corner across.
    """
    corners = [state.frames.machine([*corner, 0.0, 0.0, 0.0])[:3] for corner in (lower, upper)]
    state.recorder.set_stock((corners[0], corners[1]))
