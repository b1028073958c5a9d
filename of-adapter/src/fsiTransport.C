/*---------------------------------------------------------------------------*\
    fsi-driver: adapter for OpenFOAM
\*---------------------------------------------------------------------------*/

#include "fsiTransport.H"

Foam::autoPtr<Foam::fsi::transport>
Foam::fsi::transport::New(const dictionary& dict)
{
    const word kind(dict.get<word>("transport"));
    const fileName address(dict.get<fileName>("address"));

    if (kind == "socket")
    {
        return autoPtr<transport>(new socketTransport(address));
    }
    if (kind == "files")
    {
        return autoPtr<transport>
        (
            new fileTransport(address, dict.get<label>("driver"))
        );
    }
    throw protocolError
    (
        "transport is '" + kind + "', allowed are 'socket' and 'files'"
    );
}


// ************************************************************************* //
