/*---------------------------------------------------------------------------*\
    fsi-driver: adapter for OpenFOAM
\*---------------------------------------------------------------------------*/

#include "fsiAgglomeration.H"
#include "pairGAMGAgglomeration.H"

namespace
{

// The variable is private, and nothing sets it. Explicit instantiation is the
// one place where the language does not ask for access rights.

struct direction
{
    friend bool* variable(direction);
};

template<bool* address>
struct open
{
    friend bool* variable(direction)
    {
        return address;
    }
};

template struct open<&Foam::pairGAMGAgglomeration::forward_>;

} // End anonymous namespace


void Foam::fsi::resetAgglomerationDirection()
{
    *variable(::direction()) = true;
}


// ************************************************************************* //
