; too_many_m 2 fanuc
M3 M8 M10 M48
M30
