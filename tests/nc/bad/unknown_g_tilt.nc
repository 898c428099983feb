; unknown_g 3
G68.2 X0 Y0 Z0 I0 J30 K0
G53.1
