/*---------------------------------------------------------------------------*\
    fsi-driver: adapter for OpenFOAM
\*---------------------------------------------------------------------------*/

#include "fsiMeasure.H"
#include "fsiWallVelocityFvPatchVectorField.H"
#include "fvcMeshPhi.H"
#include "turbulentTransportModel.H"
#include "windkesselPressureFvPatchScalarField.H"
#include "surfaceFields.H"
#include "volFields.H"

namespace
{

using namespace Foam;

//- Gradient of U, d_i U_j, in the cells at a patch: what the scheme
//  "Gauss linear" gives, without its cost in all the other cells
tensorField gradientInCells(const volVectorField& U, const label patch)
{
    const fvMesh& mesh = U.mesh();
    const labelUList& owner = mesh.owner();
    const labelUList& neighbour = mesh.neighbour();
    const labelList& patchOf = mesh.boundaryMesh().patchID();

    // Beyond coupled patches lie cells of other ranks
    List<vectorField> beyond(mesh.boundary().size());
    forAll(beyond, patchi)
    {
        if (U.boundaryField()[patchi].coupled())
        {
            beyond[patchi] = U.boundaryField()[patchi].patchNeighbourField();
        }
    }

    const labelUList& cells = mesh.boundary()[patch].faceCells();
    tensorField gradient(cells.size(), Zero);
    forAll(cells, i)
    {
        const label celli = cells[i];
        for (const label facei : mesh.cells()[celli])
        {
            if (mesh.isInternalFace(facei))
            {
                const scalar w = mesh.weights()[facei];
                const vector Uf
                (
                    w*U[owner[facei]] + (1 - w)*U[neighbour[facei]]
                );
                const vector& Sf = mesh.Sf()[facei];
                gradient[i] += (owner[facei] == celli ? Sf : -Sf)*Uf;
                continue;
            }
            const label patchi = patchOf[facei - mesh.nInternalFaces()];
            const fvPatchVectorField& Up = U.boundaryField()[patchi];
            const label j = facei - mesh.boundaryMesh()[patchi].start();
            if (Up.coupled())
            {
                const scalar w = mesh.weights().boundaryField()[patchi][j];
                gradient[i] += mesh.Sf().boundaryField()[patchi][j]
                   *(w*U[celli] + (1 - w)*beyond[patchi][j]);
            }
            else if (j < Up.size()) // the patch of a 2D mesh holds no values
            {
                gradient[i] += mesh.Sf().boundaryField()[patchi][j]*Up[j];
            }
        }
        gradient[i] /= mesh.V()[celli];
    }
    return gradient;
}

} // End anonymous namespace


Foam::vectorField Foam::fsi::viscousTraction
(
    const fvMesh& mesh,
    const label patch,
    const scalar rho
)
{
    const auto& U = mesh.lookupObject<volVectorField>("U");
    const auto& model = mesh.lookupObject<incompressible::turbulenceModel>
    (
        turbulenceModel::propertiesName
    );
    const vectorField n(mesh.boundary()[patch].nf());

    // On the face, the normal derivative is known better than from the cell
    tensorField gradient(gradientInCells(U, patch));
    gradient += n*(U.boundaryField()[patch].snGrad() - (n & gradient));
    const symmTensorField stress(model.nuEff(patch)*dev(twoSymm(gradient)));

    return -rho*(n & stress);
}


Foam::vectorField Foam::fsi::pressureTraction
(
    const fvMesh& mesh,
    const label patch,
    const scalar rho
)
{
    const auto& p = mesh.lookupObject<volScalarField>("p");
    return rho*p.boundaryField()[patch]*mesh.boundary()[patch].nf();
}


Foam::vectorField Foam::fsi::wallTraction
(
    const fvMesh& mesh,
    const labelList& patches,
    const scalar rho
)
{
    DynamicList<vector> tractions;
    for (const label patch : patches)
    {
        tractions.append
        (
            vectorField
            (
                pressureTraction(mesh, patch, rho)
              + viscousTraction(mesh, patch, rho)
            )
        );
    }
    return vectorField(tractions);
}


namespace
{

using namespace Foam;

//- Largest difference between the fluid's velocity at the wall and the
//  velocity of the wall's faces. Along the normal the latter is the swept
//  volume per area and time, as the conservation of space demands by the scheme
//  of the time derivatives; along the tangent it is that of the face centre.
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
    const auto* own = dynamic_cast<const fsiWallVelocityFvPatchVectorField*>
    (
        &U.boundaryField()[patch]
    );
    if (own)
    {
        wall = own->faceVelocity();
    }
    const tmp<surfaceScalarField> flux(fvc::meshPhi(U));
    const scalarField swept(flux().boundaryField()[patch]/p.magSf());
    wall += n*(swept - (n & wall));

    return gMax(mag(U.boundaryField()[patch] - wall));
}

} // End anonymous namespace


const Foam::windkesselPressureFvPatchScalarField* Foam::fsi::modelBehind
(
    const fvMesh& mesh,
    const label patch
)
{
    const auto& p = mesh.lookupObject<volScalarField>("p");
    return
        dynamic_cast<const windkesselPressureFvPatchScalarField*>
        (
            &p.boundaryField()[patch]
        );
}


Foam::fsi::stepReport Foam::fsi::measure
(
    const fvMesh& mesh,
    const labelList& wall,
    const labelList& openings,
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
    step.openings.resize(openings.size());
    forAll(openings, i)
    {
        const label patch = openings[i];
        const auto* model = modelBehind(mesh, patch);
        // Openings do not move, so the relative flux is the flow
        step.openings[i].flow = -gSum(phi.boundaryField()[patch]);
        step.openings[i].meanPressure = meanPressure(patch);
        step.openings[i].modelPressure = model ? model->pressure() : 0;
    }
    step.volume = gSum(mesh.V());
    step.wallVelocityMismatch = 0;
    DynamicList<vector> viscous;
    for (const label patch : wall)
    {
        step.wallVelocityMismatch =
            max(step.wallVelocityMismatch, wallVelocityMismatch(mesh, patch));
        viscous.append(viscousTraction(mesh, patch, rho));
    }
    step.viscousTractions = vectorField(viscous);
    return step;
}


// ************************************************************************* //
