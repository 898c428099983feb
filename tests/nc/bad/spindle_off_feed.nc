; spindle_off_feed 3
G0 X1
G1 X2 F100
X3
M30
