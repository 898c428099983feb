; axis_without_motion 2 linuxcnc
G53 X1
