; exact_path_assumed 4
G64 P0.01
G61
G64
M30
