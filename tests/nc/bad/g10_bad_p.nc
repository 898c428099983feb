; g10_bad_p 2 linuxcnc
G10 L2 P99 X1
