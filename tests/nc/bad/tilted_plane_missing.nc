; tilted_plane_missing 2
G53.1
