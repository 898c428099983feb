; g28_without_axes 2
G28
M30
