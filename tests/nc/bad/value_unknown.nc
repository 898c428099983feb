; value_unknown 2
G0 X#500
M30
