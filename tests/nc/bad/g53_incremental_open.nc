; g53_incremental_open 2 haas
G91 G53 G0 Z0
