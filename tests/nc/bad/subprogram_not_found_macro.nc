; subprogram_not_found 2
G65 P9010 A1
