/*---------------------------------------------------------------------------*\
    fsi-driver: adapter for OpenFOAM
\*---------------------------------------------------------------------------*/

#include "fsiProtocol.H"

#include <cmath>
#include <cstring>

// In Foam::fsi, whose names come first: Foam has a function get, too, from 2606
// on.
namespace Foam
{
namespace fsi
{
namespace
{

const char magic[4] = {'F', 'S', 'I', 'P'};

// Bytes are shifted rather than copied: the order on the wire is little-endian
// on every machine. Compilers make a plain move of it where that is the same.

void put(std::string& bytes, uint64_t value, const int n)
{
    for (int i = 0; i < n; ++i)
    {
        bytes.push_back(static_cast<char>(value & 0xff));
        value >>= 8;
    }
}

uint64_t get(const char* bytes, const int n)
{
    uint64_t value = 0;
    for (int i = n - 1; i >= 0; --i)
    {
        value = (value << 8) | static_cast<unsigned char>(bytes[i]);
    }
    return value;
}

double toDouble(const uint64_t bits)
{
    double value;
    std::memcpy(&value, &bits, sizeof(value));
    return value;
}

uint64_t toBits(const double value)
{
    uint64_t bits;
    std::memcpy(&bits, &value, sizeof(bits));
    return bits;
}

} // End anonymous namespace
} // End namespace fsi
} // End namespace Foam


// * * * * * * * * * * * * * * * * * Frame * * * * * * * * * * * * * * * * * //

const char* Foam::fsi::nameOf(const messageKind kind)
{
    switch (kind)
    {
        case messageKind::hello: return "HELLO";
        case messageKind::welcome: return "WELCOME";
        case messageKind::solve: return "SOLVE";
        case messageKind::solved: return "SOLVED";
        case messageKind::accept: return "ACCEPT";
        case messageKind::accepted: return "ACCEPTED";
        case messageKind::stop: return "STOP";
        case messageKind::failure: return "FAILURE";
        case messageKind::discard: return "DISCARD";
    }
    return "unknown";
}


Foam::fsi::frame Foam::fsi::decodeFrame(const char* bytes)
{
    if (std::memcmp(bytes, magic, sizeof(magic)) != 0)
    {
        throw protocolError("the driver sent bytes that are not a message");
    }
    const auto version = static_cast<uint16_t>(get(bytes + 4, 2));
    if (version != protocolVersion)
    {
        throw protocolError
        (
            "the driver speaks protocol version " + std::to_string(version)
          + ", this adapter speaks " + std::to_string(protocolVersion)
          + "; build both from the same source (of-adapter/setup.sh)"
        );
    }
    const auto kind = static_cast<messageKind>(get(bytes + 6, 2));
    if (std::strcmp(nameOf(kind), "unknown") == 0)
    {
        throw protocolError
        (
            "the driver sent a message of unknown kind "
          + std::to_string(static_cast<unsigned>(kind))
        );
    }
    return {kind, get(bytes + 8, 8)};
}


// * * * * * * * * * * * * * * * * * Writer  * * * * * * * * * * * * * * * * //

Foam::fsi::messageWriter::messageWriter(const messageKind kind)
:
    bytes_(magic, sizeof(magic))
{
    put(bytes_, protocolVersion, 2);
    put(bytes_, static_cast<uint16_t>(kind), 2);
    put(bytes_, 0, 8);
}


Foam::fsi::messageWriter& Foam::fsi::messageWriter::u32(const uint32_t value)
{
    put(bytes_, value, 4);
    return *this;
}


Foam::fsi::messageWriter& Foam::fsi::messageWriter::f64(const scalar value)
{
    put(bytes_, toBits(value), 8);
    return *this;
}


Foam::fsi::messageWriter&
Foam::fsi::messageWriter::vectors(const vectorField& values)
{
    for (const vector& v : values)
    {
        f64(v.x()).f64(v.y()).f64(v.z());
    }
    return *this;
}


Foam::fsi::messageWriter&
Foam::fsi::messageWriter::text(const std::string& value)
{
    bytes_ += value.substr(0, maxFailureText);
    return *this;
}


std::string Foam::fsi::messageWriter::finish() const
{
    std::string length;
    put(length, bytes_.size() - frameSize, 8);
    std::string message(bytes_);
    message.replace(8, 8, length);
    return message;
}


// * * * * * * * * * * * * * * * * * Reader  * * * * * * * * * * * * * * * * //

Foam::fsi::messageReader::messageReader(const std::string& payload)
:
    payload_(payload),
    position_(0)
{}


const char* Foam::fsi::messageReader::take(const std::size_t n)
{
    if (payload_.size() - position_ < n)
    {
        throw protocolError("the driver sent a message that ends too early");
    }
    const char* bytes = payload_.data() + position_;
    position_ += n;
    return bytes;
}


uint32_t Foam::fsi::messageReader::u32()
{
    return static_cast<uint32_t>(get(take(4), 4));
}


Foam::scalar Foam::fsi::messageReader::f64(const char* what)
{
    const double value = toDouble(get(take(8), 8));
    if (!std::isfinite(value))
    {
        throw protocolError
        (
            std::string("the driver sent a ") + what + " that is not finite"
        );
    }
    return value;
}


Foam::vectorField
Foam::fsi::messageReader::vectors(const label n, const char* what)
{
    vectorField values(n);
    for (label i = 0; i < n; ++i)
    {
        for (direction d = 0; d < vector::nComponents; ++d)
        {
            const double value = toDouble(get(take(8), 8));
            if (!std::isfinite(value))
            {
                throw protocolError
                (
                    std::string("the driver sent a ") + what + " of point "
                  + std::to_string(i) + " whose component "
                  + "xyz"[d] + " is not finite"
                );
            }
            values[i][d] = value;
        }
    }
    return values;
}


// ************************************************************************* //
