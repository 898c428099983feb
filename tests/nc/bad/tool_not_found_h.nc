; tool_not_found 2
G43 H9
