; block_structure 3
G0 X1
END1
