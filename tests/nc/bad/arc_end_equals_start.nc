; arc_end_equals_start 2 linuxcnc
G2 X0 Y0 R5 F100
