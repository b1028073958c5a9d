/*---------------------------------------------------------------------------*\
    fsi-driver: adapter for OpenFOAM
\*---------------------------------------------------------------------------*/

#include "fsiTimeScheme.H"

bool Foam::fsi::isBackward(const fvMesh& mesh)
{
    return word(mesh.ddtScheme("ddt(U)")) == "backward";
}


Foam::fsi::backwardDifference::backwardDifference
(
    const scalar dt,
    const scalar dt0
)
:
    next((1 + 2*dt/dt0)/(1 + dt/dt0)/dt),
    last(-(1 + dt/dt0)/dt),
    before(sqr(dt/dt0)/(1 + dt/dt0)/dt)
{}


// ************************************************************************* //
