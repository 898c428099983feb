; parameter_undefined 2
G0 X#7 Y1
M30
