/*---------------------------------------------------------------------------*\
    fsi-driver: adapter for OpenFOAM
\*---------------------------------------------------------------------------*/

#include "referenceLaplacianMotionSolver.H"
#include "fsiCompatibility.H"
#include "fsiConductance.H"
#include "addToRunTimeSelectionTable.H"
#include "fixedValueFvPatchFields.H"
#include "fvMatrices.H"
#include "ListListOps.H"
#include "syncTools.H"
#include "valuePointPatchField.H"
#include "wordRes.H"

namespace Foam
{
    defineTypeNameAndDebug(referenceLaplacianMotionSolver, 0);
    addToRunTimeSelectionTable
    (
        motionSolver,
        referenceLaplacianMotionSolver,
        dictionary
    );
}


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

void Foam::referenceLaplacianMotionSolver::applyDiffusivity
(
    const dictionary& dict
)
{
    const wordRes names(dict.get<wordRes>("patches"));
    const scalar length = dict.getCheck<scalar>("length", scalarMinMax::ge(VSMALL));
    const scalar exponent = dict.get<scalar>("exponent");
    const polyBoundaryMesh& patches = fvMesh_.boundaryMesh();
    const labelHashSet chosen(patches.patchSet(names, true));

    // Faces of the patches on all ranks
    List<pointField> gathered(Pstream::nProcs());
    DynamicList<point> here;
    for (const label patchi : chosen)
    {
        for (const face& f : patches[patchi])
        {
            here.append(f.centre(points0()));
        }
    }
    gathered[Pstream::myProcNo()] = here;
    Pstream::gatherList(gathered);
    fsi::share(gathered);
    const pointField from
    (
        ListListOps::combine<pointField>(gathered, accessOp<pointField>())
    );
    if (from.empty())
    {
        FatalIOErrorInFunction(dict)
            << "no face on the patches " << names << "; the mesh has "
            << patches.names() << exit(FatalIOError);
    }

    const faceList& faces = fvMesh_.faces();
    forAll(faces, facei)
    {
        const point centre(faces[facei].centre(points0()));
        scalar nearest = GREAT;
        for (const point& other : from)
        {
            nearest = min(nearest, magSqr(centre - other));
        }
        conductance_[facei] *= pow(1 + sqrt(nearest)/length, -exponent);
    }
}


void Foam::referenceLaplacianMotionSolver::setPointWeights
(
    const vectorField& centres
)
{
    const labelListList& pointCells = fvMesh_.pointCells();
    pointWeights_.resize(pointCells.size());
    scalarField sum(pointCells.size(), Zero);
    forAll(pointCells, pointi)
    {
        scalarList& weights = pointWeights_[pointi];
        weights.resize(pointCells[pointi].size());
        forAll(weights, i)
        {
            weights[i] = 1/mag(points0()[pointi] - centres[pointCells[pointi][i]]);
            sum[pointi] += weights[i];
        }
    }
    syncTools::syncPointList(fvMesh_, sum, plusEqOp<scalar>(), scalar(0));
    forAll(pointWeights_, pointi)
    {
        for (scalar& weight : pointWeights_[pointi])
        {
            weight /= sum[pointi];
        }
    }
}


void Foam::referenceLaplacianMotionSolver::findPrescribed()
{
    prescribedHere_.resize(fvMesh_.nPoints(), false);
    forAll(pointDisplacement_.boundaryField(), patchi)
    {
        const auto& patch = pointDisplacement_.boundaryField()[patchi];
        if (isA<valuePointPatchField<vector>>(patch))
        {
            for (const label pointi : patch.patch().meshPoints())
            {
                prescribedHere_[pointi] = true;
            }
        }
    }
    prescribed_ = prescribedHere_;
    syncTools::syncPointList(fvMesh_, prescribed_, orEqOp<bool>(), false);
}


bool Foam::referenceLaplacianMotionSolver::isFree(const label patchi) const
{
    return
       !cellDisplacement_.boundaryField()[patchi].coupled()
    && !isA<valuePointPatchField<vector>>
        (
            pointDisplacement_.boundaryField()[patchi]
        );
}


