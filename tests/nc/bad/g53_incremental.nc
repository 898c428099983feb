; g53_incremental 3 linuxcnc
G91
G53 G0 Z0
