; modes_not_saved 3 linuxcnc
G0 X1
M72
M2
