; measured_by_probe 4
F100 G0 Z50
G31 Z10
G92 Z0
M30
