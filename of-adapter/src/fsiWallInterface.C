/*---------------------------------------------------------------------------*\
    fsi-driver: adapter for OpenFOAM
\*---------------------------------------------------------------------------*/

#include "fsiWallInterface.H"
#include "labelIOList.H"
#include "Map.H"
#include "Pstream.H"

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


Foam::fsi::wallInterface::wallInterface
(
    const polyMesh& mesh,
    const word& patchName,
    const pointField& referencePoints
)
:
    patch_(mesh.boundaryMesh().findPatchID(patchName)),
    nPoints_(0)
{
    if (patch_ < 0)
    {
        FatalErrorInFunction
            << "The mesh has no patch '" << patchName << "'; it has "
            << mesh.boundaryMesh().names() << exit(FatalError);
    }
    const polyPatch& pp = mesh.boundaryMesh()[patch_];

    // Labels of this rank's patch in the undecomposed mesh
    labelList pointLabels(pp.meshPoints());
    labelList faceLabels(pp.size());
    forAll(pp, i)
    {
        faceLabels[i] = pp.start() + i;
    }
    if (Pstream::parRun())
    {
        const labelList ofPoint(addressing(mesh, "pointProcAddressing"));
        const labelList ofFace(addressing(mesh, "faceProcAddressing"));
        pointLabels = labelList(UIndirectList<label>(ofPoint, pointLabels));
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
    allPoints[me] = pointField(UIndirectList<point>(referencePoints, pp.meshPoints()));
    allFaces[me] = pp.localFaces();
    Pstream::gatherList(allPointLabels);
    Pstream::gatherList(allFaceLabels);
    Pstream::gatherList(allPoints);
    Pstream::gatherList(allFaces);

    List<labelList> pointPlaces(Pstream::nProcs());
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

        facePlaces_.setSize(Pstream::nProcs());
        forAll(allFaces, rank)
        {
            facePlaces_[rank].setSize(allFaces[rank].size());
        }

        Map<label> places(2*labels.size());
        DynamicList<point> points;
        faces_.setSize(order.size());
        faceCentres_.setSize(order.size());
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
                if (places.insert(global, points.size()))
                {
                    points.append(allPoints[rank][vertex]);
                }
                vertex = places[global];
            }
            faces_[place] = f;
        }
        points_ = pointField(points);
        nPoints_ = points_.size();

        forAll(allPointLabels, rank)
        {
            pointPlaces[rank].setSize(allPointLabels[rank].size());
            forAll(allPointLabels[rank], i)
            {
                pointPlaces[rank][i] = places[allPointLabels[rank][i]];
            }
        }
    }
    Pstream::scatter(nPoints_);
    Pstream::scatter(pointPlaces);
    pointPlaces_ = pointPlaces[me];
}


Foam::vectorField
Foam::fsi::wallInterface::scatter(vectorField& onWire) const
{
    Pstream::scatter(onWire);
    return vectorField(UIndirectList<vector>(onWire, pointPlaces_));
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
