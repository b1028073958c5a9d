/*---------------------------------------------------------------------------*\
    fsi-driver: adapter for OpenFOAM
\*---------------------------------------------------------------------------*/

#include "fsiViscosityModel.H"
#include "fsiMotionFvMesh.H"
#include "surfaceFields.H"
#include "volFields.H"

#include <type_traits>

namespace
{
    //- The selection table itself: the name of its type depends on the version
    using constructors = std::remove_pointer
    <
        decltype(Foam::viscosityModel::dictionaryConstructorTablePtr_)
    >::type;

    //- The models' own constructors by name
    constructors& own()
    {
        static constructors table;
        return table;
    }
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

Foam::fsiViscosityModel::fsiViscosityModel
(
    autoPtr<viscosityModel>&& model,
    const word& name,
    const dictionary& properties,
    const volVectorField& U,
    const surfaceScalarField& phi
)
:
    viscosityModel(name, properties, U, phi),
    model_(std::move(model))
{}


Foam::autoPtr<Foam::viscosityModel> Foam::fsiViscosityModel::selected
(
    const word& name,
    const dictionary& properties,
    const volVectorField& U,
    const surfaceScalarField& phi
)
{
    const word type(properties.get<word>("transportModel"));
    return autoPtr<viscosityModel>
    (
        new fsiViscosityModel
        (
            (*own().cfind(type))(name, properties, U, phi),
            name,
            properties,
            U,
            phi
        )
    );
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void Foam::fsiViscosityModel::standInForAll()
{
    constructors& table = *dictionaryConstructorTablePtr_;
    if (own().empty())
    {
        own() = table;
        for (const word& type : own().toc())
        {
            table.set(type, selected);
        }
    }
}


void Foam::fsiViscosityModel::correct()
{
    model_->correct();
    U_.time().lookupObjectRef<fsiMotionFvMesh>(polyMesh::defaultRegion)
        .endCorrector();
}


// ************************************************************************* //
