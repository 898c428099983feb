; axis_without_motion 3 linuxcnc
G0 X1
G80 X5
