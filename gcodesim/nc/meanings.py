"""The one table of what can be wrong with a block: meaning, code of the finding, what is right."""

from __future__ import annotations

MEANINGS: dict[str, tuple[str, str]] = {
    # Characters, words and blocks.
    "bad_character": ("GC401", "only words, comments and a leading / or : belong into a block"),
    "comment_nested": ("GC401", "comments cannot be nested; close the first one before"),
    "comment_unclosed": ("GC401", "a comment ends with ) on its own line"),
    "duplicate_word": ("GC401", "a block takes every letter but G and M once"),
    "line_too_long": ("GC401", "a line has at most 4096 characters"),
    "modal_conflict": ("GC401", "a block takes one code of each group; write two blocks"),
    "number_expected": ("GC401", "a letter is followed by a number such as 5, -0.5 or .5"),
    "stray_percent": ("GC401", "% opens the program on its first line and ends it later"),
    "unused_word": ("GC401", "no code of this block uses the letter; remove it or add its code"),
    "axis_without_motion": ("GC401", "axis words need G0, G1, G2 or G3, in the block or active"),
    "axis_missing": ("GC401", "the code needs at least one axis word"),
    # What gcodesim does not follow.
    "unknown_g": ("GC402", "gcodesim does not follow this code, so nothing behind it is checked"),
    "unknown_word": ("GC402", "the machine file has no such axis; add it or ignore_words"),
    "macro_unsupported": ("GC402", "o-words belong to the dialect linuxcnc"),
    "parameter_unknown": ("GC402", "gcodesim does not know what the control keeps there"),
    "unknown_m": ("GC420", "if it moves no axis, list it in the machine file as shown"),
    # Arcs.
    "arc_no_center": ("GC404", "an arc needs R or both centre words of its plane"),
    "arc_radius_too_small": ("GC404", "R must reach half the distance from start to end"),
    "arc_end_equals_start": ("GC404", "an R arc needs an end point; a full circle takes I J K"),
    "arc_radius_mismatch": ("GC404", "start and end must lie equally far from the centre"),
    "arc_zero_radius": ("GC404", "the centre must not be the start point"),
    "arc_wrong_center_word": ("GC404", "G17 takes I J, G18 takes I K, G19 takes J K"),
    "arc_r_and_center": ("GC404", "an arc takes either R or centre words"),
    "arc_turns": ("GC404", "P of an arc is a whole number of turns, 1 or more"),
    # Feed and spindle.
    "feed_missing": ("GC405", "give F above 0 in or before the first feed move, or use --feed"),
    "feed_negative": ("GC405", "F must be above 0"),
    "inverse_feed_missing": ("GC405", "under G93 every G1, G2 and G3 block needs its own F"),
    "feed_per_rev_no_spindle": ("GC405", "G95 needs a spindle speed: give S above 0"),
    # Offsets, tools, reference points.
    "g53_incremental": ("GC401", "G53 takes machine coordinates, so it needs G90"),
    "offset_not_found": ("GC409", "give the work offset in the setup file"),
    "reference_not_found": ("GC409", "give the axis in the machine file under reference:"),
    "tool_not_found": ("GC409", "the tools file has no such number"),
    "tool_without_shape": ("GC421", "give a tools file; the mounted tool is used instead"),
    "tool_change_without_t": ("GC421", "select a tool with T in or before the M6 block"),
    "cutter_comp_uncompensated": ("GC422", "the programmed path runs, without the tool radius"),
    "g10_bad_l": ("GC409", "L2 and L20 set work offsets, L1, L10 and L11 tools"),
    "g10_bad_p": ("GC409", "P0 to P9 is a work offset, P1 and up a tool"),
    "rotation_without_angle": ("GC401", "give the angle as R, in degrees"),
    # Parameters, expressions, subprograms.
    "parameter_out_of_range": ("GC406", "use a parameter the control has"),
    "parameter_readonly": ("GC406", "the control keeps this value itself"),
    "parameter_undefined": ("GC425", "give the parameter a value before it is used"),
    "name_undefined": ("GC406", "give the parameter a value before it is used"),
    "division_by_zero": ("GC406", "the divisor must not be 0"),
    "function_domain": ("GC406", "the value lies outside what the function takes"),
    "expression_unclosed": ("GC406", "an expression stands between [ and ], 50 levels at most"),
    "subprogram_not_found": ("GC407", "put it into the program, or as Onnnn.nc beside it"),
    "block_not_found": ("GC407", "the program has no block with this number"),
    "call_too_deep": ("GC407", "calls nest up to 10 deep"),
    "block_structure": ("GC407", "everything opened is closed once, in order, in the same program"),
    "macro_alarm": ("GC407", "the program itself raises this alarm"),
    "main_program_repeats": ("GC430", "one pass is checked"),
    "tilted_plane_missing": ("GC401", "G53.1 follows G68.2 or G68.3"),
    "rotary_axes_missing": ("GC401", "the code needs a machine with rotary axes"),
    # Canned cycles.
    "cycle_word_missing": ("GC408", "a cycle needs R and the depth once, pecks and shifts need Q"),
    "cycle_r_below_z": ("GC408", "R lies above the bottom of the hole"),
    "cycle_q_not_positive": ("GC408", "Q must be above 0"),
    "cycle_return_unusable": ("GC408", "back boring leaves upwards: use G98"),
    "cycle_too_long": ("GC402", "gcodesim follows up to 100,000 holes or pecks of a block"),
    "rotary_in_cycle": ("GC408", "move A, B and C in a block of their own"),
    "tapping_no_spindle": ("GC408", "start the spindle with M3 or M4 before"),
    "manual_retract": ("GC423", "the tool is withdrawn by hand; the check goes on from the bottom"),
    "cycle_dwell_missing": ("GC430", "no dwell at the bottom; give P"),
    # Values.
    "negative_word": ("GC410", "the value must not be negative"),
    "integer_expected": ("GC410", "the value must be a whole number"),
    "number_too_large": ("GC410", "positions, feeds and speeds stay below 1e12"),
    "dwell_missing": ("GC410", "G4 needs a time"),
    # Flow.
    "max_blocks": ("GC424", "what follows was not checked"),
    # Worth knowing.
    "program_end_missing": ("GC430", "end the program with M30, M2 or a closing %"),
    "g28_without_axes": ("GC430", "every axis goes to the reference point"),
    "spindle_off_feed": ("GC430", "reported once; start the spindle with M3 or M4 before"),
    "exact_path_assumed": ("GC430", "gcodesim follows the exact path; a control rounds corners"),
}
"""Meaning (nc-language section 11) -> key of findings.CODES, and what would be right."""
