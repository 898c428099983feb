"""Machines to begin with, written as YAML: boxes and cylinders, no mesh file, sensible travels."""

from __future__ import annotations

import re
from dataclasses import dataclass

HEAD = """\
# {title}
#
# A generic machine, not a real one. Replace, in this order:
#   1. joints: axis, point, limits and rapid, from the builder's papers. Jog every axis plus and
#      look which way its link really goes: `axis` is the direction of the CHILD link. Seen from
#      above, a table that turns clockwise at C plus (ISO 841) has the axis [0, 0, -1].
#   2. tool and work: where the spindle face is at the zero pose, and the zero points.
#   3. links: the shapes, as boxes and cylinders or as `mesh: file.stl` beside this file; all
#      of them in WORLD coordinates at the zero pose of all joints.
# Then `gcodesim machine lint` on this file; `verified: true` once the machine has been measured.
# Lengths mm, angles degrees, speeds mm/min and deg/min, accelerations mm/s^2 and deg/s^2.

name: {name}
verified: false              # the model was not measured on the real machine: reports say so
units: mm                    # of mesh files, when there are any
dialect: auto                # auto: the text tells it; or fanuc | haas | linuxcnc | grbl

"""

TAIL = """\

tool:
  link: {spindle}
  gauge_point: [0, 0, {gauge}]   # spindle face centre at the zero pose
  axis: [0, 0, 1]            # from the tip towards the spindle
  mounted:                   # `for: all`: it stands for every T number; else give --tools
    {{name: cutter, length: {length}, for: all, parts: [
      {{name: holder, cylinder: {{radius: 25, height: {holder}, center: [0, 0, {holder_z}]}}}},
      {{name: flute, cylinder: {{radius: {radius}, height: {flute}, center: [0, 0, {flute_z}]}}}}]}}
work:
  link: {work}
  offsets: {{G54: {{X: 0, Y: 0, Z: {zero}}}}}    # from the spindle face down to the table surface
reference: {{G28: {{{home}}}}}
start: {{{home}}}

# Left out, `pairs` are every two links with a moving joint between them, less neighbours.
control:                     # what parameters of the control decide: look them up, or write `both`
  no_point: units            # X100 without a decimal point: 100 mm (units) or 0.1 mm (increment)
  program_unit: mm           # of programs without G20 and G21: mm | inch
  m6_order: first            # M6 beside motion words: changes the tool first, or last
  rapids: linear             # linear: straight; dogleg: every axis at its own rate
  g28_no_axes: all           # G28 without axis words: all | none go
  length_after_reference: kept    # tool length after G28 G30 G53 of Z: kept | cancelled
  length_change: next_move   # G43 or G49 without Z: the next_move brings it, or Z goes at_once
  tool_change: both          # M6: the axes are where the program left them (stays), Z goes to the
                             # reference point, or: {{retract: [Z], position: {{Z: 0}}, seconds: 6}}
path_tolerance: {{G64: null, rapid: null}}    # mm; null: exact path assumed, and the report says so
"""

TABLE_TABLE = """\
links:                       # the origin lies on the spindle axis, at the height of the A axis
  bed:                       # base and the column behind it; it does not move
    parts:
      - {name: base, box: {size: [1000, 1000, 100], center: [0, 0, -430]}}
      - {name: column, box: {size: [500, 200, 1180], center: [0, 650, 210]}}
  Y: {box: {size: [700, 500, 80], center: [0, 0, -335]}}
  X:                         # saddle with the two uprights that hold the cradle
    parts:
      - {name: saddle, box: {size: [600, 400, 60], center: [0, 0, -260]}}
      - {name: left, box: {size: [60, 120, 300], center: [-265, 0, -80]}}
      - {name: right, box: {size: [60, 120, 300], center: [265, 0, -80]}}
  A:                         # cradle, between the uprights
    parts:
      - {name: floor, box: {size: [400, 200, 40], center: [0, 0, -120]}}
      - {name: left, box: {size: [30, 100, 140], center: [-190, 0, -30]}}
      - {name: right, box: {size: [30, 100, 140], center: [190, 0, -30]}}
      - {name: journal_left, cylinder: {radius: 30, height: 25, center: [-217, 0, 0], axis: [1, 0, 0]}}
      - {name: journal_right, cylinder: {radius: 30, height: 25, center: [217, 0, 0], axis: [1, 0, 0]}}
  C: {cylinder: {radius: 125, height: 38, center: [0, 0, -79]}}    # rotary table, surface at z = -60
  Z:                         # spindle head
    parts:
      - {name: head, box: {size: [200, 560, 300], center: [0, 230, 550]}}
      - {name: nose, cylinder: {radius: 60, height: 100, center: [0, 0, 350]}}

joints:
  Y: {type: linear, parent: bed, child: Y, axis: [0, -1, 0], limits: [-200, 200], rapid: 24000, max_acceleration: 4000}
  X: {type: linear, parent: Y, child: X, axis: [-1, 0, 0], limits: [-250, 250], rapid: 24000, max_acceleration: 4000}
  # `point` is any point on the axis of rotation, at the zero pose.
  A: {type: rotary, parent: X, child: A, axis: [-1, 0, 0], point: [0, 0, 0], limits: [-110, 30], rapid: 9000, max_acceleration: 600}
  # No limits: C turns for ever. `wrap: shortest` takes the nearer way to an angle.
  C: {type: rotary, parent: A, child: C, axis: [0, 0, -1], point: [0, 0, 0], rapid: 18000, wrap: shortest, max_acceleration: 1500}
  Z: {type: linear, parent: bed, child: Z, axis: [0, 0, 1], limits: [-400, 0], rapid: 24000, max_acceleration: 4000}
"""  # noqa: E501 (one line per joint)

