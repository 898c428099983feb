; block_structure 4
M98 P1
M30
O1
