; start_motion_open 2
X1
Z2
M30