HEAD_TABLE = """\
links:                       # the origin lies on the spindle axis and on the axis of the table
  bed:                       # base and the column behind it; it does not move
    parts:
      - {name: base, box: {size: [1200, 1400, 150], center: [0, 300, -250]}}
      - {name: column, box: {size: [500, 450, 670], center: [0, 825, 160]}}
  X: {box: {size: [500, 400, 80], center: [0, 0, -125]}}
  C: {cylinder: {radius: 160, height: 50, center: [0, 0, -50]}}    # rotary table, surface at z = -25
  Y: {box: {size: [400, 900, 300], center: [0, 600, 655]}}         # ram on top of the column
  Z:                         # head, with the bracket that holds the fork
    parts:
      - {name: head, box: {size: [300, 190, 500], center: [0, 45, 750]}}
      - {name: bracket, box: {size: [120, 75, 250], center: [0, 102, 385]}}
  B:                         # the spindle turns in the bracket
    parts:
      - {name: housing, box: {size: [140, 120, 180], center: [0, 0, 350]}}
      - {name: nose, cylinder: {radius: 45, height: 60, center: [0, 0, 230]}}

joints:
  X: {type: linear, parent: bed, child: X, axis: [-1, 0, 0], limits: [-300, 300], rapid: 30000, max_acceleration: 5000}
  # `point` is any point on the axis of rotation, at the zero pose. No limits: C turns for ever.
  C: {type: rotary, parent: X, child: C, axis: [0, 0, -1], point: [0, 0, 0], rapid: 18000, wrap: shortest, max_acceleration: 1500}
  Y: {type: linear, parent: bed, child: Y, axis: [0, 1, 0], limits: [-200, 200], rapid: 30000, max_acceleration: 5000}
  Z: {type: linear, parent: Y, child: Z, axis: [0, 0, 1], limits: [-400, 0], rapid: 30000, max_acceleration: 5000}
  B: {type: rotary, parent: Z, child: B, axis: [0, 1, 0], point: [0, 0, 340], limits: [-95, 95], rapid: 12000, max_acceleration: 800}
"""  # noqa: E501 (one line per joint)

HEAD_HEAD = """\
links:                       # a portal; the origin lies on the spindle axis
  bed:                       # fixed table and the two walls that carry the bridge
    parts:
      - {name: table, box: {size: [1200, 800, 100], center: [0, 0, -350]}}    # surface at z = -300
      - {name: front, box: {size: [1800, 100, 1195], center: [0, -700, 200]}}
      - {name: back, box: {size: [1800, 100, 1195], center: [0, 700, 200]}}
  X: {box: {size: [250, 1500, 300], center: [330, 0, 955]}}      # bridge
  Y: {box: {size: [80, 400, 400], center: [160, 0, 960]}}        # saddle in front of the bridge
  Z: {box: {size: [200, 200, 700], center: [15, 0, 950]}}        # ram
  C:                         # fork
    parts:
      - {name: hub, cylinder: {radius: 80, height: 80, center: [0, 0, 555]}}
      - {name: left, box: {size: [80, 25, 160], center: [0, -82.5, 435]}}
      - {name: right, box: {size: [80, 25, 160], center: [0, 82.5, 435]}}
  B:                         # spindle between the arms of the fork
    parts:
      - {name: housing, box: {size: [110, 120, 200], center: [0, 0, 380]}}
      - {name: nose, cylinder: {radius: 40, height: 60, center: [0, 0, 250]}}

joints:
  X: {type: linear, parent: bed, child: X, axis: [1, 0, 0], limits: [-400, 400], rapid: 30000, max_acceleration: 4000}
  Y: {type: linear, parent: X, child: Y, axis: [0, 1, 0], limits: [-350, 350], rapid: 30000, max_acceleration: 4000}
  Z: {type: linear, parent: Y, child: Z, axis: [0, 0, 1], limits: [-600, 0], rapid: 24000, max_acceleration: 4000}
  # `point` is any point on the axis of rotation, at the zero pose.
  C: {type: rotary, parent: Z, child: C, axis: [0, 0, 1], point: [0, 0, 400], limits: [-360, 360], rapid: 15000, max_acceleration: 800}
  B: {type: rotary, parent: C, child: B, axis: [0, 1, 0], point: [0, 0, 400], limits: [-110, 110], rapid: 12000, max_acceleration: 800}
"""  # noqa: E501 (one line per joint)

