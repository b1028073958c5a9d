/*---------------------------------------------------------------------------*\
    fsi-driver: adapter for OpenFOAM
\*---------------------------------------------------------------------------*/

#include "fsiSession.H"
#include "fsiCompatibility.H"
#include "Time.H"
#include "fsiMeasure.H"
#include "volFields.H"

#include <cstdio>

namespace Foam
{
namespace fsi
{
    defineTypeNameAndDebug(session, 0);
}
}

namespace
{

// Bits of the flags on the wire
constexpr uint32_t fromOldStateFlag = 1;
constexpr uint32_t writeFlag = 1;

std::string digits(const Foam::scalar value)
{
    char text[40];
    std::snprintf(text, sizeof(text), "%.17g", value);
    return text;
}

uint32_t flags(const uint32_t value, const uint32_t known)
{
    if (value & ~known)
    {
        throw Foam::fsi::protocolError
        (
            "the driver set flags that this version does not know: "
          + std::to_string(value)
        );
    }
    return value;
}

//- One patch or a list of them
Foam::wordList walls(const Foam::dictionary& dict)
{
    return
        dict.found("walls") ? dict.get<Foam::wordList>("walls")
      : Foam::wordList(1, dict.get<Foam::word>("wall"));
}

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

void Foam::fsi::session::fail(const std::string& why)
{
    if (!Pstream::master())
    {
        // The master ends this rank as well, once the driver knows
        label never = 0;
        fsi::share(never);
    }
    if (transport_)
    {
        try
        {
            transport_->send(messageWriter(messageKind::failure).text(why).finish());
        }
        catch (const std::exception&)
        {
            // The driver cannot be reached: the log has to do
        }
    }
    FatalError.dontThrowExceptions();
    FatalErrorInFunction << "fsi-driver: " << why.c_str() << exit(FatalError);
}


template<class Action>
void Foam::fsi::session::guarded(const Action& action)
{
    if (!Pstream::master())
    {
        return;
    }
    try
    {
        action();
    }
    catch (const std::exception& error)
    {
        fail(error.what());
    }
}


void Foam::fsi::session::send(const messageWriter& message)
{
    guarded([&]() { transport_->send(message.finish()); });
}


void Foam::fsi::session::shakeHands
(
    const fvMesh& mesh,
    const scalar volume,
    const labelList& openings,
    const boolList& hasModel
)
{
    const scalar startTime = mesh.time().value();
    const scalar timeStep = mesh.time().deltaTValue();
    const pointField& points = interface_.points();
    const faceList& faces = interface_.faces();

    uint32_t nVertices = 0;
    for (const face& f : faces)
    {
        nVertices += f.size();
    }

    messageWriter hello(messageKind::hello);
    // The driver has made the mesh and knows which part of it is rigid
    hello.f64(startTime).f64(timeStep).f64(volume).f64(0);
    hello.u32(points.size()).u32(faces.size()).u32(nVertices);
    hello.u32(openings.size());
    hello.vectors(points);
    for (const face& f : faces)
    {
        hello.u32(f.size());
    }
    for (const face& f : faces)
    {
        for (const label vertex : f)
        {
            hello.u32(vertex);
        }
    }
    hello.vectors(interface_.faceCentres());
    forAll(openings, i)
    {
        const word& name = mesh.boundaryMesh()[openings[i]].name();
        hello.u32(hasModel[i] ? hasModelFlag : 0);
        hello.u32(name.size()).text(name);
    }
    transport_->send(hello.finish());

    const message reply = transport_->receive
    (
        [](const frame& head)
        {
            const bool welcome =
                head.kind == messageKind::welcome && head.length == 24;
            const bool failure =
                head.kind == messageKind::failure
             && head.length <= maxFailureText;
            if (!welcome && !failure)
            {
                throw protocolError
                (
                    std::string("expected the driver's WELCOME of 24 bytes,"
                    " found ") + nameOf(head.kind) + " of "
                  + std::to_string(head.length)
                );
            }
        }
    );
    if (reply.kind == messageKind::failure)
    {
        throw protocolError("the driver refuses: " + reply.payload);
    }

    messageReader reader(reply.payload);
    const scalar itsStart = reader.f64("start time");
    const scalar itsStep = reader.f64("time step");
    const uint32_t itsPoints = reader.u32();
    const uint32_t itsFaces = reader.u32();

    std::string differs;
    if (mag(itsStart - startTime) > 1e-6*timeStep)
    {
        differs += " start time " + digits(itsStart) + " s there, "
          + digits(startTime) + " s here;";
    }
    if (mag(itsStep - timeStep) > 1e-9*timeStep)
    {
        differs += " time step " + digits(itsStep) + " s there, "
          + digits(timeStep) + " s here;";
    }
    if (itsPoints != uint32_t(points.size()))
    {
        differs += " " + std::to_string(itsPoints) + " points there, "
          + std::to_string(points.size()) + " here;";
    }
    if (itsFaces != uint32_t(faces.size()))
    {
        differs += " " + std::to_string(itsFaces) + " faces there, "
          + std::to_string(faces.size()) + " here;";
    }
    if (!differs.empty())
    {
        throw protocolError("driver and fluid do not fit:" + differs);
    }
}


void Foam::fsi::session::check(const frame& head, const bool stepOpen) const
{
    uint64_t expected = 0;
    bool welcome = false;
    switch (head.kind)
    {
        case messageKind::solve:
            welcome = true;
            expected = 24 + 24*uint64_t(interface_.points().size());
            break;

        case messageKind::accept:
            welcome = stepOpen;
            expected = 4;
            break;

        case messageKind::stop:
            welcome = true;
            break;

        case messageKind::failure:
            welcome = true;
            expected = min(head.length, maxFailureText);
            break;

        default:
            break;
    }
    if (!welcome)
    {
        throw protocolError
        (
            std::string("the driver sent ") + nameOf(head.kind)
          + (stepOpen ? " within a time step" : " between two time steps")
        );
    }
    if (head.length != expected)
    {
        throw protocolError
        (
            std::string("the driver's ") + nameOf(head.kind) + " has "
          + std::to_string(head.length) + " bytes, expected "
          + std::to_string(expected)
        );
    }
}


Foam::fsi::command Foam::fsi::session::decode(const bool stepOpen)
{
    const message received = transport_->receive
    (
        [&](const frame& head) { check(head, stepOpen); }
    );
    messageReader reader(received.payload);

    command wanted{received.kind, 0, false, 0, 0, vectorField(), false};
    switch (received.kind)
    {
        case messageKind::solve:
        {
            const uint32_t correctors = reader.u32();
            wanted.maxCorrectors = min(correctors, uint32_t(1000));
            wanted.fromOldState =
                flags(reader.u32(), fromOldStateFlag) & fromOldStateFlag;
            wanted.pressureResidual = reader.f64("pressure residual");
            wanted.timeStep = reader.f64("time step");
            wanted.displacement =
                reader.vectors(interface_.points().size(), "displacement");
            if (correctors == 0 || wanted.timeStep <= 0)
            {
                throw protocolError
                (
                    "the driver asked for " + std::to_string(correctors)
                  + " correctors and a time step of "
                  + digits(wanted.timeStep)
                  + " s; at least one, and more than 0 s, are needed"
                );
            }
            if
            (
                stepOpen
             && !wanted.fromOldState
             && wanted.timeStep != time().deltaTValue()
            )
            {
                throw protocolError
                (
                    "the driver changed the length of an open time step"
                    " without going back to its beginning, from "
                  + digits(time().deltaTValue()) + " s to "
                  + digits(wanted.timeStep) + " s"
                );
            }
            break;
        }
        case messageKind::accept:
            wanted.write = flags(reader.u32(), writeFlag) & writeFlag;
            break;

        case messageKind::failure:
            throw protocolError("the driver ended: " + received.payload);

        default:
            break;
    }
    return wanted;
}


Foam::fsi::command Foam::fsi::session::receive(const bool stepOpen)
{
    command wanted;
    guarded([&]() { wanted = decode(stepOpen); });

    // To all ranks in one piece; numbers this small are exact as scalars
    scalarList numbers
    ({
        scalar(wanted.kind),
        scalar(wanted.maxCorrectors),
        scalar(wanted.fromOldState),
        wanted.pressureResidual,
        wanted.timeStep,
        scalar(wanted.write)
    });
    fsi::share(numbers);
    wanted.kind = static_cast<messageKind>(label(numbers[0]));
    wanted.maxCorrectors = label(numbers[1]);
    wanted.fromOldState = numbers[2] > 0.5;
    wanted.pressureResidual = numbers[3];
    wanted.timeStep = numbers[4];
    wanted.write = numbers[5] > 0.5;
    if (wanted.kind == messageKind::solve)
    {
        wanted.displacement = interface_.scatter(wanted.displacement);
    }
    return wanted;
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

Foam::fsi::session::session
(
    const fvMesh& mesh,
    const pointField& referencePoints,
    const labelList& openings,
    const dictionary& dict
)
:
    regIOobject
    (
        IOobject
        (
            typeName,
            mesh.time().timeName(),
            mesh,
            IOobject::NO_READ,
            IOobject::NO_WRITE
        )
    ),
    interface_(mesh, walls(dict), referencePoints),
    density_(dict.get<scalar>("density")),
    transport_(),
    opening_(),
    writeRequested_(false)
{
    const scalar volume = gSum(mesh.V());
    boolList hasModel(openings.size());
    forAll(openings, i)
    {
        hasModel[i] = modelBehind(mesh, openings[i]) != nullptr;
    }
    guarded
    (
        [&]()
        {
            transport_ = transport::New(dict);
            shakeHands(mesh, volume, openings, hasModel);
        }
    );
    Info<< "fsi: connected to the driver" << nl << endl;
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

bool Foam::fsi::session::awaitStep()
{
    opening_ = receive(false);
    return opening_.kind == messageKind::solve;
}


Foam::fsi::command Foam::fsi::session::answer
(
    const vectorField& tractions,
    const label correctors,
    const scalar pressureResidual
)
{
    messageWriter solved(messageKind::solved);
    solved.u32(correctors).u32(0).f64(time().value()).f64(pressureResidual);
    solved.vectors(interface_.gather(tractions));
    send(solved);

    const command wanted(receive(true));
    writeRequested_ = wanted.write;
    return wanted;
}


bool Foam::fsi::session::writeRequested()
{
    const bool requested = writeRequested_;
    writeRequested_ = false;
    return requested;
}


void Foam::fsi::session::report(const stepReport& step)
{
    messageWriter accepted(messageKind::accepted);
    accepted.f64(step.time).f64(step.volume).f64(step.wallVelocityMismatch);
    for (const openingReport& opening : step.openings)
    {
        accepted.f64(opening.flow).f64(opening.meanPressure);
        accepted.f64(opening.modelPressure);
    }
    accepted.vectors(interface_.gather(step.viscousTractions));
    send(accepted);
}


// ************************************************************************* //
