/*---------------------------------------------------------------------------*\
    fsi-driver: adapter for OpenFOAM
\*---------------------------------------------------------------------------*/

#include "fsiMeasure.H"
#include "turbulentTransportModel.H"
#include "windkesselPressureFvPatchScalarField.H"
#include "surfaceFields.H"
#include "volFields.H"

Foam::vectorField Foam::fsi::wallTraction
(
    const fvMesh& mesh,
    const label patch,
    const scalar rho
)
{
    const auto& p = mesh.lookupObject<volScalarField>("p");
    const auto& model = mesh.lookupObject<incompressible::turbulenceModel>
    (
        turbulenceModel::propertiesName
    );
    const vectorField n(mesh.boundary()[patch].nf());

    // devReff() is -nu dev(twoSymm(grad U)), the kinematic stress with the
    // sign of a load
    const tmp<volSymmTensorField> tstress(model.devReff());
    const symmTensorField& stress = tstress().boundaryField()[patch];

    return rho*(p.boundaryField()[patch]*n + (n & stress));
}


namespace
{

using namespace Foam;

//- Largest difference between the fluid's velocity at the wall and the
//  velocity of the wall's faces. Along the normal the latter is the swept
//  volume per area and time, as the conservation of space demands; along the
//  tangent it is that of the face centre.
scalar wallVelocityMismatch(const fvMesh& mesh, const label patch)
{
    if (!mesh.moving())
    {
        return 0;
    }
    const auto& U = mesh.lookupObject<volVectorField>("U");
    const fvPatch& p = mesh.boundary()[patch];
    const vectorField n(p.nf());

    vectorField wall(p.Cf());
    forAll(wall, i)
    {
        wall[i] -= p.patch()[i].centre(mesh.oldPoints());
    }
    wall /= mesh.time().deltaTValue();
    const scalarField swept(mesh.phi().boundaryField()[patch]/p.magSf());
    wall += n*(swept - (n & wall));

    return gMax(mag(U.boundaryField()[patch] - wall));
}

} // End anonymous namespace


Foam::fsi::stepReport Foam::fsi::measure
(
    const fvMesh& mesh,
    const label wall,
    const label inlet,
    const label outlet,
    const scalar rho
)
{
    const auto& p = mesh.lookupObject<volScalarField>("p");
    const auto& phi = mesh.lookupObject<surfaceScalarField>("phi");

    const auto meanPressure = [&](const label patch)
    {
        const scalarField& area = mesh.boundary()[patch].magSf();
        return rho*gSum(p.boundaryField()[patch]*area)/gSum(area);
    };

    stepReport step;
    step.time = mesh.time().value();
    // Inlet and outlet do not move, so the relative flux is the flow
    step.inflow = -gSum(phi.boundaryField()[inlet]);
    step.outflow = gSum(phi.boundaryField()[outlet]);
    step.inletPressure = meanPressure(inlet);
    step.outletPressure = meanPressure(outlet);
    step.windkesselPressure = step.outletPressure;
    if (isA<windkesselPressureFvPatchScalarField>(p.boundaryField()[outlet]))
    {
        step.windkesselPressure =
            refCast<const windkesselPressureFvPatchScalarField>
            (
                p.boundaryField()[outlet]
            ).pressure();
    }
    step.volume = gSum(mesh.V());
    step.wallVelocityMismatch = wallVelocityMismatch(mesh, wall);
    step.tractions = wallTraction(mesh, wall, rho);
    return step;
}


// ************************************************************************* //
