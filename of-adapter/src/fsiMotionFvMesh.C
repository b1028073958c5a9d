/*---------------------------------------------------------------------------*\
    fsi-driver: adapter for OpenFOAM
\*---------------------------------------------------------------------------*/

#include "fsiMotionFvMesh.H"
#include "fsiCompatibility.H"
#include "fsiAgglomeration.H"
#include "fsiMeasure.H"
#include "fsiViscosityModel.H"
#include "addToRunTimeSelectionTable.H"
#include "displacementMotionSolver.H"
#include "fvcMeshPhi.H"
#include "fixedValuePointPatchFields.H"
#include "solverPerformance.H"
#include "profiling.H"
#include "surfaceFields.H"
#include "Tuple2.H"
#include "volFields.H"

#include <sstream>

namespace Foam
{
    defineTypeNameAndDebug(fsiMotionFvMesh, 0);
    addToRunTimeSelectionTable(dynamicFvMesh, fsiMotionFvMesh, IOobject);
}

namespace
{
    //- More outer correctors than any step takes
    const Foam::label unlimited = 1000000000;

    //- Share of the flow that a step may lose
    const Foam::scalar mostImbalance = 5e-5;

    //- The length of the present step as the next one will remember it, which
    //  Time lays down when a step begins
    struct presentStep
    :
        public Foam::TimeState
    {
        static Foam::scalar& length(Foam::Time& clock)
        {
            return clock.*(&presentStep::deltaTSave_);
        }
    };

    struct keepOld
    {
        template<class Field>
        static void act(Field& field)
        {
            field.oldTime();
        }
    };

    struct returnToOld
    {
        template<class Field>
        static void act(Field& field)
        {
            field == field.oldTime();
        }
    };

    template<class Action, class Field>
    void applyTo(const Foam::fvMesh& mesh)
    {
        for (const Foam::word& name : mesh.sortedNames<Field>())
        {
            // Old fields are out of reach of trials; the mesh's motion follows
            // from the points
            if (!name.ends_with("_0") && name != "meshPhi")
            {
                Action::act(mesh.lookupObjectRef<Field>(name));
            }
        }
    }

