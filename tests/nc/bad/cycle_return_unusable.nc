; cycle_return_unusable 3
F100 S1 M3
G99 G87 X1 Z-1 R-5 Q1
