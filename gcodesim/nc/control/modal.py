"""The modal state: one field per modal group, codes in tenths (G43.1 is 431)."""

from __future__ import annotations

from dataclasses import dataclass, field

TABLE_OFFSET_OFF = 2550


@dataclass(slots=True)
class Modal:
    """What stays in force from block to block; the comments list the members of each group.

    Attributes:
        feed: F as programmed, None when missing or cleared by a change of feed mode.
        feed_scale: mm per length unit that was in force at the F word.
        feed_given: an F word was read, so Control.feed no longer stands in.
        speed: S [rev/min].
        selected: tool number of the last T, None before it.
        tool: tool number in the spindle, None before the first change.
        cycle_words: words the cycle keeps, lengths in mm and P in seconds; Z is the depth.
        initial: depth-axis value when the cycle became modal [mm].
        pole, radius, angle: centre, radius [mm] and angle [deg] of the last polar point.
        rigid_tapping: M29 was read: tapping cycles turn the spindle themselves.
    """

    motion: int = 800  # G0 G1 G2 G3, G80 = none
    cycle: int = 0  # G73 G74 G76 G81 .. G89, 0 = none
    plane: int = 170  # G17 G18 G19
    distance: int = 900  # G90 G91
    centre_distance: int = 911  # G90.1 G91.1
    feed_mode: int = 940  # G93 G94 G95
    unit: int = 210  # G20 G21
    compensation: int = 400  # G40; G41 G42 G41.1 G42.1 are reported and the path runs as written
    length: int = 490  # G43 G43.1 G43.2 G44 G49 G43.4 G43.5 G234
    tcp: int = 0  # G43.4 G43.5 G234 M428 when X Y Z are the tip, else 0
    table_offset: int = TABLE_OFFSET_OFF  # G254 G54.2, G255
    cycle_return: int = 980  # G98 G99
    work_offset: int = 540  # G54 .. G59, G59.1 .. G59.3, G54.1
    path: int = 640  # G61 G61.1 G64; motion/ reads them from the commands
    spindle: int = 50  # M3 M4 M5 M19
    polar: int = 150  # G15 G16
    surface_speed: bool = False  # G96 G97: S is no number of revolutions
    # coolant: M7 M8 M9; not kept, it moves nothing
    # plane frame: G68 G68.2 G68.3 G69; mirror: G51.1 G50.1; kept in Frames
    feed: float | None = None
    feed_scale: float = 1.0
    feed_given: bool = False
    speed: float = 0.0
    selected: int | None = None
    tool: int | None = None
    cycle_words: dict[str, float] = field(default_factory=dict)
    initial: float = 0.0
    pole: tuple[float, float] = (0.0, 0.0)
    radius: float = 0.0
    angle: float = 0.0
    rigid_tapping: bool = False
