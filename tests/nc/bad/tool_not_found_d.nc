; tool_not_found 2
G41 D9
