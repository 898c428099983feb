"""What work offsets, G52, G92, G68 and G51.1 do to the frames; none of them moves an axis."""

from __future__ import annotations

from gcodesim.nc.control.five_axes import end_plane
from gcodesim.nc.control.frames import Level, apply
from gcodesim.nc.control.place import ProgramError
from gcodesim.nc.control.supply import WorkOffset
from gcodesim.nc.iso.block import Block
from gcodesim.nc.iso.g_codes import G
from gcodesim.nc.iso.memory import LOCAL, PLANE, ROTATION, IsoState
from gcodesim.nc.iso.motion import axis_values
from gcodesim.nc.program import PLANES, ZERO, Kind

ADDITIONAL = 100
"""G54.1 Pn is work offset 100 + n."""


def set_work_offset(state: IsoState, block: Block, number: int) -> None:
    """G54 .. G59, G59.1 .. G59.3; Fanuc takes G54 Pn for G54.1 Pn."""
    if "P" in block.values and not _is_taken(block, "P", number):
        set_additional_offset(state, block, number)
        return
    index = number // 10 - 53 if number < G.WORK_OFFSET_9 else number - 584
    activate(state, block, index, number)


def set_additional_offset(state: IsoState, block: Block, number: int) -> None:
    """G54.1 Pn, G154 Pn."""
    if "P" not in block.values:
        raise block.error("offset_not_found", f"G{number / 10:g} without P")
    activate(state, block, ADDITIONAL + block.whole("P"), number)


def _is_taken(block: Block, letter: str, number: int) -> bool:
    """Tell whether the word of a letter belongs to another code of the block, such as G4."""
    return any(letter in row.words for row in block.rows if row.number != number)


