; tool_not_found 2 linuxcnc
M61 Q9
