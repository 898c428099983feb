"""Parameters of macros: local, global and named ones, and the system's own."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from gcodesim.errors import GcodesimError
from gcodesim.nc.control.state import INCH, LIMIT
from gcodesim.nc.control.supply import WorkOffset
from gcodesim.nc.iso.g_codes import G, motion_code
from gcodesim.nc.iso.macro_rules import MACROS
from gcodesim.nc.iso.memory import IsoState
from gcodesim.nc.iso.predefined import OUTSIDE, PREDEFINED
from gcodesim.nc.program import AXES

REFERENCES = {5161: "G28", 5181: "G30"}
FIRST_OFFSET = 5221
ALARM, OPERATOR_STOP = 3000, 3006
UNKNOWN = math.nan
"""Value of what an earlier program may have left; whatever is made of it is unknown too."""

IGNORED = (3003, 3004)
"""Fanuc: suppression of single block and feed hold, which move nothing."""

DEBUG_ON = 5599
"""LinuxCNC: whether DEBUG comments are shown."""


class ExpressionError(GcodesimError):
    """An expression that cannot be read or has no value.

    Attributes:
        meaning: key of MEANINGS.
        place: index in the text without blanks.
    """

    def __init__(self, meaning: str, what: str, place: int) -> None:
        self.meaning, self.place = meaning, place
        super().__init__(what)


@dataclass(slots=True)
class Locals:
    """What belongs to one call: numbered and named local parameters."""

    numbers: dict[float, float | None] = field(default_factory=dict)
    names: dict[str, float | None] = field(default_factory=dict)


class Parameters:
    """All parameters a program can reach.

    Attributes:
        state: where system parameters are read from.
        rules: of the language of the macros.
        local: parameters of the call that is running.
        numbers: those written in the block that is carried out, see Parser.slots.
        undefined: called with the number of a parameter that is read before it was given a value.
    """

    def __init__(self, state: IsoState) -> None:
        self.state, self.local = state, Locals()
        self.rules = MACROS[state.control.readings.macros]
        self._globals = Locals(
            {
                float(number): value
                for number, value in state.control.variables.items()
                if number > self.rules.locals and number not in self.rules.system
            }
        )
        self.numbers: Sequence[float] = ()
        self.undefined: Callable[[int], None] = lambda number: None

    def seen(self) -> tuple[object, ...]:
        """Return the values of all parameters that a program has set."""
        return self.local, self._globals

    def get(self, value: float, place: int) -> float | None:
        """Return a numbered parameter; None when it is vacant, UNKNOWN when nobody has set it.

        Raises:
            ExpressionError: there is none with this number, or its value is not known.
        """
        # What was given a value is found by it: 1.0 and 1 are the same key.
        known = self.local.numbers
        if value in known:
            return known[value]
        known = self._globals.numbers
        if value in known:
            return known[value]
        number = self._number(value, place)
        if self._holder(number) is None:
            return self._system(number, place)
        if self.rules.vacant:
            return None if number <= self.rules.locals else UNKNOWN
        self.undefined(number)
        return 0.0

    def set(self, value: float, new: float | None, place: int) -> None:
        """Give a numbered parameter a value.

        Raises:
            ExpressionError: it cannot be written.
        """
        for known in (self.local.numbers, self._globals.numbers):
            if value in known:
                known[value] = new
                return
        number = self._number(value, place)
        if not number or any(number in span for span in self.rules.read_only):
            raise ExpressionError("parameter_readonly", f"#{number}", place)
        holder = self._holder(number)
        if holder is None:
            self._set_system(number, new or 0.0, place)
        else:
            holder[number] = new

    def _holder(self, number: int) -> dict[float, float | None] | None:
        """Return where a parameter is kept; None for those of the system."""
        if number <= self.rules.locals:
            return self.local.numbers
        return None if number in self.rules.system else self._globals.numbers

    def named(self, name: str, place: int) -> float | None:
        """Return a named parameter.

        Raises:
            ExpressionError: it has no value.
        """
        holder = self._globals if name.startswith("_") else self.local
        if name in holder.names:
            return holder.names[name]
        if name in PREDEFINED and (value := PREDEFINED[name](self.state)) is not None:
            return value
        if name in PREDEFINED or OUTSIDE.fullmatch(name):
            raise ExpressionError("parameter_unknown", f"#<{name}>", place)
        raise ExpressionError("name_undefined", f"#<{name}>", place)

    def set_named(self, name: str, value: float | None) -> None:
        """Give a named parameter a value; names with a leading _ are global."""
        holder = self._globals if name.startswith("_") else self.local
        holder.names[name] = value

    def has_name(self, name: str, place: int) -> bool:
        """EXISTS[#<name>].

        Raises:
            ExpressionError: only the running control knows.
        """
        if OUTSIDE.fullmatch(name):
            raise ExpressionError("parameter_unknown", f"#<{name}>", place)
        holder = self._globals if name.startswith("_") else self.local
        return name in holder.names or name in PREDEFINED

    def _number(self, value: float, place: int) -> int:
        if value != value:
            raise ExpressionError("value_unknown", "# of a value that nobody gave", place)
        lowest, last = self.rules.lowest, self.rules.last
        if not lowest <= value <= last or not value.is_integer():
            what = f"#{value:g}: there are #{lowest} to #{last}"
            raise ExpressionError("parameter_out_of_range", what, place)
        return int(value)

    def _system(self, number: int, place: int) -> float | None:
        value = LAYOUTS[self.rules.layout][0](self, number)
        if value is None:
            raise ExpressionError("parameter_unknown", f"#{number}", place)
        return value

    def macro_b(self, number: int) -> float | None:
        """Return a system parameter of Macro B, None where it is not known."""
        state, i = self.state, number % 20 - 1
        if number in MODAL:
            return MODAL[number](state)
        if number // 20 in (250, 251, 252) and self._is_probed(i):
            return None
        if i in range(6) and number // 20 == 251:
            return self._length(state.axes[i], i)
        if i in range(6) and number // 20 in (250, 252):
            return self._length(state.point[i], i)
        index, i = divmod(number - FIRST_OFFSET, 20)
        if index in range(6) and i in range(6):
            return self._length(state.offsets.get(index + 1, WorkOffset()).value[i], i)
        return None

    def linuxcnc(self, number: int) -> float | None:
        """Return a system parameter of LinuxCNC, None where it is not known."""
        state = self.state
        for first, code in REFERENCES.items():
            if number - first in range(6):
                return state.reference[code].get(AXES[number - first], 0.0)
        if number == 5400:
            return float(state.modal.tool or 0)
        if number - 5401 in range(6):
            return self._tool_in_spindle(number - 5401)
        if number - 5420 in range(6):
            if self._is_probed(number - 5420):
                return None
            return self._length(state.point[number - 5420], number - 5420)
        if number == 5220:
            return float(state.codes.offset)
        index, i = divmod(number - FIRST_OFFSET, 20)
        if index in range(9) and i in range(6):
            return self._own_unit(state.offsets.get(index + 1, WorkOffset()).value[i], i)
        return None

    def _is_probed(self, i: int) -> bool:
        """Tell whether only a probe knows where an axis stands."""
        return self.state.skipped is not None and i in self.state.skipped.axes

    def _tool_in_spindle(self, i: int) -> float:
        """Return the tool table's offset for the tool in the spindle, whatever G43 has set."""
        state, control = self.state, self.state.control
        entry = (state.tools or {}).get(state.modal.tool or 0)
        if entry is None:
            mounted = control.mounted_length if control.tool_for_all and i == 2 else 0.0
            return mounted if state.tools is None and state.modal.tool else 0.0
        return self._own_unit(entry.offset[i], i)

    def _own_unit(self, value: float, i: int) -> float:
        """Return a value of the control's tables: G20 and G21 do not change its unit."""
        inch = self.state.control.readings.program_unit == "inch"
        return value / (INCH if inch and i < 3 else 1.0)

    def _length(self, value: float, i: int) -> float:
        return value / self.state.scale if i < 3 else value

    def _set_system(self, number: int, value: float, place: int) -> None:
        if not LAYOUTS[self.rules.layout][1](self, number, value):
            raise ExpressionError("parameter_unknown", f"writing #{number}", place)

    def set_macro_b(self, number: int, value: float) -> bool:
        """Write a system parameter of Macro B; return whether that can be followed."""
        if number in (ALARM, OPERATOR_STOP):
            self.state.stop_request = (number, value)
        return number in (ALARM, OPERATOR_STOP, *IGNORED)

    def set_linuxcnc(self, number: int, value: float) -> bool:
        """Write a system parameter of LinuxCNC; return whether that can be followed."""
        for first, code in REFERENCES.items():
            if number - first in range(6) and abs(value) <= LIMIT:
                self.state.reference[code][AXES[number - first]] = value
                return True
        return number == DEBUG_ON


Reader = Callable[[Parameters, int], float | None]
Writer = Callable[[Parameters, int, float], bool]

LAYOUTS: dict[str, tuple[Reader, Writer]] = {
    "macro_b": (Parameters.macro_b, Parameters.set_macro_b),
    "linuxcnc": (Parameters.linuxcnc, Parameters.set_linuxcnc),
}
"""MacroRules.layout -> how the system's parameters are read and written."""

MODAL: dict[int, Callable[[IsoState], float]] = {
    4001: lambda s: motion_code(s.modal.motion) / 10,
    4002: lambda s: 17.0 + s.modal.plane,
    4003: lambda s: 91.0 if s.modal.incremental else 90.0,
    4005: lambda s: float(s.modal.feed_mode),
    4006: lambda s: 20.0 if s.modal.inch else 21.0,
    4007: lambda s: s.codes.compensation / 10,
    4008: lambda s: s.codes.length / 10,
    4009: lambda s: (s.codes.cycle or G.CYCLE_OFF) / 10,
    4010: lambda s: s.codes.cycle_return / 10,
    4014: lambda s: s.codes.work_offset / 10,
    4109: lambda s: s.modal.feed or 0.0,
    4119: lambda s: s.modal.speed,
    4120: lambda s: float(s.modal.selected or 0),
}
"""Fanuc: number -> modal information."""
