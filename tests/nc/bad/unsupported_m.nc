; unsupported_m 2
M98 P5
