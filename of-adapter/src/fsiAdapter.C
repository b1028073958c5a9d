/*---------------------------------------------------------------------------*\
    fsi-driver: adapter for OpenFOAM
\*---------------------------------------------------------------------------*/

#include "fsiAdapter.H"
#include "fsiCompatibility.H"
#include "fsiMeasure.H"
#include "fsiTimeScheme.H"
#include "fsiMotionFvMesh.H"
#include "addToRunTimeSelectionTable.H"
#include "directionMixedFvPatchFields.H"
#include "foamVersion.H"
#include "mixedFvPatchFields.H"
#include "turbulentTransportModel.H"
#include "volFields.H"

#include <signal.h>
#include <sys/prctl.h>

namespace Foam
{
namespace functionObjects
{
    defineTypeNameAndDebug(fsiAdapter, 0);
    addToRunTimeSelectionTable(functionObject, fsiAdapter, dictionary);
}
}

namespace
{

using namespace Foam;

//- Errors must end the solver. The list of function objects would make
//  warnings of those that are met while it constructs one.
const Time& strictly(const Time& time)
{
    FatalError.dontThrowExceptions();
    FatalIOError.dontThrowExceptions();

    if (foamVersion::api != OPENFOAM)
    {
        FatalErrorInFunction
            << "This adapter was built for OpenFOAM " << OPENFOAM
            << ", but runs in " << foamVersion::api
            << "; run of-adapter/setup.sh" << exit(FatalError);
    }
    if (Pstream::parRun())
    {
        // A rank must not outlive mpirun, not even if that is killed
        ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    }
    return time;
}


fsiMotionFvMesh& meshOf(const Time& time)
{
    if (!time.foundObject<fsiMotionFvMesh>(polyMesh::defaultRegion))
    {
        FatalErrorInFunction
            << "fsiAdapter needs 'dynamicFvMesh fsiMotionFvMesh;' in"
            << " constant/dynamicMeshDict" << exit(FatalError);
    }
    return time.lookupObjectRef<fsiMotionFvMesh>(polyMesh::defaultRegion);
}

//- Brings viscosities to what they were when the fields were written.
//  Conditions such as inletOutlet are read without the share of the patch that
//  flows in, on which the gradient there depends; the models have been made
//  with that.
void settleModels(const fvMesh& mesh)
{
    auto& U = mesh.lookupObjectRef<volVectorField>("U");
    for (fvPatchVectorField& patch : U.boundaryFieldRef())
    {
        if
        (
            isA<mixedFvPatchVectorField>(patch)
         || isA<directionMixedFvPatchVectorField>(patch)
        )
        {
            patch.evaluate();
        }
    }
    auto& model = mesh.lookupObjectRef<incompressible::turbulenceModel>
    (
        turbulenceModel::propertiesName
    );
    const_cast<transportModel&>(model.transport()).correct();
    model.validate();
}

} // End anonymous namespace


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

Foam::functionObjects::fsiAdapter::fsiAdapter
(
    const word& name,
    const Time& time,
    const dictionary& dict
)
:
    functionObject(name),
    time_(const_cast<Time&>(strictly(time))),
    mesh_(meshOf(time)),
    openings_(patches(dict)),
    session_(mesh_, mesh_.referencePoints(), openings_, dict)
{
    // The driver says when the run ends
    time_.setEndTime(GREAT);
    fsi::restoreMeshFlux(mesh_);
    settleModels(mesh_);
    awaitStep();
}


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

Foam::labelList Foam::functionObjects::fsiAdapter::patches
(
    const dictionary& dict
) const
{
    const wordList names
    (
        dict.getOrDefault<wordList>("openings", {"inlet", "outlet"})
    );
    labelList indices(names.size());
    forAll(names, i)
    {
        indices[i] = mesh_.boundaryMesh().findPatchID(names[i]);
        if (indices[i] < 0)
        {
            FatalIOErrorInFunction(dict)
                << "The mesh has no patch '" << names[i]
                << "', one of the openings; it has "
                << mesh_.boundaryMesh().names() << exit(FatalIOError);
        }
    }
    return indices;
}


void Foam::functionObjects::fsiAdapter::awaitStep()
{
    if (session_.awaitStep())
    {
        time_.setDeltaT(session_.opening().timeStep);
    }
    else
    {
        Info<< "fsi: the driver ends the run" << nl << endl;
        time_.setEndTime(time_.value());
    }
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

bool Foam::functionObjects::fsiAdapter::execute()
{
    if (session_.writeRequested())
    {
        fsi::writeFirstOldFields(mesh_);
        time_.writeNow();
    }
    session_.report
    (
        fsi::measure
        (
            mesh_,
            session_.interface().patches(),
            openings_,
            session_.density()
        )
    );

    // Continue from the time as it is spelt in the names of the written
    // folders, so that a restart, which knows no other, computes the same.
    scalar spelt;
    if (readScalar(time_.timeName(), spelt))
    {
        time_.setTime(spelt, time_.timeIndex());
    }
    awaitStep();
    return true;
}


// ************************************************************************* //
