; rotation_without_angle 2
G68 X1 Y1
