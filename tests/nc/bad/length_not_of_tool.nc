; length_not_of_tool 4
T1 M6
G43 H1
G43 H2
G49
M30
