; modal_conflict 2
G0 G1 X1 F100