    //- Does something with each registered field: velocity, pressure and
    //  fluxes, but also the viscosity and all that models of turbulence,
    //  viscosity or viscoelasticity carry along
    template<class Action>
    void applyToState(const Foam::fvMesh& mesh)
    {
        applyTo<Action, Foam::volScalarField>(mesh);
        applyTo<Action, Foam::volVectorField>(mesh);
        applyTo<Action, Foam::volSphericalTensorField>(mesh);
        applyTo<Action, Foam::volSymmTensorField>(mesh);
        applyTo<Action, Foam::volTensorField>(mesh);
        applyTo<Action, Foam::surfaceScalarField>(mesh);
        applyTo<Action, Foam::surfaceVectorField>(mesh);
        applyTo<Action, Foam::surfaceSphericalTensorField>(mesh);
        applyTo<Action, Foam::surfaceSymmTensorField>(mesh);
        applyTo<Action, Foam::surfaceTensorField>(mesh);
    }
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

Foam::fsiMotionFvMesh::fsiMotionFvMesh(const IOobject& io)
:
    dynamicMotionSolverFvMesh(io),
    step_(-1),
    stepBegun_(0),
    stepCorrectors_(0),
    trialCorrectors_(0),
    solutionsBefore_(0),
    trial_(),
    phase_(phase::correcting),
    moved_(false)
{
    const dictionary& pimple = solutionDict().subDict("PIMPLE");
    if (pimple.found("residualControl"))
    {
        FatalIOErrorInFunction(pimple)
            << "residualControl would end the outer loop behind the driver's"
            << " back; remove it" << exit(FatalIOError);
    }
    setOuterCorrectors(unlimited);
    // Without this the mesh would not be asked at every corrector
    const_cast<dictionary&>(pimple).set("moveMeshOuterCorrectors", true);
    // Models of viscosity and turbulence are to be corrected in every one of
    // them, which is also where the trial is answered
    const_cast<dictionary&>(pimple).set("turbOnFinalIterOnly", false);
    fsiViscosityModel::standInForAll();
}


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

Foam::displacementMotionSolver& Foam::fsiMotionFvMesh::motionSolver()
{
    return refCast<displacementMotionSolver>
    (
        const_cast<Foam::motionSolver&>(motion())
    );
}


Foam::fsi::session& Foam::fsiMotionFvMesh::session() const
{
    if (!foundObject<fsi::session>(fsi::session::typeName))
    {
        FatalErrorInFunction
            << "The mesh is of type " << type() << ", but controlDict has no"
            << " function object of type fsiAdapter that connects to the driver"
            << exit(FatalError);
    }
    return lookupObjectRef<fsi::session>(fsi::session::typeName);
}


void Foam::fsiMotionFvMesh::setOuterCorrectors(const label n)
{
    const_cast<dictionary&>(solutionDict().subDict("PIMPLE"))
        .set("nOuterCorrectors", n);
}


void Foam::fsiMotionFvMesh::moveWall()
{
    addProfiling(motion, "fsi::moveWall");
    pointVectorField& displacement = motionSolver().pointDisplacement();
    const fsi::wallInterface& wall = session().interface();
    forAll(wall.patches(), i)
    {
        refCast<fixedValuePointPatchVectorField>
        (
            displacement.boundaryFieldRef()[wall.patches()[i]]
        ) == wall.part(trial_.displacement, i);
    }
    // Into the point values, where the motion solver looks for them
    displacement.correctBoundaryConditions();

    fsi::resetAgglomerationDirection();

    dynamicMotionSolverFvMesh::update();
    checkCells();
}


void Foam::fsiMotionFvMesh::checkCells()
{
    label inverted = 0;
    label worst = 0;
    forAll(V(), celli)
    {
        inverted += V()[celli] <= 0;
        worst = V()[celli] < V()[worst] ? celli : worst;
    }
    if (returnReduce(inverted, sumOp<label>()) == 0)
    {
        return;
    }

    // Where: on the rank that has the worst
    List<Tuple2<scalar, point>> volumes(Pstream::nProcs());
    volumes[Pstream::myProcNo()] =
        nCells() ? Tuple2<scalar, point>(V()[worst], C()[worst])
      : Tuple2<scalar, point>(GREAT, Zero);
    Pstream::gatherList(volumes);
    reduce(inverted, sumOp<label>());
    Tuple2<scalar, point> smallest(GREAT, Zero);
    for (const auto& volume : volumes)
    {
        smallest = volume.first() < smallest.first() ? volume : smallest;
    }
    const point& where = smallest.second();
    std::ostringstream text;
    text<< "the displacement turns " << inverted << " cells of the fluid's mesh"
        << " inside out, the worst near (" << where.x() << ", " << where.y()
        << ", " << where.z() << ") m at t = " << time().value()
        << " s; a smaller relaxation or time step may help";
    session().fail(text.str());
}


void Foam::fsiMotionFvMesh::storeOldState()
{
    applyToState<keepOld>(*this);
}


void Foam::fsiMotionFvMesh::restoreOldState()
{
    applyToState<returnToOld>(*this);
}


void Foam::fsiMotionFvMesh::setTimeStep(const scalar length)
{
    Time& clock = const_cast<Time&>(time());
    if (length != clock.deltaTValue())
    {
        const scalar start = clock.value() - clock.deltaTValue();
        clock.setDeltaT(length);
        presentStep::length(clock) = length;
        clock.setTime(start + length, clock.timeIndex());
    }
}


bool Foam::fsiMotionFvMesh::relaxed() const
{
    return !solutionDict().subOrEmptyDict("relaxationFactors").empty();
}


Foam::scalar Foam::fsiMotionFvMesh::imbalance() const
{
    const auto& flux = lookupObject<surfaceScalarField>("phi");
    // What the mesh sweeps by the time derivatives' own scheme
    const tmp<surfaceScalarField> swept
    (
        fvc::meshPhi(lookupObject<volVectorField>("U"))
    );
    scalar lost = 0;
    scalar through = 0;
    forAll(boundary(), patchi)
    {
        if (!boundary()[patchi].coupled())
        {
            // With what the boundary sweeps
            const scalarField outward
            (
                flux.boundaryField()[patchi] + swept().boundaryField()[patchi]
            );
            lost += sum(outward);
            through += 0.5*sumMag(outward);
        }
    }
    reduce(lost, sumOp<scalar>());
    reduce(through, sumOp<scalar>());
    return mag(lost)/max(through, VSMALL);
}


Foam::scalarList Foam::fsiMotionFvMesh::pressureResiduals() const
{
    const dictionary& all = fsi::solverReports(*this);
    if (!all.found("p"))
    {
        return scalarList();
    }
    const List<solverPerformance> solutions(all.lookup("p"));
    scalarList residuals(solutions.size());
    forAll(solutions, i)
    {
        residuals[i] = solutions[i].initialResidual();
    }
    return residuals;
}


bool Foam::fsiMotionFvMesh::trialSolved(const scalar residual) const
{
    return
        residual < trial_.pressureResidual
     || trialCorrectors_ >= trial_.maxCorrectors;
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

const Foam::pointField& Foam::fsiMotionFvMesh::referencePoints()
{
    return motionSolver().points0();
}


bool Foam::fsiMotionFvMesh::update()
{
    fsi::session& driver = session();

    if (step_ != time().timeIndex())
    {
        step_ = time().timeIndex();
        stepBegun_ = 1;
        stepCorrectors_ = 0;
        trialCorrectors_ = 0;
        solutionsBefore_ = 0;
        phase_ = phase::correcting;
        setOuterCorrectors(unlimited);
        trial_ = driver.opening();
        storeOldState();
        // Even if the wall rests: this is what makes the old volumes those
        // of the step before
        moveWall();
        return true;
    }

    if (stepBegun_++ != stepCorrectors_ && phase_ != phase::accepted)
    {
        driver.fail
        (
            "the solver does not correct its viscosity model after the pressure"
            " equation, as pimpleFoam does, so that nothing is known of the"
            " end of its correctors; use pimpleFoam"
        );
    }
    if (phase_ != phase::nextTrial)
    {
        return false;
    }
    phase_ = phase::correcting;
    if (trial_.fromOldState)
    {
        setTimeStep(trial_.timeStep);
        restoreOldState();
    }
    if (moved_ || trial_.fromOldState)
    {
        moveWall();
    }
    return moved_;
}


void Foam::fsiMotionFvMesh::endCorrector()
{
    // Models are corrected outside of steps as well, when a run starts
    if (step_ != time().timeIndex() || phase_ == phase::accepted)
    {
        return;
    }
    fsi::session& driver = session();

    ++stepCorrectors_;
    ++trialCorrectors_;
    const scalarList residuals(pressureResiduals());
    const scalar residual =
        solutionsBefore_ < residuals.size() ? residuals[solutionsBefore_] : 0;
    solutionsBefore_ = fsi::reportNext(*this, "p", residuals.size());
    if (!trialSolved(residual))
    {
        return;
    }

    const fsi::command next = driver.answer
    (
        fsi::wallTraction(*this, driver.interface().patches(), driver.density()),
        trialCorrectors_,
        residual
    );
    switch (next.kind)
    {
        case fsi::messageKind::solve:
            moved_ = returnReduce
            (
                next.displacement != trial_.displacement,
                orOp<bool>()
            );
            trial_ = next;
            trialCorrectors_ = 0;
            phase_ = phase::nextTrial;
            break;

        case fsi::messageKind::accept:
            phase_ = phase::accepted;
            setOuterCorrectors(stepCorrectors_);
            if (relaxed() || imbalance() > mostImbalance)
            {
                setOuterCorrectors(stepCorrectors_ + 1);
                fsi::announceFinalIteration(*this);
            }
            break;

        default:
            Info<< "fsi: the driver stopped the run within a time step" << endl;
            UPstream::exit(0);
    }
}


// ************************************************************************* //
