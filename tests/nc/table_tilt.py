"""A table-tilting machine in closed form: A tilts the table, C turns it, the tool stands upright.

The formulas are those for this one type, so that nothing of the general solver is repeated.
"""

import numpy as np

from gcodesim.errors import OrientationError

MEANINGS = {
    "tilted_plane_active": "G68.2 J30\nG68.2 J40",
    "tilted_plane_missing": "G53.1",
    "tilted_plane_not_square": "G68.2 J30\nG0 X1",
    "rotary_arc_in_tilted_plane": "G68.2 J30\nG53.1\nG2 X2 I1 A5 F100",
    "alignment_choice": "G68.2 J30\nG53.1 P3",
    "five_axis_conflict": "G54.2 P1\nG43.4 H1",
    "table_offset_turned": "G56\nG54.2 P1",
    "measured_on_tips": "G43.4 H1\nG10 L10 P1 Z0",
    "direction_zero": "G43.5 H1\nG0 X1 I0 J0 K0",
    "orientation_out_of_travel": "G43.5 H1\nG0 X1 I0 J1 K-1",
}
"""What only a machine with kinematics earns -> a program that earns it in its last line."""

RAISED = ("direction_unreachable", "kinematics_unsolved")
"""What the kinematics of other machines raise."""


def turned(vectors, axis, degrees):
    """Rodrigues' formula for vectors (n, 3) about one axis."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    along = np.outer(vectors @ axis, axis)
    return along + c * (vectors - along) + s * np.cross(axis, vectors)


class TableTilt:
    """Points are seen from the gauge point at the zero pose.

    Attributes:
        sign: -1 = A and C turn the table against the right hand (ISO), +1 = with it.
        a_point, c_point: points on the two axes.
    """

    def __init__(self, sign=-1.0, a_point=(5.0, 5.0, 41.0), c_point=(5.0, -7.0, 11.0)):
        self.u1, self.u2 = sign * np.array([1.0, 0, 0]), sign * np.array([0, 0, 1.0])
        self.p1, self.p2, self.sign = np.array(a_point), np.array(c_point), sign

    def carried(self, points, rotary):
        moved = []
        for point, (a, _, c) in zip(np.asarray(points), np.asarray(rotary), strict=True):
            arm = self.p2 - self.p1 + turned((point - self.p2)[None], self.u2, c)
            moved.append(self.p1 + turned(arm, self.u1, a)[0])
        return np.array(moved)

    def tips(self, axes, offset):
        found = []
        for (x, y, z, a, _, c), tool in zip(axes, offset, strict=True):
            arm = turned((np.array([x, y, z]) - tool - self.p1)[None], self.u1, -a)
            found.append(self.p2 + turned(self.p1 - self.p2 + arm, self.u2, -c)[0])
        return np.array(found)

    def axes_at(self, tips, rotary, offset):
        return np.hstack([self.carried(tips, rotary) + offset, rotary])

    def axis_directions(self, vectors, rotary):
        return self.carried(vectors, rotary) - self.carried(np.zeros_like(vectors), rotary)

    def directions(self, rotary):
        a, c = np.radians(np.asarray(rotary)[:, [0, 2]]).T * -self.sign
        return np.stack([np.sin(c) * np.sin(a), -np.cos(c) * np.sin(a), np.cos(a)], axis=1)

    def rotary_at(self, direction, previous, prefer=0):
        x, y, z = direction / np.linalg.norm(direction)
        tilt = np.degrees(np.arctan2(np.hypot(x, y), z))
        choices = []
        for side in (1.0, -1.0):
            a, c = -self.sign * side * tilt, previous[2]
            if tilt:
                c = -self.sign * np.degrees(np.arctan2(side * x, -side * y))
            c += 360.0 * np.round((previous[2] - c) / 360.0)
            if a * prefer >= 0 and abs(a) <= 120.0:
                choices.append(np.array([a, previous[1], c]))
        if not choices:
            raise OrientationError("orientation_out_of_travel", f"({x:g}, {y:g}, {z:g})")
        return min(choices, key=lambda q: (np.abs(q - previous).max(), q[0] < 0))