void Foam::referenceLaplacianMotionSolver::interpolate() const
{
    const labelListList& pointCells = fvMesh_.pointCells();
    vectorField& displacement = pointDisplacement_.primitiveFieldRef();
    forAll(pointCells, pointi)
    {
        vector sum(Zero);
        forAll(pointCells[pointi], i)
        {
            sum += pointWeights_[pointi][i]*cellDisplacement_[pointCells[pointi][i]];
        }
        displacement[pointi] = sum;
    }
    syncTools::syncPointList
    (
        fvMesh_,
        displacement,
        plusEqOp<vector>(),
        vector::zero
    );
    pointDisplacement_.correctBoundaryConditions();

    if (Pstream::parRun())
    {
        // A rank may touch the patch of another one in a point only
        vectorField elsewhere(displacement.size(), Zero);
        forAll(elsewhere, pointi)
        {
            if (prescribedHere_[pointi])
            {
                elsewhere[pointi] = displacement[pointi];
            }
        }
        syncTools::syncPointList
        (
            fvMesh_,
            elsewhere,
            maxMagSqrEqOp<vector>(),
            vector::zero
        );
        forAll(elsewhere, pointi)
        {
            if (prescribed_[pointi] && !prescribedHere_[pointi])
            {
                displacement[pointi] = elsewhere[pointi];
            }
        }
    }
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

Foam::referenceLaplacianMotionSolver::referenceLaplacianMotionSolver
(
    const polyMesh& mesh,
    const IOdictionary& dict
)
:
    displacementMotionSolver(mesh, dict, typeName),
    fvMesh_(refCast<const fvMesh>(mesh)),
    cellDisplacement_
    (
        IOobject
        (
            "cellDisplacement",
            mesh.time().timeName(),
            mesh,
            IOobject::READ_IF_PRESENT,
            IOobject::AUTO_WRITE
        ),
        fvMesh_,
        dimensionedVector(dimLength, Zero),
        fixedValueFvPatchVectorField::typeName
    )
{
    const vectorField centres(fsi::cellCentres(fvMesh_, points0()));
    conductance_ = fsi::conductance(fvMesh_, points0(), centres);
    if (coeffDict().found("diffusivity"))
    {
        applyDiffusivity(coeffDict().subDict("diffusivity"));
    }
    setPointWeights(centres);
    findPrescribed();
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

Foam::tmp<Foam::pointField>
Foam::referenceLaplacianMotionSolver::curPoints() const
{
    interpolate();
    return points0() + pointDisplacement_.primitiveField();
}


void Foam::referenceLaplacianMotionSolver::solve()
{
    pointDisplacement_.boundaryFieldRef().updateCoeffs();

    fvVectorMatrix equation(cellDisplacement_, dimVolume/dimLength);
    equation.upper() =
        SubField<scalar>(conductance_, fvMesh_.nInternalFaces());
    equation.negSumDiag();

    forAll(cellDisplacement_.boundaryField(), patchi)
    {
        fvPatchVectorField& values =
            cellDisplacement_.boundaryFieldRef()[patchi];
        const polyPatch& pp = fvMesh_.boundaryMesh()[patchi];
        if (values.empty())
        {
            // Of the plane of a problem in two dimensions
            continue;
        }
        const SubField<scalar> conductance(conductance_, pp.size(), pp.start());
        if (isFree(patchi))
        {
            // Its points go where the cells behind them go
            equation.internalCoeffs()[patchi] = Zero;
            equation.boundaryCoeffs()[patchi] = Zero;
            continue;
        }
        if (!values.coupled())
        {
            vectorField prescribed(pp.size());
            forAll(pp, i)
            {
                prescribed[i] =
                    pp[i].average(points0(), pointDisplacement_.primitiveField());
            }
            values == prescribed;
        }
        equation.internalCoeffs()[patchi] = -conductance*vector::one;
        equation.boundaryCoeffs()[patchi] =
            values.coupled() ? -conductance*vector::one : -conductance*values;
    }
    equation.solve();
    forAll(cellDisplacement_.boundaryField(), patchi)
    {
        fvPatchVectorField& values =
            cellDisplacement_.boundaryFieldRef()[patchi];
        if (!values.empty() && isFree(patchi))
        {
            values == values.patchInternalField();
        }
    }
}


// ************************************************************************* //
