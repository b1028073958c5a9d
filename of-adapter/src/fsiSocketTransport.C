/*---------------------------------------------------------------------------*\
    fsi-driver: adapter for OpenFOAM
\*---------------------------------------------------------------------------*/

#include "fsiTransport.H"

#include <cerrno>
#include <cstring>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace
{

std::string reason()
{
    return std::strerror(errno);
}

} // End anonymous namespace


Foam::fsi::socketTransport::socketTransport(const fileName& path)
:
    descriptor_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0))
{
    sockaddr_un address;
    std::memset(&address, 0, sizeof(address));
    address.sun_family = AF_UNIX;
    if (path.size() >= sizeof(address.sun_path))
    {
        throw protocolError
        (
            "the socket's path has " + std::to_string(path.size())
          + " bytes, the system allows "
          + std::to_string(sizeof(address.sun_path) - 1) + ": " + path
        );
    }
    std::strcpy(address.sun_path, path.c_str());

    if
    (
        descriptor_ < 0
     || ::connect
        (
            descriptor_,
            reinterpret_cast<const sockaddr*>(&address),
            sizeof(address)
        ) != 0
    )
    {
        throw protocolError
        (
            "cannot connect to the driver at " + path + ": " + reason()
        );
    }
}


Foam::fsi::socketTransport::~socketTransport()
{
    ::close(descriptor_);
}


void Foam::fsi::socketTransport::send(const std::string& bytes)
{
    std::size_t done = 0;
    while (done < bytes.size())
    {
        // MSG_NOSIGNAL: a driver that has gone is an error, not a SIGPIPE
        const ssize_t n = ::send
        (
            descriptor_,
            bytes.data() + done,
            bytes.size() - done,
            MSG_NOSIGNAL
        );
        if (n < 0 && errno == EINTR) continue;
        if (n < 0)
        {
            throw protocolError("the driver does not listen: " + reason());
        }
        done += n;
    }
}


void Foam::fsi::socketTransport::readExactly(char* bytes, std::size_t n)
{
    while (n > 0)
    {
        const ssize_t got = ::recv(descriptor_, bytes, n, 0);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0)
        {
            throw protocolError("cannot hear the driver: " + reason());
        }
        if (got == 0)
        {
            throw protocolError("the driver has closed the connection");
        }
        bytes += got;
        n -= got;
    }
}


Foam::fsi::message
Foam::fsi::socketTransport::receive(const frameCheck& check)
{
    char bytes[frameSize];
    readExactly(bytes, frameSize);
    const frame head = decodeFrame(bytes);
    check(head);

    message result{head.kind, std::string(head.length, '\0')};
    readExactly(&result.payload[0], result.payload.size());
    return result;
}


// ************************************************************************* //
