"""The actions of the table of codes, by their names."""

from __future__ import annotations

from collections.abc import Callable

from gcodesim.nc.iso import (
    calls,
    cycles,
    modes,
    motion,
    offsets,
    planes,
    saved_modes,
    tables,
    tooling,
)
from gcodesim.nc.iso.block import Block
from gcodesim.nc.iso.memory import IsoState

Action = Callable[[IsoState, Block, int], None]
"""What a code does; the number is its code in tenths."""

ACTIONS: dict[str, Action] = {
    action.__name__: action
    for action in (
        *(calls.call_block, calls.call_macro, calls.call_program, calls.return_from_call),
        *(cycles.end_cycle, cycles.run_cycle),
        *(modes.compensate, modes.dwell, modes.listed_g, modes.listed_m, modes.unknown_m),
        *(modes.set_centre_distance, modes.set_cycle_return, modes.set_distance, modes.set_feed),
        *(modes.set_feed_mode, modes.set_path, modes.set_plane, modes.set_rigid_tapping),
        *(modes.set_speed, modes.set_spindle, modes.set_surface_speed, modes.set_unit, modes.stop),
        *(motion.arc, motion.probe, motion.return_to_reference, motion.set_polar),
        *(motion.move_in_step, motion.store_reference, motion.straight),
        *(offsets.cancel_g92, offsets.mirror, offsets.rotate_plane, offsets.set_g92),
        *(offsets.preset, offsets.scale, offsets.set_haas_offset, offsets.set_setup_error),
        *(offsets.scale_by_thousandths, offsets.wrap_on_cylinder),
        *(offsets.set_additional_offset, offsets.set_local_offset, offsets.set_work_offset),
        *(planes.align_tool, planes.set_table_offset, planes.set_tilted_plane),
        *(saved_modes.forget_modes, saved_modes.restore_modes, saved_modes.save_modes),
        *(tables.set_table,),
        tooling.change_length_entry,
        *(tooling.cancel_tool_centre_point, tooling.change_tool, tooling.declare_tool),
        *(tooling.select_tool, tooling.set_tool_centre_point, tooling.set_tool_length),
        *(tooling.set_tool_length_words,),
    )
}
"""Row.action -> what it does."""
