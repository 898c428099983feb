; unknown_g 2
G51 X0 Y0 P500
