; call_too_deep 4
M98 P1
M30
O1 M98 P1
M99
