; fanuc: reference returns, inches, rotary feed, G53, dwell; computed by hand
G20 G90 G17
T2 M6
G43 H2
G0 X1 Y1 Z1
G1 Z0.5 F10 S1000 M3
G1 A90 F360
G91 G28 Z0
G28 X0.1 Y0
G90 G21 G53 G0 X3 Z-4
G4 P500
G4 X1.5
G30 Z0
M30
