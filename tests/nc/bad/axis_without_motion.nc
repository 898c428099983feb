; axis_without_motion 2
X1
