"""Codes of the table that belong to one control: claimed words, off-switches, refused by name."""

from __future__ import annotations

from gcodesim.nc.iso.code_rows import AXIS_WORDS, Group, Order, Row

_FANUC_HAAS = "fanuc haas"
_FIRST_G110, _HAAS_OFFSETS = 1100, 20
_M_OF_HAAS = (
    *(31, 33, 34, 36, *range(51, 59), 61, 66, 73, 74, 83, 84, 88, 89, 95),
    *(104, 105, 109, 154, 155),
)
"""M codes of Haas that move no axis, besides those all dialects have."""


def refused(
    number: int, sentence: str, reason: str, dialects: str = "", group: Group = Group.ONE_SHOT
) -> Row:
    """Return the row of a G code that moves an axis, or changes the path, as is not followed."""
    return Row("G", number, group, Order.OTHER, "", sentence, refused=reason, dialects=dialects)


def _off(numbers: tuple[int, ...], dialects: str, words: str = "") -> tuple[Row, ...]:
    """Return rows of codes that end what can never have begun."""
    return tuple(
        Row("G", number, Group.NONE, Order.OTHER, words, "Off", dialects=dialects)
        for number in numbers
    )


# fmt: off
OWN_CODES: tuple[Row, ...] = (
    # Off-switches of modes that are never on.
    *_off((90, 110, 131, 230, 250, 260, 401, 491, 500, 620, 630, 670, 691), _FANUC_HAAS),
    *_off((80,), "linuxcnc"),
    refused(70, "Diameters", "diameters are for lathes", "linuxcnc"),
    Row("G", 1000, Group.NONE, Order.WORK_OFFSET, AXIS_WORDS, "Mirror of Haas off",
        dialects="haas", optional=True),
    Row("G", 220, Group.ONE_SHOT, Order.OTHER, AXIS_WORDS + "IJK", "Stroke limit",
        dialects="fanuc"),
    # Smoothing and limits that name axes.
    Row("G", 51, Group.NONE, Order.OTHER, AXIS_WORDS + "QRP", "Look-ahead and smoothing",
        dialects=_FANUC_HAAS),
    Row("G", 1030, Group.NONE, Order.OTHER, "P", "Look-ahead of Haas", dialects="haas"),
    Row("G", 544, Group.NONE, Order.OTHER, AXIS_WORDS + "P", "Setup error",
        "set_setup_error", dialects="fanuc"),
    Row("G", 510, Group.ONE_SHOT, Order.WORK_OFFSET, AXIS_WORDS + "IJKP", "Scaling",
        "scale_by_thousandths", dialects="fanuc"),
    Row("G", 510, Group.ONE_SHOT, Order.WORK_OFFSET, AXIS_WORDS + "IJKP", "Scaling",
        "scale", dialects="haas"),
    *(Row("G", number, Group.ONE_SHOT, Order.OTHER, AXIS_WORDS + "RQ", "Words on a cylinder",
          "wrap_on_cylinder", dialects=dialects)
      for number, dialects in ((71, "fanuc"), (1070, _FANUC_HAAS))),
    *(Row("G", _FIRST_G110 + 10 * index, Group.WORK_OFFSET, Order.WORK_OFFSET, "",
          f"Work offset G154 P{index + 1}", "set_haas_offset", dialects="haas")
      for index in range(_HAAS_OFFSETS)),
    # Refused by name.
    *(refused(number, "Polar interpolation", "a path on a turning table is not followed", dialects)
      for number, dialects in ((121, "fanuc"), (1120, "fanuc"))),
    refused(431, "Length along the tool axis", "the length is followed along Z, or by G43.4",
            "fanuc", Group.LENGTH),
    *(refused(number, "Circular pocket", "pockets of the control are not followed", "haas")
      for number in (120, 130, 1500)),
    refused(470, "Engraving", "text is not followed", "haas"),
    *(refused(number, "Holes in a pattern", "patterns of holes are not followed", "haas")
      for number in (700, 710, 720)),
    *(refused(number, "Probing by the control", "where it stops is not known", "haas")
      for number in (350, 360, 370, 1360)),
    *(refused(number, "Tapping by the control", "this cycle is not followed", "haas")
      for number in (1740, 1840)),
    *(refused(number, "Boring by the control", "this cycle is not followed", "haas", Group.CYCLE)
      for number in (770, 870)),
    refused(600, "Approach from one side", "the way past the point is not known", _FANUC_HAAS),
    refused(1010, "Mirror of Haas", "write G51.1", "haas"),
    refused(1430, "Length of Haas", "the length is followed along Z, or by G234", "haas"),
    refused(2660, "Rapid of one axis in machine coordinates", "write G53", "haas"),
    # M codes.
    *(Row("M", number * 10, Group.NONE, Order.OTHER, "PQR", "Own code of Haas", dialects="haas")
      for number in _M_OF_HAAS),
)
# fmt: on
"""Rows of the table of codes that one or two dialects have."""
