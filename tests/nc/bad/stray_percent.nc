; stray_percent 2
%
G0 X1
