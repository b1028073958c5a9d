/*---------------------------------------------------------------------------*\
    fsi-driver: adapter for OpenFOAM
\*---------------------------------------------------------------------------*/

#include "blendedMotionSolver.H"
#include "fsiCompatibility.H"
#include "fsiWallInterface.H"
#include "addToRunTimeSelectionTable.H"
#include "IFstream.H"
#include "Map.H"
#include "Tuple2.H"

namespace Foam
{
    defineTypeNameAndDebug(blendedMotionSolver, 0);
    addToRunTimeSelectionTable
    (
        motionSolver,
        blendedMotionSolver,
        dictionary
    );
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

Foam::blendedMotionSolver::blendedMotionSolver
(
    const polyMesh& mesh,
    const IOdictionary& dict
)
:
    displacementMotionSolver(mesh, dict, typeName),
    nPlaces_(0)
{
    labelListList rings;
    List<Tuple2<labelList, scalarList>> points;
    if (Pstream::master())
    {
        IFstream file(mesh.time().globalPath()/"constant"/"fsiMotionBlend");
        if (!file.good())
        {
            FatalIOErrorInFunction(file)
                << "cannot be read; motionSolver referenceLaplacian needs no"
                << " such file" << exit(FatalIOError);
        }
        file >> rings >> points;
    }
    fsi::share(rings);
    fsi::share(points);

    const labelList global(fsi::undecomposedPoints(mesh));
    if (!Pstream::parRun() && points.size() != global.size())
    {
        FatalErrorInFunction
            << "constant/fsiMotionBlend is for a mesh of " << points.size()
            << " points; this one has " << global.size() << exit(FatalError);
    }

    Map<label> placeOf;
    rings_.resize(rings.size());
    forAll(rings, ringi)
    {
        rings_[ringi].resize(rings[ringi].size());
        forAll(rings[ringi], i)
        {
            placeOf.insert(rings[ringi][i], nPlaces_);
            rings_[ringi][i] = nPlaces_++;
        }
    }

    DynamicList<label> wallPoints, wallPlaces;
    ringOf_.resize(global.size());
    placesOf_.resize(global.size());
    sharesOf_.resize(global.size());
    forAll(global, pointi)
    {
        const auto& followed = points[global[pointi]];
        ringOf_[pointi] = followed.first()[0];
        sharesOf_[pointi] = followed.second();
        placesOf_[pointi].resize(sharesOf_[pointi].size());
        forAll(placesOf_[pointi], i)
        {
            placesOf_[pointi][i] = placeOf[followed.first()[i + 1]];
        }
        const auto place = placeOf.cfind(global[pointi]);
        if (place.found())
        {
            wallPoints.append(pointi);
            wallPlaces.append(place.val());
        }
    }
    wallPoints_ = labelList(wallPoints);
    wallPlaces_ = labelList(wallPlaces);
}


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

Foam::vectorField Foam::blendedMotionSolver::ofWall() const
{
    vectorField displacement(nPlaces_, Zero);
    UIndirectList<vector>(displacement, wallPlaces_) =
        UIndirectList<vector>(pointDisplacement_.primitiveField(), wallPoints_);

    // A rank that touches the wall in a point only does not know its value
    Pstream::listCombineGather(displacement, maxMagSqrEqOp<vector>());
    fsi::share(displacement);
    return displacement;
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

Foam::tmp<Foam::pointField> Foam::blendedMotionSolver::curPoints() const
{
    return points0() + pointDisplacement_.primitiveField();
}


void Foam::blendedMotionSolver::solve()
{
    pointDisplacement_.boundaryFieldRef().updateCoeffs();

    const vectorField onWall(ofWall());
    vectorField means(rings_.size());
    forAll(rings_, ringi)
    {
        means[ringi] = average(vectorField(onWall, rings_[ringi]));
    }

    vectorField& displacement = pointDisplacement_.primitiveFieldRef();
    forAll(displacement, pointi)
    {
        const vector& mean = means[ringOf_[pointi]];
        vector sum(mean);
        forAll(placesOf_[pointi], i)
        {
            sum += sharesOf_[pointi][i]*(onWall[placesOf_[pointi][i]] - mean);
        }
        displacement[pointi] = sum;
    }
    pointDisplacement_.correctBoundaryConditions();
}


// ************************************************************************* //
