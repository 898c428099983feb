; g53_incremental 3
G91
G53 G0 Z0
