/*---------------------------------------------------------------------------*\
    fsi-driver: adapter for OpenFOAM
\*---------------------------------------------------------------------------*/

#include "fsiTransport.H"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <signal.h>
#include <sstream>
#include <sys/stat.h>
#include <unistd.h>

namespace
{

std::string numbered(const uint64_t n, const char* ending)
{
    char name[32];
    std::snprintf(name, sizeof(name), "%08llu.%s", (unsigned long long) n, ending);
    return name;
}

//- Start of a process in clock ticks since boot: field 22 of its stat file,
//  counted from the end of the name (which may contain blanks)
std::string startOf(const int process)
{
    std::ifstream file("/proc/" + std::to_string(process) + "/stat");
    std::string line;
    std::getline(file, line);
    const auto end = line.rfind(')');
    if (end == std::string::npos)
    {
        return "";
    }
    std::istringstream rest(line.substr(end + 1));
    std::string field;
    for (int i = 3; i <= 22; ++i)
    {
        rest >> field;
    }
    return field;
}

} // End anonymous namespace


Foam::fsi::fileTransport::fileTransport
(
    const fileName& folder,
    const int driver
)
:
    folder_(folder),
    sent_(0),
    received_(0),
    driver_(driver),
    driverStart_(startOf(driver))
{}


bool Foam::fsi::fileTransport::driverAlive() const
{
    return !driverStart_.empty() && startOf(driver_) == driverStart_;
}


void Foam::fsi::fileTransport::send(const std::string& bytes)
{
    const fileName path(folder_/numbered(++sent_, "fluid"));
    const fileName partial(path + ".partial");
    {
        std::ofstream file(partial, std::ios::binary);
        file.write(bytes.data(), bytes.size());
        file.close();
        if (!file)
        {
            throw protocolError("cannot write " + partial);
        }
    }
    // The driver looks for the final name only, which appears with the last
    // byte already in place.
    if (::rename(partial.c_str(), path.c_str()) != 0)
    {
        throw protocolError
        (
            "cannot name " + path + ": " + std::strerror(errno)
        );
    }
}


Foam::fsi::message Foam::fsi::fileTransport::receive(const frameCheck& check)
{
    const fileName path(folder_/numbered(++received_, "driver"));

    struct stat status;
    unsigned pause = 50; // microseconds
    while (::stat(path.c_str(), &status) != 0)
    {
        ::usleep(pause);
        // Quick answers are met quickly, long waits cost next to nothing
        pause = pause < 5000 ? pause + pause/4 : 5000;
        if (pause == 5000 && !driverAlive())
        {
            throw protocolError("the driver's process has ended");
        }
    }

    std::ifstream file(path, std::ios::binary);
    char bytes[frameSize];
    if (!file.read(bytes, frameSize))
    {
        throw protocolError(path + " is too short to be a message");
    }
    const frame head = decodeFrame(bytes);
    check(head);
    if (static_cast<uint64_t>(status.st_size) != frameSize + head.length)
    {
        throw protocolError
        (
            path + " has " + std::to_string(status.st_size)
          + " bytes, its frame announces "
          + std::to_string(frameSize + head.length)
        );
    }

    message result{head.kind, std::string(head.length, '\0')};
    if (!file.read(&result.payload[0], result.payload.size()))
    {
        throw protocolError("cannot read " + path);
    }
    ::unlink(path.c_str());
    return result;
}


// ************************************************************************* //
