; axis_without_motion 2 linuxcnc
X1
