/*---------------------------------------------------------------------------*\
    fsi-driver: adapter for OpenFOAM
\*---------------------------------------------------------------------------*/

#include "fsiWallVelocityFvPatchVectorField.H"
#include "fsiTimeScheme.H"
#include "addToRunTimeSelectionTable.H"
#include "fvPatchFieldMapper.H"
#include "fvcMeshPhi.H"
#include "surfaceFields.H"
#include "volFields.H"

// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

Foam::fsiWallVelocityFvPatchVectorField::fsiWallVelocityFvPatchVectorField
(
    const fvPatch& p,
    const DimensionedField<vector, volMesh>& iF
)
:
    fixedValueFvPatchVectorField(p, iF),
    swept_(p.size(), Zero),
    sweptBefore_(p.size(), Zero),
    known_(false),
    knownBefore_(false),
    startIndex_(db().time().timeIndex()),
    timeIndex_(startIndex_)
{}


Foam::fsiWallVelocityFvPatchVectorField::fsiWallVelocityFvPatchVectorField
(
    const fvPatch& p,
    const DimensionedField<vector, volMesh>& iF,
    const dictionary& dict
)
:
    fixedValueFvPatchVectorField(p, iF, dict),
    swept_(p.size(), Zero),
    sweptBefore_(p.size(), Zero),
    known_(dict.found("sweptVelocity")),
    knownBefore_(false),
    startIndex_(db().time().timeIndex()),
    timeIndex_(startIndex_)
{
    if (known_)
    {
        swept_ = vectorField("sweptVelocity", dict, p.size());
    }
}


Foam::fsiWallVelocityFvPatchVectorField::fsiWallVelocityFvPatchVectorField
(
    const fsiWallVelocityFvPatchVectorField& other,
    const fvPatch& p,
    const DimensionedField<vector, volMesh>& iF,
    const fvPatchFieldMapper& mapper
)
:
    fixedValueFvPatchVectorField(other, p, iF, mapper),
    swept_(other.swept_, mapper),
    sweptBefore_(other.sweptBefore_, mapper),
    known_(other.known_),
    knownBefore_(other.knownBefore_),
    startIndex_(other.startIndex_),
    timeIndex_(other.timeIndex_)
{}


Foam::fsiWallVelocityFvPatchVectorField::fsiWallVelocityFvPatchVectorField
(
    const fsiWallVelocityFvPatchVectorField& other,
    const DimensionedField<vector, volMesh>& iF
)
:
    fixedValueFvPatchVectorField(other, iF),
    swept_(other.swept_),
    sweptBefore_(other.sweptBefore_),
    known_(other.known_),
    knownBefore_(other.knownBefore_),
    startIndex_(other.startIndex_),
    timeIndex_(other.timeIndex_)
{}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void Foam::fsiWallVelocityFvPatchVectorField::autoMap
(
    const fvPatchFieldMapper& mapper
)
{
    fixedValueFvPatchVectorField::autoMap(mapper);
    swept_.autoMap(mapper);
    sweptBefore_.autoMap(mapper);
}


void Foam::fsiWallVelocityFvPatchVectorField::rmap
(
    const fvPatchVectorField& field,
    const labelList& addressing
)
{
    fixedValueFvPatchVectorField::rmap(field, addressing);
    const auto& other = refCast<const fsiWallVelocityFvPatchVectorField>(field);
    swept_.rmap(other.swept_, addressing);
    sweptBefore_.rmap(other.sweptBefore_, addressing);
    known_ = other.known_;
    knownBefore_ = other.knownBefore_;
}


void Foam::fsiWallVelocityFvPatchVectorField::advance()
{
    const label now = db().time().timeIndex();
    if (timeIndex_ != now)
    {
        sweptBefore_ = swept_;
        knownBefore_ = known_;
        timeIndex_ = now;
    }
}


Foam::vectorField
Foam::fsiWallVelocityFvPatchVectorField::faceVelocity() const
{
    const Time& time = db().time();
    if (!knownBefore_ || !fsi::isBackward(internalField().mesh()))
    {
        return swept_;
    }
    // The weights of backwardDdtScheme::meshPhi
    const scalar before =
        time.deltaTValue()/(time.deltaTValue() + time.deltaT0Value());
    return (1 + before)*swept_ - before*sweptBefore_;
}


void Foam::fsiWallVelocityFvPatchVectorField::updateCoeffs()
{
    if (updated())
    {
        return;
    }
    const fvMesh& mesh = internalField().mesh();
    const Time& time = db().time();
    if (mesh.moving() && time.timeIndex() != startIndex_)
    {
        advance();
        const fvPatch& p = patch();
        const pointField& oldPoints = mesh.oldPoints();
        vectorField oldCentres(p.size());
        forAll(oldCentres, i)
        {
            oldCentres[i] = p.patch()[i].centre(oldPoints);
        }
        swept_ = (p.patch().faceCentres() - oldCentres)/time.deltaTValue();
        known_ = true;

        const auto& U = static_cast<const volVectorField&>(internalField());
        const scalarField flux
        (
            p.patchField<surfaceScalarField, scalar>(fvc::meshPhi(U))
        );
        const vectorField n(p.nf());
        const scalarField normal(flux/(p.magSf() + VSMALL));
        const vectorField velocity(faceVelocity());
        vectorField::operator=(velocity + n*(normal - (n & velocity)));
    }

    fixedValueFvPatchVectorField::updateCoeffs();
}


void Foam::fsiWallVelocityFvPatchVectorField::write(Ostream& os) const
{
    fvPatchVectorField::write(os);
    if (known_)
    {
        swept_.writeEntry("sweptVelocity", os);
    }
    writeEntry("value", os);
}


namespace Foam
{
    makePatchTypeField
    (
        fvPatchVectorField,
        fsiWallVelocityFvPatchVectorField
    );
}


// ************************************************************************* //
