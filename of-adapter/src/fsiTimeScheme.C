/*---------------------------------------------------------------------------*\
    fsi-driver: adapter for OpenFOAM
\*---------------------------------------------------------------------------*/

#include "fsiTimeScheme.H"
#include "fsiCompatibility.H"

namespace
{
    //- Those of a kind whose derivative in time was taken: that asks for two
    //  earlier times
    template<class Field>
    void writeOld(const Foam::fvMesh& mesh)
    {
        for (const Foam::word& name : mesh.sortedNames<Field>())
        {
            Field& field = mesh.lookupObjectRef<Field>(name);
            if
            (
                field.nOldTimes() > 1
             && field.writeOpt() == Foam::IOobject::AUTO_WRITE
             && !name.ends_with("_0")
            )
            {
                Foam::fsi::writeAlways(field.oldTime(), 0);
            }
        }
    }
}

bool Foam::fsi::isBackward(const fvMesh& mesh)
{
    return word(mesh.ddtScheme("ddt(U)")) == "backward";
}


void Foam::fsi::writeFirstOldFields(const fvMesh& mesh)
{
    if (isBackward(mesh))
    {
        writeOld<volScalarField>(mesh);
        writeOld<volVectorField>(mesh);
        writeOld<volSymmTensorField>(mesh);
        writeOld<surfaceVectorField>(mesh);
    }
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
