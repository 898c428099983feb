; exact_path_assumed 2
G64 P0.01
G61
G64
M30
