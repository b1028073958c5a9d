/*---------------------------------------------------------------------------*\
    fsi-driver: adapter for OpenFOAM
\*---------------------------------------------------------------------------*/

#include "flowSplitVelocityFvPatchVectorField.H"
#include "addToRunTimeSelectionTable.H"
#include "fvPatchFieldMapper.H"
#include "volFields.H"

// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

#define CLASS Foam::flowSplitVelocityFvPatchVectorField
#define CONSTRUCTOR flowSplitVelocityFvPatchVectorField

CLASS::CONSTRUCTOR
(
    const fvPatch& p,
    const DimensionedField<vector, volMesh>& iF
)
:
    fixedValueFvPatchVectorField(p, iF),
    fraction_(0),
    inlets_()
{}


CLASS::CONSTRUCTOR
(
    const fvPatch& p,
    const DimensionedField<vector, volMesh>& iF,
    const dictionary& dict
)
:
    fixedValueFvPatchVectorField(p, iF, dict, false),
    fraction_(dict.get<scalar>("fraction")),
    inlets_(dict.get<wordList>("inlets"))
{
    if (fraction_ < 0 || fraction_ > 1)
    {
        FatalIOErrorInFunction(dict)
            << "A flow split needs a fraction from 0 to 1; found " << fraction_
            << exit(FatalIOError);
    }
    for (const word& name : inlets_)
    {
        if (p.boundaryMesh().findPatchID(name) < 0)
        {
            FatalIOErrorInFunction(dict)
                << "The mesh has no patch '" << name
                << "', one of the inlets; it has "
                << p.boundaryMesh().mesh().boundaryMesh().names()
                << exit(FatalIOError);
        }
    }
    if (dict.found("value"))
    {
        fvPatchField<vector>::operator=(vectorField("value", dict, p.size()));
    }
    else
    {
        fvPatchField<vector>::operator=(vector::zero);
    }
}


CLASS::CONSTRUCTOR
(
    const CONSTRUCTOR& other,
    const fvPatch& p,
    const DimensionedField<vector, volMesh>& iF,
    const fvPatchFieldMapper& mapper
)
:
    fixedValueFvPatchVectorField(other, p, iF, mapper),
    fraction_(other.fraction_),
    inlets_(other.inlets_)
{}


CLASS::CONSTRUCTOR
(
    const CONSTRUCTOR& other,
    const DimensionedField<vector, volMesh>& iF
)
:
    fixedValueFvPatchVectorField(other, iF),
    fraction_(other.fraction_),
    inlets_(other.inlets_)
{}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

Foam::scalar CLASS::inflow() const
{
    const auto& U =
        db().lookupObject<volVectorField>(internalField().name());
    scalar flow = 0;
    for (const word& name : inlets_)
    {
        const fvPatchVectorField& inlet =
            U.boundaryField()[patch().boundaryMesh().findPatchID(name)];
        flow -= gSum(inlet & inlet.patch().Sf());
    }
    return flow;
}


void CLASS::updateCoeffs()
{
    if (updated())
    {
        return;
    }
    const scalar flow = fraction_*inflow();
    operator==(flow/gSum(patch().magSf())*patch().nf());
    fixedValueFvPatchVectorField::updateCoeffs();
}


void CLASS::write(Ostream& os) const
{
    fvPatchVectorField::write(os);
    os.writeEntry("fraction", fraction_);
    os.writeEntry("inlets", inlets_);
    writeEntry("value", os);
}


namespace Foam
{
    makePatchTypeField
    (
        fvPatchVectorField,
        flowSplitVelocityFvPatchVectorField
    );
}

// ************************************************************************* //
