; tool_not_found 2
T9
