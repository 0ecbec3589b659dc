"""What an isosurface is found from: a row of numbers for each blob, an ellipsoid as the camera sees it.

A blob's density is (1 − q)⁸, where q grows from 0 in its middle to 1 at the end of its reach:

    q = MXX x² + MXY x y + MYY y² + C (z − HX x − HY y)²

with x to the right and y down from its middle, pixels, and z away from the camera, m.
"""

X, Y, DEPTH, EX, EY, EZ, MXX, MXY, MYY, C, HX, HY, SHARE, RED, GREEN, BLUE = range(16)
"""Middle, pixels and m; how far it reaches along x, y and z; its shape, see above; how much of it there is, less than 1
where it is smaller than can be drawn; tint."""

NUMBERS = 16

POWER = 8
"""Of the density."""
