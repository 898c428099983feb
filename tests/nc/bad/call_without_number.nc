; call_without_number 2
M98
