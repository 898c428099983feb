"""A case of the study of stability: one quantity, by the usual formulation and by ours."""

from __future__ import annotations

from dataclasses import dataclass


def power(number: float) -> str:
    """A power of ten, briefly: 1e7, 1e-4."""
    mantissa, exponent = f"{number:.0e}".split("e")
    return f"{mantissa}e{int(exponent)}"


@dataclass(frozen=True)
class Case:
    """One line of the table.

    Attributes:
        topic: what the case is about.
        case: the stiff or extreme input.
        quantity: what is measured; 0 is perfect.
        usual: the usual formulation; empty where there is none to compare with.
        naive: what that one gives.
        ours: what gcodesim gives.
        tolerance: the largest value that is right.
        unit: of all three.
    """

    topic: str
    case: str
    quantity: str
    usual: str
    naive: float | None
    ours: float
    tolerance: float
    unit: str

    @property
    def ok(self) -> bool:
        """Ours keeps the tolerance; what is not a number does not."""
        return bool(self.ours <= self.tolerance)

    @property
    def naive_ok(self) -> bool | None:
        """The usual formulation keeps it too; None where there is none."""
        return None if self.naive is None else bool(self.naive <= self.tolerance)
