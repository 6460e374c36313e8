// The unit square, finer about its centre.
SetFactory("Built-in");
Point(1) = {0, 0, 0, 0.12};
Point(2) = {1, 0, 0, 0.12};
Point(3) = {1, 1, 0, 0.12};
Point(4) = {0, 1, 0, 0.12};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Field[1] = MathEval;
Field[1].F = "0.05 + 0.12*Sqrt((x-0.5)*(x-0.5)+(y-0.5)*(y-0.5))";
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Physical Surface("inside", 7) = {1};
