"""G codes whose numbers stand in the code, each by what it means; in tenths: G43.4 is 434."""

from __future__ import annotations

from dataclasses import dataclass, field

from gcodesim.nc.control.modal import Motion


class G:
    """G codes, in tenths: plain numbers, for every block is compared with some of them."""

    RAPID, FEED, CLOCKWISE, COUNTER_CLOCKWISE = 0, 10, 20, 30
    TABLE = 100
    POLAR_OFF, POLAR = 150, 160
    PLANE_XY, PLANE_ZX, PLANE_YZ = 170, 180, 190
    INCH, MILLIMETRE = 200, 210
    REFERENCE, SECOND_REFERENCE = 280, 300
    THREADING, RIGID_TAPPING = 330, 331
    COMPENSATION_OFF, LEFT, RIGHT, LEFT_BY, RIGHT_BY = 400, 410, 420, 411, 421
    LENGTH, LENGTH_IN_WORDS, LENGTH_ADDED, LENGTH_NEGATIVE = 430, 431, 432, 440
    TIP, TIP_BY_VECTORS, TIP_OF_HAAS = 434, 435, 2340
    LENGTH_OFF = 490
    MIRROR_OFF, MIRROR, SCALING = 501, 511, 510
    LOCAL_OFFSET = 520
    MACHINE_COORDINATES, ALIGN_TOOL = 530, 531
    WORK_OFFSET, WORK_OFFSET_9 = 540, 590
    TABLE_OFFSET, TABLE_OFFSET_OF_HAAS, TABLE_OFFSET_OFF = 542, 2540, 2550
    CONTINUOUS_PATH = 640
    MACRO_CALL = 650
    ROTATION, PLANE, PLANE_OF_TOOL, FURTHER_PLANE, PLANE_OF_HAAS = 680, 682, 683, 684, 2680
    CHIP_BREAKING, LEFT_TAPPING, FINE_BORING = 730, 740, 760
    CYCLE_OFF = 800
    DRILLING, DWELL_DRILLING, PECKING, TAPPING = 810, 820, 830, 840
    BORING, STOP_BORING, BACK_BORING, MANUAL_BORING, DWELL_BORING = 850, 860, 870, 880, 890
    ABSOLUTE, ABSOLUTE_CENTRES = 900, 901
    INCREMENTAL, INCREMENTAL_CENTRES = 910, 911
    CLEAR_G92, SUSPEND_G92, RESTORE_G92 = 921, 922, 923
    INVERSE_TIME, PER_MINUTE, PER_REVOLUTION = 930, 940, 950
    SURFACE_SPEED, SPINDLE_SPEED = 960, 970
    RETURN_TO_START, RETURN_TO_R = 980, 990


@dataclass(slots=True)
class Codes:
    """The codes in force that only this language knows, and what they keep.

    Attributes:
        cycle: of the cycle in force, 0 = none.
        cycle_words: words the cycle keeps, lengths in mm and P in seconds; Z is the depth.
        initial: depth-axis value when the cycle became modal [mm].
        compensation, length, cycle_return, work_offset: codes of their groups.
        length_entry: row of the tool table that H named last, None before the first H.
        tip: code that switched tool centre point control on, 0 when it is off.
        offset: number of the active work offset, 1 = G54, 101.. = G54.1 P1..
        polar: words of the plane are radius and angle.
        pole, radius, angle: centre, radius [mm] and angle [deg] of the last polar point.
        rigid_tapping: M29 was read: tapping cycles turn the spindle themselves.
    """

    cycle: int = 0
    cycle_words: dict[str, float] = field(default_factory=dict)
    initial: float = 0.0
    compensation: int = G.COMPENSATION_OFF
    length: int = G.LENGTH_OFF
    length_entry: int | None = None
    tip: int = 0
    cycle_return: int = G.RETURN_TO_START
    work_offset: int = G.WORK_OFFSET
    offset: int = 1
    polar: bool = False
    pole: tuple[float, float] = (0.0, 0.0)
    radius: float = 0.0
    angle: float = 0.0
    rigid_tapping: bool = False


IN_STEP = {Motion.THREADING: G.THREADING, Motion.RIGID_TAPPING: G.RIGID_TAPPING}
"""Motion in step with the spindle -> its code."""


def motion_code(motion: Motion) -> int:
    """Return the G code of a kind of motion, G80 for none."""
    return IN_STEP.get(motion, G.CYCLE_OFF if motion is Motion.NONE else motion * 10)
