"""M70 to M73 of LinuxCNC: modes are laid aside, one set for every call, and put back."""

from __future__ import annotations

from gcodesim.nc.control import orders, tool_changes
from gcodesim.nc.control.place import ProgramError
from gcodesim.nc.iso import offsets
from gcodesim.nc.iso.block import Block
from gcodesim.nc.iso.memory import IsoState, SavedModes

MODES = (
    *("plane", "incremental", "centre_absolute", "inch", "feed_mode", "feed", "feed_scale"),
    *("feed_given", "speed", "spindle", "surface_speed"),
)
"""Fields of Modal that are laid aside; the motion mode and the tool are not."""

CODES = ("cycle_return",)
SAVE_FOR_CALL = 730


def save_modes(state: IsoState, block: Block, number: int) -> None:
    """M70, M73: lay the modes aside; after M73 the end of the call puts them back."""
    modal, codes = state.modal, state.codes
    state.saved[-1] = SavedModes(
        tuple(getattr(modal, name) for name in MODES),
        tuple(getattr(codes, name) for name in CODES),
        modal.side,
        (codes.work_offset, codes.offset),
        (codes.length, list(state.frames.tool)),
        state.path,
        modal.tip_control,
        number == SAVE_FOR_CALL,
    )


def forget_modes(state: IsoState, block: Block, number: int) -> None:
    """M71: what was laid aside is gone."""
    state.saved[-1] = None


def restore_modes(state: IsoState, block: Block, number: int) -> None:
    """M72: put the modes back."""
    saved = state.saved[-1]
    if saved is None:
        raise block.error("modes_not_saved", "M72", "M72")
    put_back(state, block, saved)


def end_call(state: IsoState, block: Block) -> None:
    """Leave a call: what M73 has laid aside in it comes back."""
    saved = state.saved.pop()
    if saved is not None and saved.returns:
        put_back(state, block, saved)


def put_back(state: IsoState, block: Block, saved: SavedModes) -> None:
    """Put modes back; nothing moves.

    Raises:
        ProgramError: tool centre point control has changed meanwhile.
    """
    modal, codes = state.modal, state.codes
    if modal.tip_control is not saved.tips:
        raise _refusal(state, block)
    for name, value in zip(MODES, saved.modal, strict=True):
        setattr(modal, name, value)
    state.turn_spindle(modal.spindle)
    for name, value in zip(CODES, saved.codes, strict=True):
        setattr(codes, name, value)
    if (codes.work_offset, codes.offset) != saved.offset:
        offsets.activate(state, block, saved.offset[1], saved.offset[0])
    code, tool = saved.length
    if (codes.length, state.frames.tool) != (code, tool):
        codes.length = code
        tool_changes.set_length(state, tool, saved.tips)
    if saved.path is not None and state.path != saved.path:
        orders.set_path(state, *saved.path)
    if modal.side is not saved.side:
        orders.compensate(state, saved.side, "M72")


def _refusal(state: IsoState, block: Block) -> ProgramError:
    state.unsupported.append(f"M72 line {block.line}")
    return block.error("unknown_g", "M72 over a change of tool centre point control", "M72")
