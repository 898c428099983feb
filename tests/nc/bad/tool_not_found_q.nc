; tool_not_found 2
M61 Q9
