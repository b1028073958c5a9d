// A flap 0.1 m thick and 1 m high on the bottom of a channel, 0.1 m deep: hexahedra of the second order.
//   gmsh -3 -order 2 -format msh41 -o flap.msh flap.geo
Point(1) = {-0.05, 0, 0};
Point(2) = { 0.05, 0, 0};
Point(3) = { 0.05, 1, 0};
Point(4) = {-0.05, 1, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Transfinite Curve {1, 3} = 2;  // one element through the flap
Transfinite Curve {2, -4} = 9 Using Progression 1.15; // eight along it, finer where it is held
Transfinite Surface {1};
Recombine Surface {1};
side[] = Extrude {0, 0, 0.1} { Surface{1}; Layers{1}; Recombine; };
// side: top of the sweep, volume, then what the curves 1 to 4 have swept
Physical Volume("flap") = {side[1]};
Physical Surface("bottom") = {side[2]};
Physical Surface("wet") = {side[3], side[4], side[5]};
Physical Surface("sides") = {1, side[0]};
