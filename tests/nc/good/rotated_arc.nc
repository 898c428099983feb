; linuxcnc: arcs under a work offset turned by 90 degrees; computed by hand
G56 G0 X0 Y0
G3 X10 Y0 I5 F100 S1000 M3
G18 G2 X0 I-5
M2
