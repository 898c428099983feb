; position_unknown 4
F100 G0 Z50
G31 Z10
G0 X5
G0 Z50
M30