THREE_AXIS = """\
links:                       # the origin lies on the spindle axis
  bed:                       # base and the column behind it; it does not move
    parts:
      - {name: base, box: {size: [1000, 1000, 100], center: [0, 0, -430]}}
      - {name: column, box: {size: [500, 200, 1180], center: [0, 650, 210]}}
  Y: {box: {size: [700, 500, 80], center: [0, 0, -335]}}
  X: {box: {size: [900, 400, 60], center: [0, 0, -260]}}    # table, surface at z = -230
  Z:                         # spindle head
    parts:
      - {name: head, box: {size: [200, 560, 300], center: [0, 230, 550]}}
      - {name: nose, cylinder: {radius: 60, height: 100, center: [0, 0, 350]}}

joints:
  Y: {type: linear, parent: bed, child: Y, axis: [0, -1, 0], limits: [-200, 200], rapid: 24000, max_acceleration: 4000}
  X: {type: linear, parent: Y, child: X, axis: [-1, 0, 0], limits: [-350, 350], rapid: 24000, max_acceleration: 4000}
  Z: {type: linear, parent: bed, child: Z, axis: [0, 0, 1], limits: [-400, 0], rapid: 24000, max_acceleration: 4000}
"""  # noqa: E501 (one line per joint)


@dataclass(frozen=True)
class GenericMachine:
    """A machine to begin with.

    Attributes:
        title: first line of its file.
        tree: links and joints, as YAML.
        axes: letters of its axes.
        spindle, work: links that carry the tool and the work.
        gauge: height of the spindle face at the zero pose [mm].
        surface: height of the table's surface at the zero pose [mm].
        holder, flute: heights of the two parts of the mounted tool [mm].
        radius: of its flute [mm].
    """

    title: str
    tree: str
    axes: str
    spindle: str
    work: str
    gauge: int
    surface: int
    holder: int
    flute: int
    radius: int

    def text(self, name: str) -> str:
        """The machine file; characters that no name may have become `_`."""
        tail = TAIL.format(
            **vars(self),
            home=", ".join(f"{axis}: 0" for axis in self.axes),
            length=self.holder + self.flute,
            holder_z=f"{self.gauge - self.holder / 2:g}",
            flute_z=f"{self.gauge - self.holder - self.flute / 2:g}",
            zero=self.surface - self.gauge,
        )
        plain = re.sub(r"[^A-Za-z0-9_-]", "_", name)
        return HEAD.format(title=self.title, name=plain) + self.tree + tail


MACHINES = {
    "table-table": GenericMachine(
        "Table-tilting: cradle A and rotary table C carry the work", TABLE_TABLE,
        axes="XYZAC", spindle="Z", work="C", gauge=300, surface=-60, holder=70, flute=80, radius=5,
    ),
    "head-table": GenericMachine(
        "Mixed: spindle head B, rotary table C", HEAD_TABLE,
        axes="XYZBC", spindle="B", work="C", gauge=200, surface=-25, holder=60, flute=60, radius=5,
    ),
    "head-head": GenericMachine(
        "Spindle-tilting: fork C and spindle B carry the tool", HEAD_HEAD,
        axes="XYZBC", spindle="B", work="bed", gauge=220, surface=-300,
        holder=60, flute=70, radius=6,
    ),
    "three-axis": GenericMachine(
        "Three axes: X and Y move the table, Z the spindle", THREE_AXIS,
        axes="XYZ", spindle="Z", work="X", gauge=300, surface=-230, holder=70, flute=80, radius=5,
    ),
}  # fmt: skip
"""Kind -> the machine."""


def machine_text(kind: str, name: str) -> str:
    """A machine file of a kind, a key of MACHINES."""
    return MACHINES[kind].text(name)