def set_haas_offset(state: IsoState, block: Block, number: int) -> None:
    """G110 .. G129: G154 P1 .. P20."""
    activate(state, block, ADDITIONAL + number // 10 - 109, number)


def activate(state: IsoState, block: Block, index: int, number: int) -> None:
    """Put a work offset into force by its number, 1 = G54, and the code that asks for it."""
    offset, codes = state.offsets.get(index), state.codes
    if offset is None and index != 1:
        name = f"G54.1 P{index - ADDITIONAL}" if index > ADDITIONAL else f"G{number / 10:g}"
        raise block.error("offset_not_found", name, f"G{number / 10:g}")
    offset = in_force(state, index)
    if state.modal.table_offset and any(offset.value[3:]):
        raise block.error("table_offset_turned", f"G{number / 10:g} under a table offset")
    codes.offset = index
    old = state.work
    same = tuple(offset.value) == tuple(old.value) and offset.rotation == old.rotation
    if same and codes.work_offset == number:
        return
    codes.work_offset = number
    state.set_work(offset)
    state.emit(Kind.G5X, offset.value, aux=index)


def in_force(state: IsoState, index: int) -> WorkOffset:
    """Return a work offset with what is added to all of them."""
    offset = state.offsets.get(index, WorkOffset())
    if not any(state.external):
        return WorkOffset(offset.value, offset.rotation)
    x, y, z, a, b, c = (v + e for v, e in zip(offset.value, state.external, strict=True))
    return WorkOffset((x, y, z, a, b, c), offset.rotation)


def set_local_offset(state: IsoState, block: Block, number: int) -> None:
    """G52: the words are the G92 offset itself."""
    values = _needed(state, block, "G52")
    _set_g92(state, [values.get(i, old) for i, old in enumerate(state.g92)])


def set_g92(state: IsoState, block: Block, number: int) -> None:
    """G92: the offset with which the current point reads the words."""
    values = _needed(state, block, "G92")
    check_measured(state, block, values)
    point = state.point
    steps = [point[i] - values.get(i, point[i]) for i in range(6)]
    steps[:3] = apply(state.frames.turn_within(LOCAL), steps[:3])
    _set_g92(state, [old + step for old, step in zip(state.g92, steps, strict=True)])


def check_measured(state: IsoState, block: Block, values: dict[int, float]) -> None:
    """Refuse to set a table from an axis of which only a probe knows where it stands."""
    if state.skipped is not None and state.skipped.axes & values.keys():
        code = next(row.name for row in block.rows if row.takes_axes)
        raise block.error("measured_by_probe", f"{code} where a probe has stopped", code)


def cancel_g92(state: IsoState, block: Block, number: int) -> None:
    """G92.1 zeroes the offset, G92.2 lays it aside, G92.3 takes it up again."""
    if number == G.CLEAR_G92:
        state.g92_kept = list(ZERO)
    state.set_g92(list(state.g92_kept) if number == G.RESTORE_G92 else list(ZERO))


def preset(state: IsoState, block: Block, number: int) -> None:
    """G92.1 of Fanuc: the axes named read as their stored work offset says; nothing moves."""
    values = _needed(state, block, "G92.1")
    _set_g92(state, [0.0 if i in values else old for i, old in enumerate(state.g92)])


def scale(state: IsoState, block: Block, number: int, one: float = 1.0) -> None:
    """G51: only a factor of 1 is followed."""
    factors = [block.values[letter] for letter in "IJKP" if letter in block.values]
    if not factors or any(factor != one for factor in factors):
        raise unfollowed(state, block, "G51 scales the path")


def scale_by_thousandths(state: IsoState, block: Block, number: int) -> None:
    """G51 of Fanuc, which writes the factor 1 as 1000."""
    scale(state, block, number, 1000.0)


def wrap_on_cylinder(state: IsoState, block: Block, number: int) -> None:
    """G7.1 G107: only with radius 0, which ends it."""
    given = [v for letter, v in block.values.items() if letter in "XYZABCR"]
    if any(given):
        raise unfollowed(state, block, f"G{number / 10:g} winds the path on a cylinder")


def set_setup_error(state: IsoState, block: Block, number: int) -> None:
    """G54.4 P0 is harmless; any other P turns and shifts the part by values nothing gives."""
    if block.values.get("P"):
        raise unfollowed(state, block, "G54.4 takes its values from the control")


def unfollowed(state: IsoState, block: Block, what: str) -> ProgramError:
    """Return the refusal of what a code asks for, by its name."""
    name = what.split()[0]
    state.unsupported.append(f"{name} line {block.line}")
    return block.error("unknown_g", what, name)


def _set_g92(state: IsoState, value: list[float]) -> None:
    state.g92_kept = list(value)
    state.set_g92(value)


def _needed(state: IsoState, block: Block, code: str) -> dict[int, float]:
    values = axis_values(state, block)
    if not values:
        raise block.error("axis_missing", f"{code} without axis words", code)
    return values


def rotate_plane(state: IsoState, block: Block, number: int) -> None:
    """G68: program points turn by R about the words, or about the current point; G69 ends it.

    G69 ends a tilted plane too (G68.2).
    """
    if number != G.ROTATION:
        end_plane(state, PLANE)
        if state.is_rotated:
            state.set_frame(ROTATION, Level())
    elif state.frames.tilted:
        raise block.error("tilted_plane_active", "G68 in a tilted plane", "G68")
    elif "R" not in block.values:
        raise block.error("rotation_without_angle", "G68 without R", "G68")
    else:
        normal = PLANES[state.modal.plane][2]
        values = axis_values(state, block)
        centre = [values.get(i, state.point[i]) for i in range(3)]
        state.set_rotation(centre, normal, block.values["R"])


def mirror(state: IsoState, block: Block, number: int) -> None:
    """G51.1: program points are mirrored at the words; G50.1 ends it for the axes it names."""
    values = axis_values(state, block)
    if rotary := next((letter for letter in "ABC" if letter in block.values), ""):
        raise block.error("unused_word", f"{rotary} cannot be mirrored", rotary)
    if number == G.MIRROR:
        state.set_mirrors(state.mirrors | _needed(state, block, "G51.1"))
    elif values:
        state.set_mirrors({i: at for i, at in state.mirrors.items() if i not in values})
    elif state.mirrors:
        state.set_mirrors({})
