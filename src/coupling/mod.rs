//! The coupling loop of equation (13): transfer, solve, accelerate until converged.
