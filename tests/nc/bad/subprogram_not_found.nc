; subprogram_not_found 2
M98 P77
