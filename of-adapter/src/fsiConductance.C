/*---------------------------------------------------------------------------*\
    fsi-driver: adapter for OpenFOAM
\*---------------------------------------------------------------------------*/

#include "fsiConductance.H"
#include "syncTools.H"

// * * * * * * * * * * * * * * * * Functions * * * * * * * * * * * * * * * * //

Foam::vectorField Foam::fsi::cellCentres
(
    const fvMesh& mesh,
    const pointField& points
)
{
    const cellList& cells = mesh.cells();
    vectorField centres(cells.size());
    forAll(cells, celli)
    {
        centres[celli] = cells[celli].centre(points, mesh.faces());
    }
    return centres;
}


Foam::scalarField Foam::fsi::conductance
(
    const fvMesh& mesh,
    const pointField& points,
    const vectorField& centres
)
{
    // Where each face sees the other side: the neighbour's centre, which on a
    // coupled patch lies on another rank; else the centre of the face
    vectorField beyond;
    syncTools::swapBoundaryCellPositions(mesh, centres, beyond);

    const faceList& faces = mesh.faces();
    const polyBoundaryMesh& patches = mesh.boundaryMesh();
    scalarField result(faces.size());
    forAll(faces, facei)
    {
        const vector area(faces[facei].areaNormal(points));
        const scalar size = mag(area);
        const point& own = centres[mesh.faceOwner()[facei]];
        point other;
        if (mesh.isInternalFace(facei))
        {
            other = centres[mesh.faceNeighbour()[facei]];
        }
        else if (patches[patches.whichPatch(facei)].coupled())
        {
            other = beyond[facei - mesh.nInternalFaces()];
        }
        else
        {
            other = faces[facei].centre(points);
        }
        // Bounded as OpenFOAM does for faces far from orthogonal
        const vector d(other - own);
        result[facei] = size/max((area & d)/(size + VSMALL), 0.05*mag(d));
    }
    return result;
}


// ************************************************************************* //
