; modal_conflict 2 linuxcnc
G0 G1 X1 F100
