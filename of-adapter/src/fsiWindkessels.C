/*---------------------------------------------------------------------------*\
    fsi-driver: adapter for OpenFOAM
\*---------------------------------------------------------------------------*/

#include "fsiWindkessels.H"
#include "fsiConductance.H"
#include "fvMatrices.H"
#include "pointIOField.H"
#include "windkesselPressureFvPatchScalarField.H"

namespace
{
    using namespace Foam;

    //- Sums over the ranks, the same on all
    void sumUp(scalarList& values)
    {
        for (scalar& value : values)
        {
            reduce(value, sumOp<scalar>());
        }
    }

    const windkesselPressureFvPatchScalarField& windkessel
    (
        const volScalarField& p,
        const label patchi
    )
    {
        return refCast<const windkesselPressureFvPatchScalarField>
        (
            p.boundaryField()[patchi]
        );
    }

    //- Of the faces of the mesh before it moved
    scalarField reference(const fvMesh& mesh)
    {
        const pointIOField points
        (
            IOobject
            (
                "points",
                mesh.time().constant(),
                polyMesh::meshSubDir,
                mesh,
                IOobject::MUST_READ,
                IOobject::NO_WRITE,
                false
            )
        );
        return fsi::conductance(mesh, points, fsi::cellCentres(mesh, points));
    }
}


namespace Foam
{
namespace fsi
{
    defineTypeNameAndDebug(windkessels, 0);
}
}


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

Foam::scalarList Foam::fsi::windkessels::response
(
    const volScalarField& p,
    const scalarField& conductance,
    const label patchi
) const
{
    wordList types(p.boundaryField().size(), "zeroGradient");
    forAll(types, i)
    {
        if (p.boundaryField()[i].fixesValue())
        {
            types[i] = "fixedValue";
        }
    }
    volScalarField unit
    (
        IOobject
        (
            "fsiAdmittance",
            mesh_.time().timeName(),
            mesh_,
            IOobject::NO_READ,
            IOobject::NO_WRITE,
            false
        ),
        mesh_,
        dimensionedScalar(dimless, Zero),
        types
    );
    unit.boundaryFieldRef()[patchi] == 1;

    fvScalarMatrix equation(unit, dimLength);
    equation.upper() = SubField<scalar>(conductance, mesh_.nInternalFaces());
    equation.negSumDiag();
    forAll(unit.boundaryField(), i)
    {
        const fvPatchScalarField& values = unit.boundaryField()[i];
        const polyPatch& pp = mesh_.boundaryMesh()[i];
        if (values.coupled() || values.fixesValue())
        {
            const SubField<scalar> own(conductance, pp.size(), pp.start());
            equation.internalCoeffs()[i] = -own;
            equation.boundaryCoeffs()[i] = values.coupled() ? -own : -own*values;
        }
        else
        {
            equation.internalCoeffs()[i] = Zero;
            equation.boundaryCoeffs()[i] = Zero;
        }
    }
    dictionary solver;
    solver.add("solver", "PCG");
    solver.add("preconditioner", "DIC");
    solver.add("tolerance", 1e-6);
    solver.add("relTol", 0);
    equation.solve(solver);

    scalarList inward(patches_.size(), Zero);
    forAll(patches_, j)
    {
        const polyPatch& pp = mesh_.boundaryMesh()[patches_[j]];
        const fvPatchScalarField& values = unit.boundaryField()[patches_[j]];
        const scalarField inside(values.patchInternalField());
        forAll(pp, facei)
        {
            inward[j] +=
                conductance[pp.start() + facei]*(values[facei] - inside[facei]);
        }
    }
    sumUp(inward);
    return inward;
}


void Foam::fsi::windkessels::update(const volScalarField& p)
{
    const label count = patches_.size();
    scalarList flows(count);
    forAll(patches_, i)
    {
        flows[i] = windkessel(p, patches_[i]).localFlow();
    }
    sumUp(flows);
    const Time& time = mesh_.time();
    if (time_ == time.value() && flows == flows_)
    {
        // The pressure is solved for again without a new flux, or another
        // patch has asked before
        return;
    }
    time_ = time.value();
    flows_ = flows;

    // Uniform on each patch, of which a rank may have no face
    scalarList now(count, Zero);
    scalarList ranks(count, Zero);
    forAll(patches_, i)
    {
        const fvPatchScalarField& values = p.boundaryField()[patches_[i]];
        if (values.size())
        {
            now[i] = values[0];
            ranks[i] = 1;
        }
    }
    sumUp(now);
    sumUp(ranks);

    scalarSquareMatrix system(count, Zero);
    scalarList off(count);
    forAll(patches_, i)
    {
        const auto& patch = windkessel(p, patches_[i]);
        now[i] /= max(ranks[i], scalar(1));
        off[i] = patch.target(flows[i]) - now[i];
        const scalar slope = patch.target(1) - patch.target(0);
        forAll(patches_, j)
        {
            system(i, j) = slope*time.deltaTValue()*admittance_(i, j);
        }
        system(i, i) += 1;
    }
    LUsolve(system, off);
    forAll(patches_, i)
    {
        pressures_[i] = now[i] + off[i];
    }
}


Foam::fsi::windkessels::windkessels
(
    const volScalarField& p,
    const labelList& patches
)
:
    regIOobject
    (
        IOobject
        (
            typeName,
            p.mesh().time().constant(),
            p.mesh(),
            IOobject::NO_READ,
            IOobject::NO_WRITE
        )
    ),
    mesh_(p.mesh()),
    patches_(patches),
    admittance_(patches.size(), Zero),
    flows_(patches.size(), Zero),
    pressures_(patches.size(), Zero)
{
    const scalarField conductance(reference(mesh_));
    forAll(patches_, j)
    {
        const scalarList inward(response(p, conductance, patches_[j]));
        forAll(patches_, i)
        {
            admittance_(i, j) = inward[i];
        }
    }
}


// * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * * //

Foam::scalar Foam::fsi::windkessels::pressure
(
    windkesselPressureFvPatchScalarField& patch
)
{
    const fvMesh& mesh = patch.internalField().mesh();
    const auto* p = mesh.findObject<volScalarField>(patch.internalField().name());
    const label own = patch.patch().index();
    // A copy of the field is none of the mesh's
    const bool isField = p && &p->boundaryField()[own] == &patch;

    DynamicList<label> patches;
    bool others = false;
    if (isField)
    {
        forAll(p->boundaryField(), i)
        {
            const fvPatchScalarField& values = p->boundaryField()[i];
            if (isA<windkesselPressureFvPatchScalarField>(values))
            {
                patches.append(i);
            }
            else if (!values.coupled() && values.fixesValue())
            {
                others = true;
            }
        }
    }
    if (!isField || (patches.size() == 1 && !others))
    {
        patch.begin();
        return patch.target(returnReduce(patch.localFlow(), sumOp<scalar>()));
    }

    for (const label i : patches)
    {
        const_cast<windkesselPressureFvPatchScalarField&>
        (
            windkessel(*p, i)
        ).begin();
    }
    if (!mesh.foundObject<windkessels>(typeName))
    {
        regIOobject::store(new windkessels(*p, patches));
    }
    auto& all = mesh.lookupObjectRef<windkessels>(typeName);
    all.update(*p);
    return all.pressures_[all.patches_.find(own)];
}


// ************************************************************************* //
