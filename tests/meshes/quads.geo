Merge "square.geo";
Mesh.RecombineAll = 1;
