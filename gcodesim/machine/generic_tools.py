"""A tools file to begin with: one tool of every type, with what to change in comments."""

from __future__ import annotations

TOOLS_TEXT = """\
# Tools to begin with. Keep the ones you have, and put in their numbers. All lengths are mm.
#
#   length    from the gauge face (of the spindle) to the tip: what you measure on the machine
#   flute     the cutting part, from the tip upwards; `gcodesim machine schema tools` has all keys
#   shank     points [radius, distance below the gauge face], from the holder to the flute
#   holder    the same; left out, the holder is not checked, and reports say so
#   offset    only where the table of the control differs: {Z: -251.3}
# `gcodesim tool show` on this file prints and draws them; --tools gives it to a check.
# A Fusion, FreeCAD, LinuxCNC or Heidenhain library: `gcodesim tool import LIB --out tools.yaml`.

tools:
  - number: 1
    name: end mill D10
    length: 120
    flute: {diameter: 10, length: 25}               # corner_radius: 1 makes a bull nose
    shank: [[5, 70], [5, 95]]                       # as thick as the flute, 25 mm of it to be seen
    holder: [[25, 0], [25, 30], [16, 30], [14, 70]]
  - number: 2
    name: ball mill D6
    type: ball                                      # taper: 3 makes a tapered ball
    length: 110
    flute: {diameter: 6, length: 12}
    shank: [[3, 70], [3, 98]]
    holder: [[25, 0], [25, 30], [16, 30], [14, 70]]
  - number: 3
    name: face mill D50, 45 degrees
    type: face
    length: 90
    flute: {diameter: 62, tip_diameter: 50, point_angle: 90, length: 10}
    shank: [[20, 40], [20, 80]]
    holder: [[31.5, 0], [31.5, 40]]
  - number: 4
    name: drill D8.5
    type: drill                                     # the length reaches to the point
    length: 160
    flute: {diameter: 8.5, length: 70, point_angle: 118}
    shank: [[4.25, 75], [4.25, 90]]
    holder: [[25, 0], [25, 30], [16, 30], [14, 75]]
  - number: 5
    name: chamfer mill D12, 90 degrees
    type: chamfer                                   # countersink: the same numbers
    length: 100
    flute: {diameter: 12, length: 12, point_angle: 90, tip_diameter: 1}
    shank: [[6, 70], [6, 88]]
    holder: [[25, 0], [25, 30], [16, 30], [14, 70]]
  - number: 6
    name: tap M10
    type: tap                                       # thread: a thread mill, the same numbers
    length: 130
    flute: {diameter: 10, length: 20, pitch: 1.5}
    shank: [[4, 80], [4, 110]]
    holder: [[25, 0], [25, 80]]
  - number: 7
    name: T-slot D20 x 4
    type: slot
    length: 110
    flute: {diameter: 20, length: 4, corner_radius: 0.3, upper_radius: 0.3}
    shank: [[5, 70], [5, 86], [3.5, 86], [3.5, 106]]     # the neck is thinner
    holder: [[25, 0], [25, 30], [16, 30], [14, 70]]
  - number: 8
    name: lollipop D12
    type: lollipop                                  # length: from the tip to the neck
    length: 110
    flute: {diameter: 12, length: 11}
    shank: [[6, 70], [6, 85], [3.3, 85], [3.3, 99]]
    holder: [[25, 0], [25, 30], [16, 30], [14, 70]]
  - number: 9
    name: dovetail D20, 60 degrees
    type: dovetail                                  # taper: narrower upwards
    length: 110
    flute: {diameter: 20, length: 8, taper: -30}
    shank: [[6, 70], [6, 102]]
    holder: [[25, 0], [25, 30], [16, 30], [14, 70]]
  - number: 10
    name: corner rounding R3
    type: radius                                    # diameter of the tip, below the hollow arc
    length: 100
    flute: {diameter: 6, length: 8, corner_radius: 3, tip_length: 1}
    shank: [[6, 70], [6, 92]]
    holder: [[25, 0], [25, 30], [16, 30], [14, 70]]
  - number: 11
    name: form cutter
    type: form                                      # points [radius, height above the tip]
    length: 100
    flute: {length: 12, profile: [[0, 0], [4, 2], [4, 6], [9, 12]]}
    shank: [[6, 70], [6, 88]]
    holder: [[25, 0], [25, 30], [16, 30], [14, 70]]
  - number: 12
    name: reamer D8 H7
    type: reamer
    length: 140
    flute: {diameter: 8, length: 30}
    shank: [[3.5, 80], [3.5, 110]]
    holder: [[25, 0], [25, 80]]
  - number: 99
    name: touch probe
    type: probe                                     # a ball; length: from its tip to the stylus
    length: 150
    flute: {diameter: 6, length: 5.5}
    shank: [[10, 80], [10, 100], [1.5, 100], [1.5, 144.5]]
    holder: [[32, 0], [32, 80]]
"""
