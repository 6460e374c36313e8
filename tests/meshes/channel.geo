// A polygon with a corner that comes in, left of the origin and wider than high.
Point(1) = {-1.5, -0.5, 0, 0.12};
Point(2) = {0.5, -0.5, 0, 0.12};
Point(3) = {0.5, 0.5, 0, 0.12};
Point(4) = {-0.5, 0.5, 0, 0.12};
Point(5) = {-0.7, 0.25, 0, 0.12};
Point(6) = {-1.5, 0.25, 0, 0.12};
// A point of the geometry that no triangle uses.
Point(9) = {2, 2, 0, 0.1};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 5};
Line(5) = {5, 6};
Line(6) = {6, 1};
Curve Loop(1) = {1, 2, 3, 4, 5, 6};
Plane Surface(1) = {1};
