; subprogram_not_found 2
M98
