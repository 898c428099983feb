; block_structure 3
G0 X1
WHILE [1 EQ 0] DO1
M30
