/*---------------------------------------------------------------------------*\
    fsi-driver: adapter for OpenFOAM
\*---------------------------------------------------------------------------*/

#include "fsiWallInterface.H"
#include "fsiCompatibility.H"
#include "labelIOList.H"
#include "Map.H"
#include "SubField.H"

namespace
{

using namespace Foam;

//- Labels in the undecomposed mesh, as decomposePar recorded them
labelList addressing(const polyMesh& mesh, const word& name)
{
    return labelIOList
    (
        IOobject
        (
            name,
            mesh.facesInstance(),
            polyMesh::meshSubDir,
            mesh,
            IOobject::MUST_READ,
            IOobject::NO_WRITE,
            false
        )
    );
}

} // End anonymous namespace


Foam::labelList Foam::fsi::undecomposedPoints(const polyMesh& mesh)
{
    return
        Pstream::parRun() ? addressing(mesh, "pointProcAddressing")
      : identity(mesh.nPoints());
}


Foam::fsi::wallInterface::wallInterface
(
    const polyMesh& mesh,
    const wordList& patchNames,
    const pointField& referencePoints
)
:
    patches_(patchNames.size()),
    nPoints_(0)
{
    forAll(patchNames, i)
    {
        patches_[i] = mesh.boundaryMesh().findPatchID(patchNames[i]);
        if (patches_[i] < 0)
        {
            FatalErrorInFunction
                << "The mesh has no patch '" << patchNames[i] << "'; it has "
                << mesh.boundaryMesh().names() << exit(FatalError);
        }
    }

    // This rank's faces patch after patch, with labels of its own points, each
    // of which counts once even where patches meet
    DynamicList<face> ownFaces;
    DynamicList<label> ownFaceLabels, ownPointLabels;
    Map<label> ownPoints;
    pointPlaces_.resize(patches_.size());
    forAll(patches_, i)
    {
        const polyPatch& pp = mesh.boundaryMesh()[patches_[i]];
        const labelList& labels = pp.meshPoints();
        pointPlaces_[i].resize(labels.size());
        forAll(labels, j)
        {
            if (ownPoints.insert(labels[j], ownPointLabels.size()))
            {
                ownPointLabels.append(labels[j]);
            }
            pointPlaces_[i][j] = ownPoints[labels[j]];
        }
        forAll(pp, j)
        {
            face f(pp[j]);
            for (label& vertex : f)
            {
                vertex = ownPoints[vertex];
            }
            ownFaces.append(f);
            ownFaceLabels.append(pp.start() + j);
        }
    }

    // Their labels in the undecomposed mesh
    const labelList ofPoint(undecomposedPoints(mesh));
    const labelList pointLabels(UIndirectList<label>(ofPoint, ownPointLabels));
    labelList faceLabels(ownFaceLabels);
    if (Pstream::parRun())
    {
        const labelList ofFace(addressing(mesh, "faceProcAddressing"));
        // Shifted by one there, so that the sign can tell turned faces;
        // faces of a wall are never turned.
        faceLabels = labelList(UIndirectList<label>(ofFace, faceLabels));
    }

    List<labelList> allPointLabels(Pstream::nProcs());
    List<labelList> allFaceLabels(Pstream::nProcs());
    List<pointField> allPoints(Pstream::nProcs());
    List<faceList> allFaces(Pstream::nProcs());
    const label me = Pstream::myProcNo();
    allPointLabels[me] = pointLabels;
    allFaceLabels[me] = faceLabels;
    allPoints[me] = pointField(UIndirectList<point>(referencePoints, ownPointLabels));
    allFaces[me] = faceList(ownFaces);
    Pstream::gatherList(allPointLabels);
    Pstream::gatherList(allFaceLabels);
    Pstream::gatherList(allPoints);
    Pstream::gatherList(allFaces);

    List<labelList> places(Pstream::nProcs());
    if (Pstream::master())
    {
        // Faces of all ranks by their label in the undecomposed mesh
        DynamicList<label> labels, rankOf, indexOf;
        forAll(allFaces, rank)
        {
            forAll(allFaces[rank], i)
            {
                labels.append(allFaceLabels[rank][i]);
                rankOf.append(rank);
                indexOf.append(i);
            }
        }
        labelList order;
        sortedOrder(labels, order);

        facePlaces_.resize(Pstream::nProcs());
        forAll(allFaces, rank)
        {
            facePlaces_[rank].resize(allFaces[rank].size());
        }

        Map<label> placeOf(2*labels.size());
        DynamicList<point> points;
        faces_.resize(order.size());
        faceCentres_.resize(order.size());
        forAll(order, place)
        {
            const label rank = rankOf[order[place]];
            const label i = indexOf[order[place]];
            facePlaces_[rank][i] = place;

            face f(allFaces[rank][i]);
            faceCentres_[place] = f.centre(allPoints[rank]);
            for (label& vertex : f)
            {
                const label global = allPointLabels[rank][vertex];
                if (placeOf.insert(global, points.size()))
                {
                    points.append(allPoints[rank][vertex]);
                }
                vertex = placeOf[global];
            }
            faces_[place] = f;
        }
        points_ = pointField(points);
        nPoints_ = points_.size();

        forAll(allPointLabels, rank)
        {
            places[rank].resize(allPointLabels[rank].size());
            forAll(allPointLabels[rank], i)
            {
                places[rank][i] = placeOf[allPointLabels[rank][i]];
            }
        }
    }
    fsi::share(nPoints_);
    fsi::share(places);
    for (labelList& ofPatch : pointPlaces_)
    {
        ofPatch = labelList(UIndirectList<label>(places[me], ofPatch));
    }
}


Foam::vectorField
Foam::fsi::wallInterface::scatter(vectorField& onWire) const
{
    fsi::share(onWire);
    DynamicList<vector> atPoints;
    for (const labelList& ofPatch : pointPlaces_)
    {
        atPoints.append(vectorField(onWire, ofPatch));
    }
    return vectorField(atPoints);
}


Foam::vectorField Foam::fsi::wallInterface::part
(
    const vectorField& atPoints,
    const label which
) const
{
    label start = 0;
    for (label i = 0; i < which; ++i)
    {
        start += pointPlaces_[i].size();
    }
    return SubField<vector>(atPoints, pointPlaces_[which].size(), start);
}


Foam::vectorField
Foam::fsi::wallInterface::gather(const vectorField& atFaces) const
{
    List<vectorField> all(Pstream::nProcs());
    all[Pstream::myProcNo()] = atFaces;
    Pstream::gatherList(all);

    vectorField onWire(faces_.size());
    if (Pstream::master())
    {
        forAll(all, rank)
        {
            UIndirectList<vector>(onWire, facePlaces_[rank]) = all[rank];
        }
    }
    return onWire;
}


// ************************************************************************* //
