; tool_change_without_t 2
M6
M30
