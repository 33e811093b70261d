# SPDX-License-Identifier: Apache-2.0
# A table of patterns of one's own: the centre joined to all points of the edges.
function triangle(a, b, c) { print "triangle", a, b, c }
BEGIN {
    for (x = 1; x <= 11; x++) for (y = 1; y <= x; y++) for (z = 1; z <= y; z++) {
        print "pattern", x, y, z
        count = 0
        boundary[count++] = 0
        for (i = 0; i < x - 1; i++) boundary[count++] = 3 + i
        boundary[count++] = 1
        for (i = 0; i < y - 1; i++) boundary[count++] = 2 + x + i
        boundary[count++] = 2
        for (i = 0; i < z - 1; i++) boundary[count++] = 1 + x + y + i
        if (x > 2) { # few segments have no room for a point inside
            print "point 10922 10923 10923"
            for (i = 0; i < count; i++) triangle(count, boundary[i], boundary[(i + 1) % count])
        } else if (z == 2) {
            triangle(0, 3, 5); triangle(3, 1, 4); triangle(5, 4, 2); triangle(3, 4, 5)
        } else if (y == 2) {
            triangle(0, 3, 2); triangle(3, 4, 2); triangle(3, 1, 4)
        } else if (x == 2) {
            triangle(0, 3, 2); triangle(3, 1, 2)
        } else {
            triangle(0, 1, 2)
        }
    }
}
